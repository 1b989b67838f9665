"""A positioning stage under feedback."""

import sympy as sp

from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import open_values
from symfric.model.system import Contact, System

_X, _U, _Z = sp.symbols("x u z", real=True)


@alone(SYMBOLIC)
def positioning_stage(
    law: Law | None = None,
    *,
    k_p: float,
    k_d: float,
    k_i: float,
    m: float = 1.0,
    N: float = 1.0,
    target: float = 0.0,
    x0: float = 0.1,
    compensation: float = 0.0,
    x_c: float = 1e-3,
    horizon: float = 200.0,
) -> Scene:
    r"""Mass on a guide with friction, moved to a target by a PID controller.

    Parameters
    ----------
    law : Law
        ``coulomb(1.5, 1)`` unless given; its symbols are values to be given with `where`.
    k_p, k_d, k_i : float
        Gains on the position error, on the velocity and on the integral of the error.
    m, N : float
        Mass and normal load.
    target, x0 : float
        Set point, and position at the start, at rest with an empty integrator.
    compensation, x_c : float
        Force towards the target that compensates friction, and the distance over which it builds up:
        ``compensation tanh((target - x)/x_c)``.
    horizon : float
        Length of the run.

    Returns
    -------
    Scene
        With the first-order state z, the integral of the error.

    Raises
    ------
    SceneError
        If a value is no number.

    Notes
    -----
    :math:`m x'' = -k_p(x - r) - k_d x' - k_i z - c\tanh\frac{x - r}{x_c}` + friction, :math:`z' = x - r`. A static
    friction above the kinetic one makes it hunt about the target, from starts near enough to where it would: see
    `sf.theory.hunting`.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.positioning_stage(k_p=4.0, k_d=1.0, k_i=1.0)
    >>> [s.name for s in scene.system.states]
    ['x', 'u', 'z']
    """
    law = laws.coulomb(1.5, 1.0) if law is None else law
    names = "k_p k_d k_i m N target compensation x_c"
    p, d, i, mass, load, r, c, soft = sp.symbols(names, real=True)
    force = -p * (_X - r) - d * _U - i * _Z - c * sp.tanh((_X - r) / soft)
    values = dict(zip((p, d, i, mass, load, r, c, soft), (k_p, k_d, k_i, m, N, target, compensation, x_c), strict=True))
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[mass]], force=[force], z=[_Z], z_rate=[_X - r]),
        contacts=[Contact("guide", slip=_U, normal=load, law=law)],
        values={**values, **open_values(law)},
        initial={_X: x0, _U: 0.0, _Z: 0.0},
        horizon=horizon,
    )
