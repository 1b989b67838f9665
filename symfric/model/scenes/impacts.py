"""Ready scenes of contacts that open and strike: conveyor, impact oscillator, cam, brake pad, mass between stops."""

import math

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.outputs import At, Max, Min, Trajectory, normal_force
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import check_range, open_values
from symfric.model.stops import stops
from symfric.model.symbols import SPEED, TIME, Key, finite
from symfric.model.system import Contact, System
from symfric.model.unilateral import Unilateral

_X, _Y, _U, _V = sp.symbols("x y u v", real=True)


@alone(SYMBOLIC)
def vibratory_conveyor(
    *,
    mu: float,
    a: float,
    Omega: float,
    beta: float,
    e: float = 0.0,
    mu_s: float | None = None,
    g: float = 9.81,
    horizon: float | None = None,
) -> Scene:
    r"""Part on a level track that shakes along a line: it is carried while it presses, and flies.

    Parameters
    ----------
    mu : float
        Kinetic coefficient of friction.
    a : float
        Amplitude of the track, m.
    Omega : float
        Angular frequency of the track, rad/s.
    beta : float
        Angle between the line of vibration and the track, rad.
    e : float
        Restitution of the part on the track.
    mu_s : float, optional
        Static coefficient; `mu` unless given.
    g : float
        Gravity, m/s^2.
    horizon : float, optional
        s; 60 periods of the track unless given.

    Returns
    -------
    Scene
        With the output `distance`, how far the part was carried, m.

    Notes
    -----
    The track is at :math:`a\sin\Omega t\,(\cos\beta, \sin\beta)`, the part starts at rest on it. It sticks throughout
    where :math:`a\Omega^2\cos\beta \le \mu_s(g - a\Omega^2\sin\beta)`, and leaves the track where
    :math:`a\Omega^2\sin\beta > g`.

    Examples
    --------
    >>> import symfric as sf
    >>> track = sf.scenes.vibratory_conveyor(mu=0.4, a=0.002, Omega=60.0, beta=0.5)
    >>> print(f"{sf.simulate(track)['distance'] / track.horizon:.4f} m/s")
    0.0222 m/s
    """
    check_range({"a": a, "Omega": Omega, "g": g}, {"mu": mu, "e": e})
    length = 60 * 2 * math.pi / finite(Omega, "Omega") if horizon is None else finite(horizon, "horizon")
    a_, Omega_, beta_, e_, mu_, mu_s_, g_ = sp.symbols("a Omega beta e mu mu_s g", real=True)
    along, up = a_ * sp.cos(beta_), a_ * sp.sin(beta_)
    track = Contact(
        "track",
        slip=_U - along * Omega_ * sp.cos(Omega_ * TIME),
        normal=Unilateral(_Y - up * sp.sin(Omega_ * TIME), e_),
        law=laws.coulomb(mu_s_, mu_),
    )
    values: dict[Key, float | None] = {
        a_: a,
        Omega_: Omega,
        beta_: beta,
        e_: e,
        mu_: mu,
        mu_s_: mu if mu_s is None else mu_s,
        g_: g,
    }
    return Scene(
        system=System(q=[_X, _Y], u=[_U, _V], mass=sp.eye(2), force=[0, -g_]),
        contacts=[track],
        values=values,
        initial={_X: 0.0, _Y: 0.0, _U: along * Omega_, _V: up * Omega_},
        horizon=length,
        outputs={"path": Trajectory(), "distance": At(_X)},
    )


@alone(SYMBOLIC)
def impact_oscillator(
    *,
    e: float,
    zeta: float,
    Omega: float,
    F: float = 1.0,
    gap: float = 0.0,
    x0: float | None = None,
    horizon: float | None = None,
) -> Scene:
    r"""Forced oscillator with a stop: :math:`x'' + 2\zeta x' + x = F\cos\Omega t`, ``x <= gap``.

    Parameters
    ----------
    e : float
        Restitution of the stop.
    zeta : float
        Damping ratio.
    Omega : float
        Frequency of the force over the natural one.
    F : float
        Amplitude of the force over the stiffness.
    gap : float
        Distance of the stop from the place of rest without the force.
    x0 : float, optional
        Start, at rest; one half of F below the stop unless given.
    horizon : float, optional
        60 periods of the force unless given.

    Returns
    -------
    Scene

    Notes
    -----
    Nordmark, J. Sound Vib. 145 (1991) 279: where an orbit begins to touch the stop its stability changes at once, with
    the square root of the distance from there. The orbit without impacts has the amplitude
    :math:`F/\sqrt{(1-\Omega^2)^2 + 4\zeta^2\Omega^2}` and touches where that is the gap.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2)
    >>> orbit = sf.limit_cycle(scene)
    >>> round(orbit.period, 6), [(round(event.t, 4), event.kind) for event in orbit.events]
    (2.855993, [(1.107, 'impact')])
    """
    check_range({"Omega": Omega}, {"e": e, "zeta": zeta})
    start = finite(gap, "gap") - abs(finite(F, "F")) / 2 if x0 is None else finite(x0, "x0")
    length = 60 * 2 * math.pi / Omega if horizon is None else finite(horizon, "horizon")
    e_, zeta_, Omega_, F_, gap_ = sp.symbols("e zeta Omega F gap", real=True)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[1]], force=[-2 * zeta_ * _U - _X + F_ * sp.cos(Omega_ * TIME)]),
        contacts=[Contact("stop", slip=None, normal=Unilateral(gap_ - _X, e_))],
        values={e_: e, zeta_: zeta, Omega_: Omega, F_: F, gap_: gap},
        initial={_X: start, _U: 0.0},
        horizon=length,
    )


