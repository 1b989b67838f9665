"""Slides moved by a drive: stick-slip of one slide, overrun after the drive stops, and two slides in contact."""

from typing import Literal

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.arguments import is_one_of
from symfric.model.outputs import Max, StopTime, Trajectory
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import check_range
from symfric.model.symbols import TIME, finite, shortened
from symfric.model.system import Contact, System

_X, _U = sp.symbols("x u", real=True)
_SLOPES = sp.symbols("mu1 mu2", real=True)
READINGS = ("omega1", "omega2")
PLACES = ("ground", "support")


@alone(SYMBOLIC)
def drive_slide(
    *,
    mu1: float,
    mu2: float,
    p_star: float,
    epsilon: float,
    sigma: float | None = None,
    damper: Literal["ground", "support"] = "ground",
    fc: float | None = None,
    horizon: float | None = None,
) -> Scene:
    r"""Slide on a guideway, pulled by a spring whose end moves at constant speed: :math:`x'' + f(1 + x') + x = 0`.

    Parameters
    ----------
    mu1, mu2 : float
        Half the slopes of the force on the slide over its speed, below and above the corner v*, damper included.
    p_star : float
        ``v*/v - 1`` > -1, the corner's place for the drive's speed v.
    epsilon : float
        ``(F_as - F_ac)/(m omega_n v*)`` >= 0, as `symfric.theory.drive.threshold` returns it.
    sigma : float, optional
        Damping ratio ``c/(2 sqrt(k m))`` of a damper that mu1 and mu2 do not include; it adds to both. None unless
        given.
    damper : {"ground", "support"}
        Where that damper sits; on the support it acts on the speed relative to the drive.
    fc : float, optional
        Kinetic friction at rest over ``m omega_n v*``; ``2 max(1, -mu1)`` unless given, so that the friction does not
        become negative below the corner. Without effect on a slide that does not slip backward.
    horizon : float, optional
        Several cycles by default.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Notes
    -----
    Guida (1)-(4). The v-scaling: ``x = (X - v t) omega_n/v`` and ``u = X'/v - 1``, forces over ``m omega_n v``; so the
    friction jumps by ``eps1 = epsilon (1 + p*)`` at rest. Lengths and forces over ``1 + p*`` are those of the
    v*-scaling, of `drive_stop`, where the jump is epsilon. Starts at rest with a relaxed spring, x = 0 and u = -1.

    Examples
    --------
    >>> import symfric as sf
    >>> slide = sf.scenes.drive_slide(mu1=-0.5, mu2=0.1, p_star=-0.2, epsilon=1.0)
    >>> sf.simulate(slide)
    Run(OK, exact, t_final=124, 34 events)
    """
    mu1, p_star, epsilon = finite(mu1, "mu1"), finite(p_star, "p_star"), finite(epsilon, "epsilon")
    if not p_star > -1:
        raise SceneError(f"p_star is {p_star:g}; it is v*/v - 1 for positive speeds, so give a number above -1")
    if not is_one_of(damper, PLACES):
        raise SceneError(f"damper is {shortened(damper)}; give 'ground' or 'support'")
    fc = _kinetic(fc, mu1)
    p_, epsilon_, fc_, sigma_ = sp.symbols("p_star epsilon fc sigma", real=True)
    more = {} if sigma is None else {sigma_: sigma}
    drag = 0 if sigma is None else 2 * sigma_ * (1 + _U if damper == "ground" else _U)
    law = _one_corner(1 + p_, epsilon_, fc_)
    if horizon is None:
        horizon = 100.0 + 10.0 * (fc + max(epsilon, 0.0)) * (1 + p_star)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[1]], force=[-_X - drag]),
        contacts=[Contact("way", slip=1 + _U, normal=1, law=law)],
        values={**dict(zip(_SLOPES, (mu1, mu2), strict=True)), p_: p_star, epsilon_: epsilon, fc_: fc} | more,
        initial={_X: 0.0, _U: -1.0},
        horizon=horizon,
    )


