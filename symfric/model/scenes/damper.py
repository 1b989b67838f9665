"""Ready scenes of transient motion: a rod on a spring that a contact brings to rest."""

import math

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.arguments import flag
from symfric.model.outputs import Integral, StopTime, Trajectory, friction_force, slip
from symfric.model.scene import Scene
from symfric.model.symbols import finite
from symfric.model.system import Contact, System

_X, _U = sp.symbols("x u", real=True)
_UNBRAKED = 50.0  # horizon in cycles if no friction stops the rod


@alone(SYMBOLIC)
def contact_damper(
    *, f_n, mu_m, zeta=0.0, r=1.0, m=0.5, x0=0.01, v0=0.0, g=9.81, v_c=1.0, literal=False, horizon=None
) -> Scene:
    r"""Rod on a spring, braked by a contact whose friction falls with the sliding speed.

    Parameters
    ----------
    f_n : float
        Natural frequency, Hz.
    mu_m : float
        Coefficient of friction at rest, the largest one.
    zeta, r : float
        Damping ratio; load of the contact over the weight of the rod.
    m : float
        Mass, kg.
    x0, v0 : float
        Start, m and m/s.
    g, v_c : float
        Gravity, m/s^2; speed over which friction falls by a factor e, m/s. The source uses 1 m/s without saying so.
    literal : bool
        Take friction as printed, ``mu_m exp(-x'/v_c)`` with the sign of x' in the exponent: it grows while the rod
        moves backward. For comparison with the source only.
    horizon : float, optional
        By default long enough for the rod to stop, with these numbers; give one to change them far with `where`.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Notes
    -----
    :math:`x'' + 2\zeta\omega x' + \omega^2 x = -\mathrm{sgn}(x')\,\mu_m r g\,e^{-|x'|/v_c}` with
    :math:`\omega = 2\pi f_n`: Younes and Ashour (2), (3), corrected in derivations/younes_ashour/system.py.

    Wanted are the motion, the time of the stop and the energies that damper and contact take, J;
    `symfric.theory.transient.energy_balance` closes the balance with what is left in the spring. In the literal variant
    the contact has constant friction, and its load carries the factor ``exp(-x'/v_c)``: the product, which is all that
    acts, is the printed one, and smooth in both directions.

    Examples
    --------
    >>> import symfric as sf
    >>> rod = sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.005)
    >>> round(sf.simulate(rod)["stop_time"], 6)
    1.050002
    """
    flag(literal, "literal")
    _check({"f_n": f_n, "m": m, "v_c": v_c}, {"mu_m": mu_m, "zeta": zeta, "r": r, "g": g}, {"x0": x0, "v0": v0})
    f_, mu_, zeta_, r_, m_, x0_, v0_, g_, v_c_ = sp.symbols("f_n mu_m zeta r m x0 v0 g v_c", real=True)
    omega = 2 * sp.pi * f_
    damping, load = 2 * zeta_ * omega * m_ * _U, r_ * m_ * g_
    if horizon is None:
        horizon = _longest(f_n, mu_m * r * g, zeta, math.hypot(x0, v0 / (2 * math.pi * f_n)), v_c)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[m_]], force=[-damping - m_ * omega**2 * _X]),
        contacts=[_disk(load, mu_, v_c_, literal)],
        values={f_: f_n, mu_: mu_m, zeta_: zeta, r_: r, m_: m, x0_: x0, v0_: v0, g_: g, v_c_: v_c},
        initial={_X: x0_, _U: v0_},
        horizon=horizon,
        outputs={
            "path": Trajectory(),
            "stop_time": StopTime(),
            "E_viscous": Integral(damping * _U),
            "E_contact": Integral(-friction_force("disk") * slip("disk")),
        },
    )


def _disk(load: sp.Expr, mu_m: sp.Symbol, v_c: sp.Symbol, literal: bool) -> Contact:
    """Return the contact between rod and disk."""
    if literal:
        return Contact("disk", slip=_U, normal=load * sp.exp(-_U / v_c), law=laws.coulomb(mu_m))
    return Contact("disk", slip=_U, normal=load, law=laws.exponential(mu_m, v_c))


def _check(positive: dict, not_negative: dict, any_sign: dict) -> None:
    """Raise if a number is missing, not finite or out of range."""
    for name, value in (positive | not_negative | any_sign).items():
        number = finite(value, name)
        if (name in positive and number <= 0) or (name in not_negative and number < 0):
            raise SceneError(
                f"{name} is {number:g}; it must {'be positive' if name in positive else 'not be negative'}"
            )


def _longest(f_n: float, friction: float, zeta: float, start: float, v_c: float) -> float:
    """Return an upper bound of the time at which the rod stops, plus some cycles.

    The averaged amplitude falls at least by ``(2/pi)(mu_m r g/omega)/(1 + a)^2`` with a = A omega/v_c, and at least by
    ``zeta omega A``, the latter down to the amplitude at which the rod sticks.
    """
    if friction <= 0:
        return _UNBRAKED / f_n
    omega = 2 * math.pi * f_n

    def braked(amplitude: float) -> float:
        a = amplitude * omega / v_c
        return math.pi * v_c / (2 * friction) * a * (1 + a + a**2 / 3)

    stick, longest = friction / omega**2, braked(start)
    if zeta > 0 and start > stick:
        longest = min(longest, math.log(start / stick) / (zeta * omega) + braked(stick))
    return longest + 3 / f_n
