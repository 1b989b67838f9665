"""Digital controllers as held variables: PID, state feedback, friction compensation, pulse widths, discrete systems.

Dither is an expression of time and no held variable.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of
from symfric.model.held import Held
from symfric.model.public_names import names_of
from symfric.model.symbols import TIME, expression, listed, pair, shortened
from symfric.spelling import spelt

__all__ = ["discrete", "dither", "friction_compensation", "pid", "pwm", "state_feedback"]
_Number: TypeAlias = float | sp.Expr


@spelt
def pid(
    x: sp.Expr,
    ref: _Number,
    kp: _Number,
    ki: _Number = 0.0,
    kd: _Number = 0.0,
    *,
    every: _Number,
    name: str = "pid",
    offset: _Number = 0.0,
    delay: _Number = 0.0,
    rate: sp.Expr | None = None,
    limits: tuple[_Number, _Number] | None = None,
    start: _Number = 0.0,
    step: _Number | None = None,
) -> list[Held]:
    """Return the held variables of a sampled PID controller; the last one is its command.

    Parameters
    ----------
    x : Expr
        What is measured.
    ref : float or Expr
        Where it should be; may depend on time.
    kp, ki, kd : float or Expr
        Gains of the error, of its integral and of the rate of x.
    every, offset, delay : float or Expr
        As of `sf.Held`.
    name : str
        Of the command; the integral and the last measurement are ``<name>.integral`` and ``<name>.measured``.
    rate : Expr, optional
        A measured rate of x; the difference of two samples over the period unless given.
    limits : (float or Expr, float or Expr), optional
        Of the command. The integral is held back so that the command leaves a limit as soon as the error turns.
    start : float or Expr
        Measured before the first sample, for its difference. Give the start of x where that is not zero: otherwise the
        first difference is a kick of ``kd x/every``.
    step : float or Expr, optional
        Of the converter of the command, see `sf.Held`.

    Returns
    -------
    list of Held
        For ``sf.Scene(..., held=...)``.

    Notes
    -----
    At the sample n, with e = ref - x, ``I_n = I_(n-1) + ki every e_n`` and ``kp e_n + I_n - kd x'_n`` is the command:
    the backward rule for the integral, and no kick of the derivative by steps of the reference.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> held = sf.control.pid(x, ref=1, kp=4, ki=2, kd=3, every=0.01, limits=(-1, 1))
    >>> [h.name for h in held]
    ['pid.integral', 'pid.measured', 'pid']
    >>> table = sf.Contact("table", slip=u, normal=1, law=sf.laws.coulomb(0.1, 0.08))
    >>> system = sf.System([x], [u], [[1]], [held[-1].symbol])
    >>> scene = sf.Scene(system, [table], {}, {x: 0, u: 0}, horizon=10.0, held=held)
    >>> round(float(sf.simulate(scene).final[0]), 2)
    1.0
    """
    error = expression(ref, "ref") - expression(x, "x")
    kp, ki, kd = expression(kp, "kp"), expression(ki, "ki"), expression(kd, "kd")
    states = []
    if rate is None and not kd.is_zero:
        measured = Held(f"{name}.measured", x, every, offset, initial=start)
        rate = (x - measured.previous) / expression(every, "every")
        states = [measured]
    direct = kp * error - (0 if rate is None else kd * expression(rate, "rate"))
    total = direct
    if not ki.is_zero:
        memory = sp.Symbol(f"{name}.integral.previous", real=True)
        grown = memory + ki * expression(every, "every") * error
        total = direct + grown
        inside = grown if limits is None else _within(total, limits) - direct
        states = [Held(f"{name}.integral", inside, every, offset), *states]
    command = total if limits is None else _within(total, limits)
    return [*states, Held(name, command, every, offset, delay, step=step)]


def _within(e: sp.Expr, limits: tuple[_Number, _Number]) -> sp.Expr:
    """Return an expression cut off at limits."""
    low, high = (expression(limit, "a limit") for limit in pair(limits, "limits"))
    if (high - low).is_number and high <= low:
        raise SceneError(f"the limits are {low} and {high}; the first must be the lower one")
    return sp.Max(low, sp.Min(high, e))


@spelt
def state_feedback(
    states: Sequence[sp.Expr],
    gains: Sequence[_Number],
    *,
    every: _Number,
    name: str = "feedback",
    offset: _Number = 0.0,
    delay: _Number = 0.0,
) -> list[Held]:
    """Return the held variable of a sampled state feedback, minus the sum of the gains times the states.

    Parameters
    ----------
    states : sequence of Expr, length n
    gains : sequence of float or Expr, length n
    every, offset, delay : float or Expr
        As of `sf.Held`.
    name : str

    Returns
    -------
    list of Held
        One.

    Raises
    ------
    SceneError
        If there are not as many gains as states.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> sf.control.state_feedback([x, u], [4, 3], every=0.01)[0].update
    -3*u - 4*x
    """
    states, gains = listed(states, "states"), np.ravel(np.array(gains, dtype=object)).tolist()
    if len(states) != len(gains):
        raise SceneError(f"{len(states)} states and {len(gains)} gains; give one gain for each")
    force = -sum((expression(g, "a gain") * s for g, s in zip(gains, states, strict=True)), sp.S.Zero)
    return [Held(name, force, every, offset, delay)]


@spelt
def friction_compensation(
    speed: sp.Expr,
    force: _Number,
    *,
    every: _Number,
    dead_band: _Number = 0.0,
    name: str = "compensation",
    offset: _Number = 0.0,
    delay: _Number = 0.0,
) -> list[Held]:
    """Return the held variable of a friction compensation: a force in the direction of a measured speed.

    Parameters
    ----------
    speed : Expr
        Measured, or estimated by another held variable.
    force : float or Expr
        To be added, in the direction of the speed.
    every, offset, delay : float or Expr
        As of `sf.Held`.
    dead_band : float or Expr
        Speed up to which the force is zero.
    name : str

    Returns
    -------
    list of Held
        One.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> u = sp.Symbol("u", real=True)
    >>> sf.control.friction_compensation(u, 0.3, dead_band=0.01, every=0.01)[0].update
    Piecewise((0.3, u > 0.01), (-0.3, u < -0.01), (0, True))
    """
    speed, band = expression(speed, "speed"), expression(dead_band, "dead_band")
    update = sp.Piecewise((force, speed > band), (-expression(force, "force"), speed < -band), (0, True))
    return [Held(name, update, every, offset, delay)]


@spelt
def dither(
    amplitude: _Number, frequency: _Number, *, shape: Literal["sine", "square"] = "sine", phase: _Number = 0.0
) -> sp.Expr:
    """Return a dither, a fast periodic signal to be added to a force or to the update of a held variable.

    Parameters
    ----------
    amplitude : float or Expr
        Half of its range.
    frequency : float or Expr
        Angular, in radians per unit of time.
    shape : {"sine", "square"}
        A square wave is positive in the first half of its period; its steps are events.
    phase : float or Expr
        In radians.

    Returns
    -------
    Expr
        Of `sf.TIME`. In a force it acts at every time; in an update it is sampled, and of a frequency near that of the
        sampling little or nothing is left of it.

    Raises
    ------
    SceneError
        If there is no such shape, or if the frequency is no positive number or expression.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> sf.control.dither(0.2, 50)
    0.2*sin(50*t)
    >>> x, u = sp.symbols("x u", real=True)
    >>> system = sf.System([x], [u], [[1]], [0.15 - u / 5 + sf.control.dither(2, 100, shape="square")])
    >>> floor = sf.Contact("floor", slip=u, normal=1, law=sf.laws.coulomb(0.2))
    >>> creeping = sf.Scene(system, [floor], {}, {x: 0, u: 0}, horizon=10.0)
    >>> bool(sf.simulate(creeping).final[0] > 0.1)  # a load below the friction moves the mass
    True
    """
    size, rate, angle = (
        expression(e, what) for e, what in ((amplitude, "amplitude"), (frequency, "frequency"), (phase, "phase"))
    )
    if rate.is_number and not rate > 0:
        raise SceneError(f"frequency is {frequency}; it must exceed 0")
    if not is_one_of(shape, ("sine", "square")):
        raise SceneError(f"shape is {shortened(shape)}; it must be 'sine' or 'square'")
    wave = sp.sin(rate * TIME + angle)
    return size * (wave if shape == "sine" else sp.sign(wave))


@spelt
def pwm(duty: _Number, *, every: _Number, name: str = "pwm") -> list[Held]:
    """Return the held variables of a pulse-width modulation; the last one is 1 during a pulse, and 0 otherwise.

    Parameters
    ----------
    duty : float or Expr
        Share of the period for which a pulse lasts, from the beginning of the period on. Up to 0 there is none, from 1
        on it does not end. It may contain held variables, the samples of the period among them, and states, with which
        the saw-tooth then is compared at every time.
    every : float or Expr
        Period of the pulses, the first of which begins at t = 0.
    name : str
        Of the pulses; the time at which the last one began is ``<name>.start``.

    Returns
    -------
    list of Held
        Two. A force is the voltage or the pressure times the symbol of the last one; that of a bridge is
        ``V * (2 * pulse - 1)``.

    Notes
    -----
    A pulse ends where ``(t - start)/every - duty`` rises through zero, an event of its own. So pulses are exact, and
    have derivatives by the period and by what the duty depends on. Pulses of a known width are cheaper as a
    ``Piecewise`` with the condition ``Mod(t, every) < width``.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> command = sf.Held("command", update=4 * (1 - x) - 3 * u, every=0.01)
    >>> pulses = sf.control.pwm(command.symbol, every=0.01)
    >>> [h.name for h in pulses]
    ['pwm.start', 'pwm']
    >>> system = sf.System([x], [u], [[1]], [2 * pulses[-1].symbol - 0.5])
    >>> floor = sf.Contact("floor", slip=u, normal=1, law=sf.laws.coulomb(0.2))
    >>> scene = sf.Scene(system, [floor], {}, {x: 0, u: 0}, horizon=5.0, held=[command, *pulses])
    >>> 0.9 < float(sf.simulate(scene).final[0]) < 1
    True
    """
    period = expression(every, "every")
    start = Held(f"{name}.start", TIME, every, initial=-2 * period)  # before the first period no pulse is on
    left = (TIME - start.symbol) / period - expression(duty, "duty")
    return [start, Held(name, sp.Piecewise((1, left < 0), (0, True)), when=left)]


@spelt
def discrete(
    system: Any, inputs: Sequence[sp.Expr], *, name: str = "controller", offset: _Number = 0.0, delay: _Number = 0.0
) -> list[Held]:
    """Return the held variables of a discrete linear system of python-control; the last ones are its outputs.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        With a sampling time ``dt``, of any number of inputs and outputs. Every entry of a matrix of transfer functions
        brings states of its own.
    inputs : sequence of Expr, length m
        What is sampled.
    name : str
        Of the output; of several, ``<name>1``, .... The states are ``<name>.x1``, ....
    offset, delay : float or Expr
        As of `sf.Held`; the delay is that of the outputs.

    Returns
    -------
    list of Held

    Raises
    ------
    SceneError
        If the system is of another kind, has no number as sampling time or another number of inputs, or if a
        transfer function is not proper.

    Examples
    --------
    >>> import control
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x = sp.Symbol("x", real=True)
    >>> smooth = control.tf([0.1, 0], [1, -0.9], dt=0.01)
    >>> [h.name for h in sf.control.discrete(smooth, [x], name="filtered")]
    ['filtered.x1', 'filtered']
    """
    A, B, C, D, every = _matrices(system)
    inputs = listed(inputs, "inputs")
    if len(inputs) != B.shape[1]:
        raise SceneError(f"inputs has {len(inputs)} entries, and the system takes {B.shape[1]}; give one for each")
    states = [sp.Symbol(f"{name}.x{k + 1}.previous", real=True) for k in range(len(A))]
    both = [*states, *(expression(e, "an input") for e in inputs)]
    updates, outputs = ([_combined(row, both) for row in np.hstack(m)] for m in ((A, B), (C, D)))
    names = [name] if len(outputs) == 1 else [f"{name}{k + 1}" for k in range(len(outputs))]
    held = [Held(f"{name}.x{k + 1}", e, every, offset) for k, e in enumerate(updates)]
    return [*held, *(Held(n, e, every, offset, delay) for n, e in zip(names, outputs, strict=True))]


def _matrices(system: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """Return A, B, C, D and the sampling time of a discrete linear system."""
    import control
    from scipy.linalg import block_diag  # slow to import

    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise SceneError(
            f"the system is a {type(system).__name__}; give a control.StateSpace or TransferFunction, with dt"
        )
    if system.dt is True:
        raise SceneError("the system has dt=True, which says no sampling time; give dt as a number")
    if not system.dt:
        raise SceneError(f"the system has the sampling time {system.dt}; give one with dt, as control.c2d(system, T)")
    if isinstance(system, control.StateSpace):
        return system.A, system.B, system.C, system.D, float(system.dt)
    parts = []
    for i, j in np.ndindex(system.noutputs, system.ninputs):
        try:
            part = control.tf2ss(control.tf(system.num[i][j], system.den[i][j], system.dt))
        except ValueError as error:
            raise SceneError(f"the transfer function from input {j + 1} to output {i + 1}: {error}") from error
        parts.append((part, np.eye(system.noutputs)[:, [i]], np.eye(system.ninputs)[[j]]))
    A = block_diag(*(p.A for p, _, _ in parts if p.nstates))
    A = A if A.size else np.zeros((0, 0))
    B = np.vstack([np.zeros((0, system.ninputs)), *(p.B @ e for p, _, e in parts)])
    C = np.hstack([np.zeros((system.noutputs, 0)), *(e @ p.C for p, e, _ in parts)])
    return A, B, C, sum(e @ p.D @ f for p, e, f in parts), float(system.dt)


def _combined(row: np.ndarray, terms: Sequence[sp.Expr]) -> sp.Expr:
    return sp.Add(*(sp.Float(w) * e for w, e in zip(row, terms, strict=True) if w))


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