@alone(SYMBOLIC)
def drive_stop(
    *,
    mu1: float,
    mu2: float,
    lam: float,
    epsilon: float = 0.0,
    fc: float | None = None,
    speed: float = 0.0,
    ramp: float = 0.0,
    drive: float | None = None,
    sigma: float = 0.0,
    horizon: float | None = None,
) -> Scene:
    r"""Slide whose drive stops, still loaded by the spring: :math:`x'' + f(x') + x = s(t)`, with s = 0 once it stands.

    Parameters
    ----------
    mu1, mu2 : float
        Half the slopes of the force on the slide over its speed, below and above v*, damper included.
    lam : float
        Force of the spring at the stop less the kinetic friction at rest, over ``m omega_n v*``; see
        `symfric.theory.drive.excess`, which knows where the damper sits.
    epsilon : float
        ``(F_as - F_ac)/(m omega_n v*)`` >= 0.
    fc : float, optional
        Kinetic friction at rest over ``m omega_n v*``; ``2 max(1, -mu1)`` unless given. It decides only whether the
        slide, once stopped, is pushed back.
    speed : float
        Speed of the slide over v* when the drive begins to stop; 0 is a slide at rest.
    ramp : float
        Time in units of 1/omega_n in which the speed of the drive falls to zero, evenly; 0 is an abrupt stop.
    drive : float, optional
        Speed of the drive over v* before; that of the slide unless given. Without effect on an abrupt stop.
    sigma : float
        Damping ratio of a damper on the support, >= 0, which mu1 and mu2 include. Without effect on an abrupt stop,
        after which it acts like one to ground.
    horizon : float, optional
        Beyond the stop by default.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If a number is missing or out of range.

    Notes
    -----
    Guida (7), (8), (15), the v*-scaling: ``x = X omega_n/v*`` from the place where the support stands in the end, ``u =
    X'/v*``, forces over ``m omega_n v*``. Meanwhile the support is at ``s = -drive (ramp - t)^2/(2 ramp)`` and a damper
    on it pushes with ``2 sigma s'``. Starts at ``x = s - (fc + lam)``. The output "error" is the positioning error, the
    largest ``x + fc + lam``: for an abrupt stop the way up to the first rest; negative where the slide stops short.

    Examples
    --------
    >>> import symfric as sf
    >>> numbers = {"mu1": 0.1, "mu2": 0.1, "lam": 0.1, "epsilon": 0.05, "speed": 0.5}
    >>> for ramp in (0.0, 1e-3, 6.0):
    ...     print(f"{sf.simulate(sf.scenes.drive_stop(**numbers, ramp=ramp))['error']:.4f}")
    0.5227
    0.5227
    0.1428
    """
    check_range({}, {"ramp": ramp, "sigma": sigma})
    mu1, lam = finite(mu1, "mu1"), finite(lam, "lam")
    lam_, epsilon_, fc_, speed_ = sp.symbols("lam epsilon fc speed", real=True)
    if horizon is None:
        horizon = 60.0 + 4.0 * abs(lam) + 2.0 * ramp
    place, push, more = _stopping(ramp, speed if drive is None else drive, sigma)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[1]], force=[place - _X + push]),
        contacts=[Contact("way", slip=_U, normal=1, law=_one_corner(sp.Integer(1), epsilon_, fc_))],
        values={
            **dict(zip(_SLOPES, (mu1, mu2), strict=True)),
            lam_: lam,
            epsilon_: epsilon,
            fc_: _kinetic(fc, mu1),
            speed_: speed,
            **more,
        },
        initial={_X: sp.sympify(place).subs(TIME, 0) - (fc_ + lam_), _U: speed_},
        horizon=horizon,
        outputs={"path": Trajectory(), "error": Max(_X + fc_ + lam_), "stop_time": StopTime()},
    )


