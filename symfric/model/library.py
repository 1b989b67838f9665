"""Ready scenes of the sources; symbols carry the argument's name, so ``scene.where({"v_b": .3})`` works."""

import sympy as sp

from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.names import TIME
from symfric.model.outputs import StopTime, Trajectory
from symfric.model.scene import Scene
from symfric.model.system import Contact, System
from symfric.model.transients import contact_damper as contact_damper

_X, _U = sp.symbols("x u", real=True)


def _open(law: Law) -> dict:
    """Symbols of a law become values to be given later."""
    return dict.fromkeys(sorted(law.free_symbols, key=str))


def mass_on_belt(law=None, *, v_b, beta=0.05, gamma2=1.0, a=0.0, Omega=0.0, horizon=100.0) -> Scene:
    r"""Mass on a moving belt: :math:`x'' + 2\beta x' + x + \gamma^2\mu(x' - v_b) = a\Omega^2\sin\Omega t`.

    Parameters
    ----------
    law : Law
        ``cubic(.4, .25, .5)`` unless given; its symbols are values to be given with `where`.
    v_b, beta, gamma2, a, Omega : float
        Belt speed, damping ratio, gravity over spring force, amplitude and frequency of the excitation.
    horizon : float
        Length of the run.

    Notes
    -----
    Thomsen (1); starts at x = u = 0.
    """
    law = laws.cubic(0.4, 0.25, 0.5) if law is None else law
    v_b_, beta_, gamma2_, a_, Omega_ = sp.symbols("v_b beta gamma2 a Omega", real=True)
    force = -2 * beta_ * _U - _X + a_ * Omega_**2 * sp.sin(Omega_ * TIME)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[1]], force=[force]),
        contacts=[Contact("belt", slip=_U - v_b_, normal=gamma2_, law=law)],
        values={v_b_: v_b, beta_: beta, gamma2_: gamma2, a_: a, Omega_: Omega, **_open(law)},
        initial={_X: 0.0, _U: 0.0},
        horizon=horizon,
    )


def coulomb_oscillator(delta, *, delta_s=None, x0=1.0, omega_n=1.0, horizon=None) -> Scene:
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
        Two half cycles beyond the stop by default.

    Notes
    -----
    Handbook section 19.5, Example 19.5; stops after ``ceil((|x0| - delta_s)/(2 delta))`` half cycles.
    """
    delta_, delta_s_, omega_, x0_ = sp.symbols("delta delta_s omega_n x0", real=True)
    if horizon is None:
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