@alone(SYMBOLIC)
def cam_follower(
    *,
    m: float,
    k: float,
    preload: float,
    h: float,
    Omega: float,
    e: float = 0.0,
    c: float = 0.0,
    horizon: float | None = None,
) -> Scene:
    r"""Follower that a spring presses on a cam: :math:`x \ge h(1 - \cos\Omega t)`, :math:`m x'' = N - k(x + d) - c x'`.

    Parameters
    ----------
    m : float
        Mass of the follower, kg.
    k : float
        Stiffness of the spring, N/m.
    preload : float
        Deflection d of the spring at the lowest place, m.
    h : float
        Half of the lift, m.
    Omega : float
        Angular velocity of the cam, rad/s.
    e : float
        Restitution of follower on cam.
    c : float
        Damping of the follower, N s/m.
    horizon : float, optional
        s; 20 turns of the cam unless given.

    Returns
    -------
    Scene
        With the output `least_force`, the smallest normal force: zero where the follower lifts off.

    Notes
    -----
    Without damping the follower stays on the cam up to :math:`\Omega^2 = k(2h + d)/(m h)`, where the normal force at
    the top is zero.

    Examples
    --------
    >>> import symfric as sf
    >>> cam = sf.scenes.cam_follower(m=0.5, k=400.0, preload=0.02, h=0.01, Omega=56.0)
    >>> [round(sf.simulate(cam.where({"Omega": w}))["least_force"], 6) + 0.0 for w in (56.0, 57.0)]
    [0.32, 0.0]
    """
    check_range({"m": m, "k": k, "h": h, "Omega": Omega}, {"e": e, "c": c, "preload": preload})
    length = 20 * 2 * math.pi / Omega if horizon is None else finite(horizon, "horizon")
    m_, k_, d_, h_, Omega_, e_, c_ = sp.symbols("m k preload h Omega e c", real=True)
    lift = h_ * (1 - sp.cos(Omega_ * TIME))
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[m_]], force=[-k_ * (_X + d_) - c_ * _U]),
        contacts=[Contact("cam", slip=None, normal=Unilateral(_X - lift, e_))],
        values={m_: m, k_: k, d_: preload, h_: h, Omega_: Omega, e_: e, c_: c},
        initial={_X: 0.0, _U: 0.0},
        horizon=length,
        outputs={"path": Trajectory(), "least_force": Min(normal_force("cam"))},
    )


@alone(SYMBOLIC)
def brake_pad(
    law: Law | None = None,
    *,
    v_b: float,
    N: float = 1.0,
    m: float = 1.0,
    k: float = 1.0,
    k_n: float = 25.0,
    k_t: float = 0.0,
    c: float = 0.05,
    c_n: float = 0.5,
    e: float = 0.0,
    horizon: float = 200.0,
) -> Scene:
    r"""Brake pad that is pressed on a rigid disc and can lift off: x along the disc, y away from it, ``y >= 0``.

    Parameters
    ----------
    law : Law, optional
        Friction between pad and disc, ``sf.laws.cubic(0.4, 0.25, 0.5)`` unless given. Its symbols are values to be
        given with `where`.
    v_b : float
        Speed of the disc.
    N : float
        Force that presses the pad on.
    m : float
        Mass of the pad.
    k, k_n, k_t : float
        Stiffness along the disc, away from it, and between the two: the support is inclined.
    c, c_n : float
        Damping along the disc and away from it.
    e : float
        Restitution of the pad on the disc.
    horizon : float

    Returns
    -------
    Scene
        With the outputs `least_force` and `largest_force`, of the normal force.

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    :math:`m x'' = -k x - k_t y - c x' + F`, :math:`m y'' = -k_t x - k_n y - c_n y' - N + \lambda`. While the pad is on
    the disc, the normal force is :math:`\lambda = N + k_t x`: friction that drags the pad along presses it on
    (``k_t > 0``) or takes it off, and the pad lifts off beyond :math:`x = -N/k_t`.

    Examples
    --------
    >>> import symfric as sf
    >>> pad = sf.scenes.brake_pad(v_b=0.2, k_t=-3.5)
    >>> run = sf.simulate(pad)
    >>> abs(run["least_force"]) < 1e-12, any(event.kind == "open" for event in run.events)
    (True, True)
    """
    check_range({"N": N, "m": m, "k": k, "k_n": k_n}, {"c": c, "c_n": c_n, "e": e})
    if not finite(k_t, "k_t") ** 2 < k * k_n:
        raise SceneError(f"k_t is {k_t:g}; its square is below k k_n = {k * k_n:g}, or the pad in the air is not held")
    law = laws.cubic(0.4, 0.25, 0.5) if law is None else law
    v_, N_, m_, k_, k_n_, k_t_, c_, c_n_, e_ = sp.symbols("v_b N m k k_n k_t c c_n e", real=True)
    force = [-k_ * _X - k_t_ * _Y - c_ * _U, -k_t_ * _X - k_n_ * _Y - c_n_ * _V - N_]
    numbers = zip((v_, N_, m_, k_, k_n_, k_t_, c_, c_n_, e_), (v_b, N, m, k, k_n, k_t, c, c_n, e), strict=True)
    values: dict[Key, float | None] = {**dict(numbers), **open_values(law)}
    return Scene(
        system=System(q=[_X, _Y], u=[_U, _V], mass=m_ * sp.eye(2), force=force),
        contacts=[Contact("disc", slip=_U - v_, normal=Unilateral(_Y, e_), law=law)],
        values=values,
        initial=dict.fromkeys((_X, _Y, _U, _V), 0.0),
        horizon=horizon,
        outputs={
            "path": Trajectory(),
            "least_force": Min(normal_force("disc")),
            "largest_force": Max(normal_force("disc")),
        },
    )