def _stopping(ramp: float, drive: float, sigma: float) -> tuple[sp.Expr, sp.Expr, dict[sp.Symbol, float]]:
    """Return the place of the support while it stops, the push of a damper on it, and the values of both."""
    if ramp == 0:
        return sp.Integer(0), sp.Integer(0), {}
    if not finite(drive, "drive") > 0:
        raise SceneError(
            f"the drive's speed is {drive:g}; it is positive before a ramp, so give drive=, its speed over v*"
        )
    ramp_, drive_, sigma_ = sp.symbols("ramp drive sigma", real=True)
    left = sp.Max(0, ramp_ - TIME)  # of the time of the ramp
    values = {ramp_: ramp, drive_: drive}
    if sigma == 0:
        return -drive_ * left**2 / (2 * ramp_), sp.Integer(0), values
    return -drive_ * left**2 / (2 * ramp_), 2 * sigma_ * drive_ * left / ramp_, {**values, sigma_: sigma}


def _one_corner(corner: sp.Expr, epsilon: sp.Symbol, fc: sp.Symbol) -> laws.Law:
    """Return the friction characteristic with slopes 2 mu1 and 2 mu2, forces in units of ``m omega_n v*/corner``."""
    mu1, mu2 = _SLOPES
    return laws.piecewise_linear(
        (fc + epsilon) * corner, [0, corner], [fc * corner, (fc + 2 * mu1) * corner], last_slope=2 * mu2
    )


def _kinetic(fc: float | None, mu1: float) -> float:
    return 2 * max(1.0, -mu1) if fc is None else finite(fc, "fc")


@alone(SYMBOLIC)
def two_slides(
    *,
    r: float,
    zeta: float,
    s1: float,
    s2: float,
    fc1: float,
    fs1: float,
    damping: Literal["omega1", "omega2"] = "omega1",
    horizon: float = 200.0,
) -> Scene:
    r"""Two slides in contact, the first pulled by a drive: :math:`\eta_1'' + 2 s_1\eta_1' + \eta_1 + F = 0`.

    Parameters
    ----------
    r, zeta : float
        ``m1/m2`` and ``omega1/omega2``, positive.
    s1, s2 : float
        Damping ratios, not negative.
    fc1, fs1 : float
        Kinetic and static friction over ``m1 omega1 v``.
    damping : {"omega1", "omega2"}
        What s2 refers to: with "omega1" it stands in the equations of motion as it is, ``d2 = s2``, as the source
        writes (24) and draws its figures; with "omega2", as (23) defines it, ``d2 = s2/zeta``.
    horizon : float
        Length of the run.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Notes
    -----
    Guida (21)-(25): ``eta1 = (X1 - v t) omega1/v``, ``eta2 = X2 omega1/v``, ``eta2'' + 2 d2 eta2' + eta2/zeta^2 = r F``
    with F along ``w = eta1' - eta2' + 1``; the second equation is taken over r, so that F enters both alike. Starts
    with both slides at rest and relaxed springs, sticking: eta1' = -1.

    Examples
    --------
    >>> import symfric as sf
    >>> slides = sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=1, fs1=7.8)
    >>> sf.stability(slides).stable
    True
    """
    check_range({"r": r, "zeta": zeta})
    if not is_one_of(damping, READINGS):
        raise SceneError(f"damping is {shortened(damping)}; s2 refers to 'omega1' (d2 = s2) or 'omega2' (d2 = s2/zeta)")
    r_, zeta_, s1_, s2_ = sp.symbols("r zeta s1 s2", real=True)
    fc1_, fs1_ = sp.symbols("fc1 fs1", real=True)
    (e1, e2), (u1, u2) = sp.symbols("eta1 eta2", real=True), sp.symbols("u1 u2", real=True)
    d2 = s2_ if damping == "omega1" else s2_ / zeta_
    force = [-2 * s1_ * u1 - e1, -(2 * d2 * u2 + e2 / zeta_**2) / r_]
    return Scene(
        system=System(q=[e1, e2], u=[u1, u2], mass=sp.diag(1, 1 / r_), force=force),
        contacts=[Contact("slides", slip=u1 - u2 + 1, normal=1, law=laws.coulomb(fs1_, fc1_))],
        values={r_: r, zeta_: zeta, s1_: s1, s2_: s2, fc1_: fc1, fs1_: fs1},
        initial={e1: 0.0, e2: 0.0, u1: -1.0, u2: 0.0},
        horizon=horizon,
    )
