"""A mass on a belt whose spring stands on a sprung foundation mass."""

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import check_range, open_values
from symfric.model.symbols import finite
from symfric.model.system import Contact, System

_X1, _X2, _U1, _U2 = sp.symbols("x1 x2 u1 u2", real=True)


@alone(SYMBOLIC)
def sprung_foundation(
    law: Law | None = None,
    *,
    mass_ratio: float,
    stiffness: float,
    damping: float,
    v_b: float = 0.0,
    main_damping: float = 0.0,
    gamma2: float = 1.0,
    horizon: float = 200.0,
) -> Scene:
    r"""Mass on a spring that stands on a foundation, which a spring and a damper hold to the ground.

    Parameters
    ----------
    law : Law, optional
        Friction between the main mass and a belt; no belt unless given.
    mass_ratio : float
        Mass of the foundation over the main mass, > 0.
    stiffness : float
        Stiffness of its mount over that of the main spring, >= 0.
    damping : float
        ``c2/(2 m1 omega1)`` of the mount, >= 0.
    v_b, gamma2 : float
        Speed of the belt, gravity over spring force, as in `mass_on_belt`.
    main_damping : float
        ``c1/(2 m1 omega1)`` of the main mass to the ground; negative where it excites itself.
    horizon : float

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Notes
    -----
    ``x1'' + 2 zeta1 x1' + x1 - x2 + gamma2 mu(x1' - v_b) = 0`` and ``mass_ratio x2'' + 2 damping x2' + stiffness x2 =
    x1 - x2``, time in units of 1/omega1. Tondl's visco-elastically mounted foundation mass, named in the introduction
    of Thomsen. Starts at rest.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.sprung_foundation(
    ...     sf.laws.cubic(0.4, 0.25, 0.5), mass_ratio=0.2, stiffness=0.5, damping=0.6, v_b=0.1
    ... )
    >>> sf.stability(scene).stable
    True
    """
    check_range({"mass_ratio": mass_ratio}, {"stiffness": stiffness, "damping": damping})
    mu, kappa, gamma, zeta1, v_b_, gamma2_ = sp.symbols(
        "mass_ratio stiffness damping main_damping v_b gamma2", real=True
    )
    values = {mu: mass_ratio, kappa: stiffness, gamma: damping, zeta1: main_damping}
    contacts = []
    if law is not None:
        contacts = [Contact("belt", slip=_U1 - v_b_, normal=gamma2_, law=law)]
        values |= {v_b_: v_b, gamma2_: gamma2, **open_values(law)}
    elif finite(v_b, "v_b") != 0:
        raise SceneError("v_b is given without a law; give the friction between mass and belt")
    force = [-2 * zeta1 * _U1 - _X1 + _X2, _X1 - _X2 - kappa * _X2 - 2 * gamma * _U2]
    return Scene(
        system=System(q=[_X1, _X2], u=[_U1, _U2], mass=sp.diag(1, mu), force=force),
        contacts=contacts,
        values=values,
        initial=dict.fromkeys((_X1, _X2, _U1, _U2), 0.0),
        horizon=horizon,
    )
