"""Free oscillators that dry friction brings to rest."""

import sympy as sp

from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.outputs import StopTime, Trajectory
from symfric.model.scene import Scene
from symfric.model.symbols import finite
from symfric.model.system import Contact, System

_X, _U = sp.symbols("x u", real=True)


@alone(SYMBOLIC)
def coulomb_oscillator(
    delta: float, *, delta_s: float | None = None, x0: float = 1.0, omega_n: float = 1.0, horizon: float | None = None
) -> Scene:
    r"""Free oscillator with Coulomb friction: :math:`x'' + \omega_n^2 (x + \Delta\,\mathrm{sgn}\,x') = 0`, from rest.

    Parameters
    ----------
    delta : float
        Friction force over stiffness, a length.
    delta_s : float, optional
        The same for static friction; `delta` unless given.
    x0 : float
        Initial displacement.
    omega_n : float
        Natural frequency.
    horizon : float, optional
        By default two half cycles beyond the stop.

    Returns
    -------
    Scene

    Notes
    -----
    Handbook section 19.5, Example 19.5; stops after ``ceil((|x0| - delta_s)/(2 delta))`` half cycles.

    Examples
    --------
    >>> import symfric as sf
    >>> run = sf.simulate(sf.scenes.coulomb_oscillator(0.1, x0=1.0))
    >>> round(run["stop_time"], 6)
    15.707963
    """
    delta_, delta_s_, omega_, x0_ = sp.symbols("delta delta_s omega_n x0", real=True)
    if horizon is None:
        delta, x0, omega_n = finite(delta, "delta"), finite(x0, "x0"), finite(omega_n, "omega_n")
        halves = abs(x0) / (2 * delta) if delta > 0 else 20.0
        horizon = float((halves + 3) * sp.pi / omega_n)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[1]], force=[-(omega_**2) * _X]),
        contacts=[Contact("floor", slip=_U, normal=omega_**2, law=laws.coulomb(delta_s_, delta_))],
        values={delta_: delta, delta_s_: delta if delta_s is None else delta_s, omega_: omega_n, x0_: x0},
        initial={_X: x0_, _U: 0.0},
        horizon=horizon,
        outputs={"path": Trajectory(), "stop_time": StopTime()},
    )
