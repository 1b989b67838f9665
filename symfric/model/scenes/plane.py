"""Ready scenes that slide in the plane: a block on a shaken incline, and a sliding isolator under two components."""

from collections.abc import Sequence

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.outputs import At, Max, Output, Trajectory, friction_force, slip
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import check_range, open_values
from symfric.model.scenes.isolator import Record, as_signal
from symfric.model.symbols import TIME, Key, finite
from symfric.model.system import Contact, System

_X, _Y, _U, _W = sp.symbols("x y u w", real=True)
_RUN_OUT = 20.0  # horizon beyond the end of the records in s, in which the mass comes to rest


@alone(SYMBOLIC)
def block_on_incline(
    *,
    slope: float,
    mu: float,
    speed: float = 0.0,
    direction: float = 0.0,
    a: float = 0.0,
    Omega: float = 1.0,
    mu_s: float | None = None,
    g: float = 9.81,
    horizon: float = 10.0,
) -> Scene:
    r"""Block on an incline that may be shaken across its slope.

    Parameters
    ----------
    slope : float
        Angle of the incline, rad, from 0 to below pi/2.
    mu : float
        Kinetic coefficient of friction.
    speed : float
        At the start, m/s.
    direction : float
        Of the velocity at the start, rad; 0 down the slope, pi/2 across.
    a : float
        Amplitude of the incline's acceleration across the slope, m/s^2.
    Omega : float
        Its angular frequency, rad/s.
    mu_s : float, optional
        Static coefficient; `mu` unless given.
    g : float
        Gravity, m/s^2.
    horizon : float
        s.

    Returns
    -------
    Scene
        x is the place across the slope, y down the slope, both on the incline, in m.

    Raises
    ------
    SceneError
        If a number is missing or out of range.

    Notes
    -----
    :math:`x'' = -a\cos\Omega t + f_x,\ y'' = g\sin\alpha + f_y` with friction of the size :math:`\mu g\cos\alpha`.
    Without shaking `symfric.theory.plane.incline_stop` has its stop in closed form.

    Examples
    --------
    >>> import symfric as sf
    >>> block = sf.scenes.block_on_incline(slope=0.3, mu=0.5, speed=1.0, direction=1.0)
    >>> stop = sf.theory.plane.incline_stop(0.3, 0.5, speed=1.0, direction=1.0)
    >>> bool(abs(sf.simulate(block)["down"] - stop.downslope) < 1e-9)
    True
    """
    check_range({"g": g, "Omega": Omega}, {"slope": slope, "mu": mu, "speed": speed, "a": a})
    if slope >= float(sp.pi / 2):
        raise SceneError(f"slope is {slope:g}; an incline has a slope below pi/2, in rad")
    slope_, mu_, mu_s_, speed_, direction_ = sp.symbols("slope mu mu_s speed direction", real=True)
    a_, Omega_, g_ = sp.symbols("a Omega g", real=True)
    table = Contact("incline", slip=(_U, _W), normal=g_ * sp.cos(slope_), law=laws.coulomb(mu_s_, mu_))
    values: dict[Key, float | None] = {
        slope_: slope,
        mu_: mu,
        mu_s_: mu if mu_s is None else mu_s,
        speed_: speed,
        direction_: finite(direction, "direction"),
        a_: a,
        Omega_: Omega,
        g_: g,
    }
    start = {_X: 0.0, _Y: 0.0, _U: speed_ * sp.sin(direction_), _W: speed_ * sp.cos(direction_)}
    return Scene(
        system=System(q=[_X, _Y], u=[_U, _W], mass=sp.eye(2), force=[-a_ * sp.cos(Omega_ * TIME), g_ * sp.sin(slope_)]),
        contacts=[table],
        values=values,
        initial=start,
        horizon=finite(horizon, "horizon"),
        outputs={"path": Trajectory(), "down": At(_Y), "across": At(_X)},
    )


