"""A mass on a moving belt, even or wavy."""

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import open_values
from symfric.model.symbols import TIME, finite
from symfric.model.system import Contact, System

_X, _U = sp.symbols("x u", real=True)


@alone(SYMBOLIC)
def mass_on_belt(
    law: Law | None = None,
    *,
    v_b: float,
    beta: float = 0.05,
    gamma2: float = 1.0,
    a: float = 0.0,
    Omega: float = 0.0,
    horizon: float = 100.0,
) -> Scene:
    r"""Mass on a moving belt: :math:`x'' + 2\beta x' + x + \gamma^2\mu(x' - v_b) = a\Omega^2\sin\Omega t`.

    Parameters
    ----------
    law : Law
        ``cubic(.4, .25, .5)`` unless given; its symbols are values to be given with `where`.
    v_b, beta, gamma2, a, Omega : float
        Belt speed, damping ratio, gravity over spring force, amplitude and frequency of the excitation.
    horizon : float
        Length of the run.

    Returns
    -------
    Scene

    Notes
    -----
    Thomsen (1); starts at x = u = 0.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> belt
    Scene(1 coordinate, contacts: belt; v_b=0.2, beta=0.05, gamma2=1, a=0, Omega=0; horizon 100)
    >>> sf.stability(belt).stable
    False
    """
    law = laws.cubic(0.4, 0.25, 0.5) if law is None else law
    v_b_, beta_, gamma2_, a_, Omega_ = sp.symbols("v_b beta gamma2 a Omega", real=True)
    force = -2 * beta_ * _U - _X + a_ * Omega_**2 * sp.sin(Omega_ * TIME)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[1]], force=[force]),
        contacts=[Contact("belt", slip=_U - v_b_, normal=gamma2_, law=law)],
        values={v_b_: v_b, beta_: beta, gamma2_: gamma2, a_: a, Omega_: Omega, **open_values(law)},
        initial={_X: 0.0, _U: 0.0},
        horizon=horizon,
    )


@alone(SYMBOLIC)
def wavy_belt(
    law: Law | None = None,
    *,
    v_b: float,
    F: float,
    k: float,
    beta: float = 0.05,
    gamma2: float = 1.0,
    horizon: float = 100.0,
) -> Scene:
    r"""Mass on a moving belt with waves: :math:`x'' + 2\beta x' + x + \gamma^2\mu(x' - v_b) = F\sin k(x - v_b t)`.

    Parameters
    ----------
    law : Law
        ``cubic(.4, .25, .5)`` unless given; its symbols are values to be given with `where`.
    v_b, beta, gamma2 : float
        Belt speed, damping ratio, gravity over spring force, as in `mass_on_belt`.
    F, k : float
        Largest force of the waves along the belt over stiffness times unit length, >= 0; their wave number over unit
        length, > 0. Waves of height h and a load N give ``F = N h k``.
    horizon : float
        Length of the run.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If F or k is out of range.

    Notes
    -----
    Thomsen, section 5.4: surface roughness with a period in space in the place of an excitation in time. The force acts
    where the belt is under the mass, so that its frequency ``k (v_b - x')`` follows the mass, and the belt drives it.
    `symfric.theory.waviness` has its averages. Starts at x = u = 0.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.wavy_belt(v_b=0.42, F=5.0, k=100.0)
    >>> round(sf.theory.waviness.onset_speed(scene), 6)
    0.433644
    """
    law = laws.cubic(0.4, 0.25, 0.5) if law is None else law
    if finite(F, "F") < 0 or not finite(k, "k") > 0:
        raise SceneError(f"F is {F:g} and k is {k:g}; give F >= 0 and k > 0")
    v_b_, beta_, gamma2_, F_, k_ = sp.symbols("v_b beta gamma2 F k", real=True)
    force = -2 * beta_ * _U - _X + F_ * sp.sin(k_ * (_X - v_b_ * TIME))
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[1]], force=[force]),
        contacts=[Contact("belt", slip=_U - v_b_, normal=gamma2_, law=law)],
        values={v_b_: v_b, beta_: beta, gamma2_: gamma2, F_: F, k_: k, **open_values(law)},
        initial={_X: 0.0, _U: 0.0},
        horizon=horizon,
    )
