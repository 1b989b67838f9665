"""A mass on a moving belt."""

import sympy as sp

from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact, System

_X, _U = sp.symbols("x u", real=True)


def _open(law: Law) -> dict:
    """Return the symbols of a law as scene values without a number, to be given later with `where`."""
    return dict.fromkeys(sorted(law.free_symbols, key=str))


@alone(SYMBOLIC)
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