@alone(SYMBOLIC)
def friction_pendulum(
    *,
    R: float,
    mu: float,
    m: float,
    motions: Sequence[Record],
    g: float = 9.81,
    law: Law | None = None,
    horizon: float | None = None,
) -> Scene:
    r"""Sliding isolator on a dish under two components of ground motion: :math:`m(q'' + a_g) = -(m g/R)\,q + f`.

    Parameters
    ----------
    R : float
        Radius of the dish, m; displacements are small against it.
    mu : float
        Coefficient of friction.
    m : float
        Mass above the bearing, kg.
    motions : pair of Signal or Motion
        Accelerations of the ground along x and along y, m/s^2, linear between their samples.
    g : float
        Gravity, m/s^2.
    law : Law, optional
        Factor of the coefficient over the sliding speed; constant unless given. Its symbols are values to be given with
        `where`.
    horizon : float, optional
        s; unless given, 20 s longer than the longer record, so that the mass comes to rest.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If a number is missing or out of range, or if there are not two motions.

    Notes
    -----
    x and y are displacements of the mass relative to the ground. Friction :math:`f` of the size :math:`\mu m g` opposes
    the slip vector: while the mass slides along x, little of it is left along y, so that the two directions alone miss
    what both do together. ``amplitude``, 1 unless changed by ``where``, multiplies both motions. Outputs:
    `peak_displacement` and `peak_velocity` are the largest lengths of these vectors, `peak_acceleration` that of the
    mass in space with its components `peak_acceleration_x` and `peak_acceleration_y`, `residual_x` and `residual_y` the
    displacement at the horizon. `sf.design.isolator` takes the scene with pairs of motions.

    Examples
    --------
    >>> import symfric as sf
    >>> pair = (sf.motions.sine_burst(3.0, 0.5, cycles=5), sf.motions.sine_burst(2.0, 0.6, cycles=5))
    >>> run = sf.simulate(sf.scenes.friction_pendulum(R=2.0, mu=0.06, m=1e5, motions=pair))
    >>> print(f"{run['peak_displacement']:.4f} m")
    1.0137 m
    """
    check_range({"R": R, "m": m, "g": g}, {"mu": mu})
    if not isinstance(motions, Sequence) or len(motions) != 2:
        raise SceneError("motions is no pair; give two motions of the ground, along x and along y")
    signals = [as_signal(motion) for motion in motions]
    R_, mu_, m_, g_, a_x, a_y, amplitude = sp.symbols("R mu m g a_x a_y amplitude", real=True)
    law = laws.coulomb(1) if law is None else law
    values: dict[Key, float | None] = {R_: R, mu_: mu, m_: m, g_: g, amplitude: 1.0}
    values |= open_values(law)
    back = [m_ * g_ / R_ * q for q in (_X, _Y)]
    pulls = [(friction_force("bearing", k) - back[k]) / m_ for k in (0, 1)]
    outputs: dict[str, Output] = {
        "peak_displacement": Max(sp.sqrt(_X**2 + _Y**2)),
        "peak_velocity": Max(slip("bearing")),
        "peak_acceleration": Max(sp.sqrt(pulls[0] ** 2 + pulls[1] ** 2)),
        "peak_acceleration_x": Max(sp.Abs(pulls[0])),
        "peak_acceleration_y": Max(sp.Abs(pulls[1])),
        "residual_x": At(_X),
        "residual_y": At(_Y),
    }
    longest = max(signal.t_end for signal in signals)
    return Scene(
        system=System(
            q=[_X, _Y],
            u=[_U, _W],
            mass=m_ * sp.eye(2),
            force=[-e - m_ * amplitude * shaking for e, shaking in zip(back, (a_x, a_y), strict=True)],
        ),
        contacts=[Contact("bearing", slip=(_U, _W), normal=m_ * g_, law=law, profile=mu_)],
        values=values,
        inputs=dict(zip((a_x, a_y), signals, strict=True)),
        initial=dict.fromkeys((_X, _Y, _U, _W), 0.0),
        horizon=longest + _RUN_OUT if horizon is None else finite(horizon, "horizon"),
        outputs=outputs,
    )