@alone(SYMBOLIC)
def mass_with_stops(
    *,
    m: float = 1.0,
    k: float = 500.0,
    x_k: float = -0.25,
    F_prop: float = 1.0,
    F_Coulomb: float = 3.0,
    F_Stribeck: float = 5.0,
    fexp: float = 2.0,
    peak: float = 1.001,
    x_low: float = -0.4,
    x_high: float = 0.4,
    e: float = 0.0,
    x0: float = 0.0,
    v0: float = -5.0,
    horizon: float = 2.0,
) -> Scene:
    r"""Sliding mass on a spring between two stops, with the Stribeck friction of the Modelica Standard Library.

    Parameters
    ----------
    m : float
        Mass, kg.
    k : float
        Stiffness of the spring, N/m.
    x_k : float
        Where the spring is unloaded, m.
    F_prop, F_Coulomb, F_Stribeck, fexp : float
        Friction ``F_Coulomb + F_prop v + F_Stribeck exp(-fexp v)`` at the speed v; N s/m, N, N, s/m.
    peak : float
        Largest friction at rest over its limit ``F_Coulomb + F_Stribeck`` for small speeds.
    x_low, x_high : float
        Ends of the way, m.
    e : float
        Restitution of the stops; 0 as published.
    x0, v0 : float
        Start, m and m/s.
    horizon : float
        s.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    ``Modelica.Mechanics.Translational.Examples.Friction``, the component `stop2` with its spring and the values given
    there: the mass of length 1 m is between stops at -0.9 m and 0.9 m, so that its middle moves between -0.4 m and
    0.4 m. The library reinitialises the velocity at a stop to zero.

    Examples
    --------
    >>> import symfric as sf
    >>> run = sf.simulate(sf.scenes.mass_with_stops())
    >>> [(round(event.t, 6), event.contact) for event in run.events if event.kind in ("impact", "close")]
    [(0.060597, 'stop_low')]
    >>> print(f"{run.final[0]:.6f}")
    -0.247514
    """
    check_range({"m": m}, {"k": k, "F_prop": F_prop, "F_Coulomb": F_Coulomb, "F_Stribeck": F_Stribeck, "fexp": fexp})
    if not finite(peak, "peak") >= 1:
        raise SceneError(f"peak is {peak:g}; friction at rest is not below that of small speeds: 1 or more")
    names = "m k x_k F_prop F_Coulomb F_Stribeck fexp peak x_low x_high e"
    m_, k_, x_k_, prop, coulomb, stribeck, fexp_, peak_, low, high, e_ = symbols = sp.symbols(names, real=True)
    law = laws.custom(coulomb + prop * SPEED + stribeck * sp.exp(-fexp_ * SPEED), peak_ * (coulomb + stribeck))
    numbers = (m, k, x_k, F_prop, F_Coulomb, F_Stribeck, fexp, peak, x_low, x_high, e)
    return Scene(
        system=System(q=[_X], u=[_U], mass=[[m_]], force=[-k_ * (_X - x_k_)]),
        contacts=[Contact("guide", slip=_U, normal=1, law=law), *stops(_X, low, high, e_)],
        values=dict(zip(symbols, numbers, strict=True)),
        initial={_X: x0, _U: v0},
        horizon=horizon,
    )
