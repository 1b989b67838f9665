"""A scene's equations as an engineer would write them for another solver: one list of rates, a sign for each contact.

Nothing of this package's own lowering is used, so that what the peers compute is independent of it.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import sympy as sp

from symfric.model.excitation import excitation_of
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import System
from symfric_evidence.bench.result import BenchAnswer

Step = tuple[float, list[float], int | None]  # time, state, and the guard that fell, None at the end
Advance = Callable[[float, list[float], list[float], list[float], float], Step]
Arrival = Callable[[float, list[float], list[float], list[float]], bool]
_ROUNDING = 1e-14  # relative rounding error of numbers combined by SymPy
_SAMPLES = 64  # samples of a period at which a holding force is evaluated


@dataclass(frozen=True)
class WrittenForm:
    """Equations of a scene whose contacts share no body, in numbers.

    Attributes
    ----------
    states : tuple of Symbol
    start : tuple of float
    horizon : float
    rates : tuple of Expr
        In states, time, `signs`, `moving` and `line`.
    signs : tuple of Symbol
        Direction of slip of each contact, and then the sign of what stands in each absolute value.
    moving : tuple of Symbol
        1 where a contact slips, 0 where it sticks; the force that holds it stands in `rates` then.
    slips, holds, limits : tuple of Expr
        Per contact: relative velocity, force that holds it, largest such force.
    kinks : tuple of Expr
        What stands in the absolute values.
    shares : ndarray, shape (contacts, states)
        What a unit of slip is in the states, to take off what rounding leaves of it.
    line : tuple of Symbol
        The input is ``line[0] + line[1] t`` on each segment; nothing without inputs.
    segments : tuple of tuple of float
        End of each segment and its line.
    straight : bool
        Whether velocities are constant where all contacts stick.
    hold_rates : tuple of Expr or None
        The rates of `holds` there, if they are constant too.
    parameters : tuple of Symbol
        What was left to be given, in the order of the arguments.
    apart : bool
        Whether rates and guards hold where the one contact slips only.
    fastest : float
        Shortest period of the sines of time; infinite without them.
    """

    states: tuple[sp.Symbol, ...]
    start: tuple[float, ...]
    horizon: float
    rates: tuple[sp.Expr, ...]
    signs: tuple[sp.Symbol, ...]
    moving: tuple[sp.Symbol, ...]
    slips: tuple[sp.Expr, ...]
    holds: tuple[sp.Expr, ...]
    limits: tuple[sp.Expr, ...]
    kinks: tuple[sp.Expr, ...]
    shares: np.ndarray
    line: tuple[sp.Symbol, ...]
    segments: tuple[tuple[float, ...], ...]
    straight: bool = False
    hold_rates: tuple[sp.Expr, ...] | None = None
    parameters: tuple[sp.Symbol, ...] = ()
    apart: bool = False
    fastest: float = math.inf

    @property
    def arguments(self) -> tuple[sp.Symbol, ...]:
        """What every expression may contain, in the order of the compiled functions."""
        return (TIME, *self.states, *self.signs, *self.moving, *self.line, *self.parameters)

    def with_rest_apart(self) -> "WrittenForm":
        """Return the form of one contact without the terms of sticking, where `Loop.resting` takes their place."""
        if len(self.moving) != 1 or not self.straight:
            return self
        return replace(self, rates=tuple(e.subs(self.moving[0], 1) for e in self.rates), apart=True)

    @property
    def guards(self) -> tuple[sp.Expr, ...]:
        """Per contact and absolute value: positive while its sign, or its sticking, lasts."""
        if self.apart:
            slipping = [self.signs[0] * self.slips[0]]
            return (*slipping, *(s * e for s, e in zip(self.signs[1:], self.kinks, strict=True)))
        contacts = zip(self.signs, self.moving, self.slips, self.limits, self.holds, strict=False)
        lasting = [m * s * w + (1 - m) * (limit**2 - hold**2) for s, m, w, limit, hold in contacts]
        return (*lasting, *(s * e for s, e in zip(self.signs[len(self.moving) :], self.kinks, strict=True)))


class branch(sp.Function):  # noqa: N801  (a SymPy function is named as it is called)
    """The second argument where the first is positive, the third elsewhere."""

    nargs = 3


def form_of(scene: Scene, given: tuple[sp.Symbol, ...] = (), *, through: bool = False) -> WrittenForm:
    """Write a scene out; the parameters in `given` keep their symbols.

    With `through`, smooth laws of one branch or two are forces with `branch` in them, for solvers without events.

    Raises
    ------
    NotImplementedError
        If two contacts work on one body, a law is smooth or has branches, or the scene has several inputs.
    """
    system, numbers = scene.system, scene.numbers()
    known = {s: v for s, v in numbers.items() if s in scene.values and s not in given}
    line: tuple[sp.Symbol, ...] = sp.symbols("line0 line1", real=True) if scene.inputs else ()
    if len(scene.inputs) > 1:
        raise NotImplementedError("several inputs")
    if any(c.law.memory for c in scene.contacts):
        raise NotImplementedError("a friction law with memory")
    contacts = [c for c in scene.contacts if not (through and c.law.smooth and len(c.law.breaks) < 2)]
    if any(c.law.smooth or c.law.breaks for c in contacts):
        raise NotImplementedError("a smooth friction law, or one with branches")
    for signal in scene.inputs:
        known[signal] = line[0] + line[1] * TIME

    def read(e: sp.Expr) -> sp.Expr:
        return sp.sympify(e).subs(known)

    states, mass = system.states, sp.Matrix(system.mass).subs(known)
    slips = [read(c.slip) for c in contacts]
    jacobian = sp.Matrix([[w.diff(v) for v in system.u] for w in slips]).reshape(len(slips), len(system.u))
    inverse = mass.inv()
    coupling = jacobian * inverse * jacobian.T
    if not coupling.is_diagonal():
        raise NotImplementedError("two contacts work on one body")
    force = sp.Matrix([read(e) for e in system.force])
    for contact in (c for c in scene.contacts if c not in contacts):
        w = read(contact.slip)
        pull = read(contact.normal * contact.profile) * _branched(contact.law, w)
        force -= sp.Matrix([w.diff(v) * pull for v in system.u])
    free = inverse * force
    signs = sp.symbols(f"sign0:{len(slips)}", real=True)
    moving = sp.symbols(f"moving0:{len(slips)}", real=True)
    holds = [(jacobian.row(j) * free)[0] / coupling[j, j] for j in range(len(slips))]
    limits, rates, unit = [], list(free), inverse * jacobian.T
    for j, contact in enumerate(contacts):
        load, law = read(contact.normal * contact.profile), contact.law
        limits.append(load * read(law.stick))
        sliding = load * _odd(read(law.kinetic), signs[j], slips[j])
        for i in range(len(rates)):
            if unit[i, j]:
                held = sp.expand(rates[i] - unit[i, j] * holds[j])  # often zero where a contact sticks
                rest = sp.Integer(0) if not held.free_symbols and abs(held) < _ROUNDING else held
                if rest == 0:
                    rates[i] = moving[j] * (rates[i] - unit[i, j] * sliding)
                else:
                    rates[i] -= unit[i, j] * (moving[j] * sliding + (1 - moving[j]) * holds[j])
    straight = bool(moving) and not system.z and not any(sp.sympify(e).subs(dict.fromkeys(moving, 0)) for e in rates)
    rates = [*system.u, *rates, *(read(e) for e in system.z_rate)]
    kinks = [] if through else sorted({a.args[0] for e in rates for a in e.atoms(sp.Abs)}, key=str)
    kink_signs = sp.symbols(f"sign{len(slips)}:{len(slips) + len(kinks)}", real=True)
    plain = {sp.Abs(e): s * e for e, s in zip(kinks, kink_signs, strict=True)}
    shares = np.zeros((len(slips), len(states)))
    for j, i in itertools.product(range(len(slips)), range(len(system.u))):
        shares[j, len(system.q) + i] = float(unit[i, j] / coupling[j, j])
    return WrittenForm(
        states=tuple(states),
        start=tuple(float(numbers[s]) for s in states),
        horizon=scene.horizon,
        rates=tuple(e.xreplace(plain) for e in rates),
        signs=(*signs, *kink_signs),
        moving=tuple(moving),
        slips=tuple(slips),
        holds=tuple(holds),
        limits=tuple(limits),
        kinks=tuple(kinks),
        shares=shares,
        line=line,
        segments=_segments(scene),
        straight=straight,
        hold_rates=_hold_rates(system, holds, limits) if straight else None,
        parameters=given,
        fastest=_fastest(scene),
    )


def _fastest(scene: Scene) -> float:
    excitation = excitation_of(scene)
    rates = np.abs(excitation.frequencies({s.name: v for s, v in scene.numbers().items()}))
    return 2 * math.pi / float(np.max(rates)) if excitation.rates else math.inf


def _branched(law: Law, slip: sp.Expr) -> sp.Expr:
    """Return friction over load of a smooth law of one branch or two."""
    sign = sp.sign(slip)
    if not law.breaks:
        return _odd(law.kinetic, sign, slip)
    (inner, _), (outer, _) = law.kinetic.args
    near, far = _odd(inner, sp.Integer(1), slip), sign * _odd(outer, sp.Integer(1), SPEED)
    return branch(law.breaks[0] - sp.Abs(slip), near, far.subs(SPEED, sp.Abs(slip)))


def _odd(kinetic: sp.Expr, sign: sp.Symbol, slip: sp.Expr) -> sp.Expr:
    """Return friction over load; even powers of the sign leave a polynomial, and products stand for powers."""
    if not kinetic.is_polynomial(SPEED):
        return sign * kinetic.subs(SPEED, sign * slip)
    result, coefficients = sp.Integer(0), sp.Poly(kinetic, SPEED).all_coeffs()
    for k, c in zip(range(len(coefficients) - 1, -1, -1), coefficients, strict=True):
        result = result * slip + (c if k % 2 else c * sign)
    return result


def _hold_rates(system: System, holds: list[sp.Expr], limits: list[sp.Expr]) -> tuple[sp.Expr, ...] | None:
    """Return the rates of the holding forces at constant velocities, if they are constant."""
    varying = {TIME, *system.q}
    changes = [e.diff(TIME) + sum(e.diff(a) * b for a, b in zip(system.q, system.u, strict=True)) for e in holds]
    return None if any(e.free_symbols & varying for e in (*changes, *limits)) else tuple(changes)


def _segments(scene: Scene) -> tuple[tuple[float, ...], ...]:
    if not scene.inputs:
        return ((scene.horizon,),)
    (signal,) = scene.inputs.values()
    segments, times = [], signal.t0 + signal.dt * np.arange(signal.samples.size)
    for t, end, left, right in zip(times, times[1:], signal.samples, signal.samples[1:], strict=False):
        slope = (right - left) / signal.dt
        segments.append((float(min(end, scene.horizon)), float(left - slope * t), float(slope)))
    return (*(s for s in segments if s[0] <= scene.horizon), (scene.horizon, 0.0, 0.0))


class PeerLoop:
    """The stick-slip logic around a solver that integrates to the next event.

    Parameters
    ----------
    form : WrittenForm
    advance : callable, optional
        ``advance(t, y, mode, line, end) -> (t, y, k)``, with k the number of the guard that fell, None at the end; y a
        list, mode the signs and then `moving`, line followed by the parameters.
    """

    def __init__(self, form: WrittenForm, advance: Advance | None = None):
        self._form, self._advance = form, advance
        self._contacts, self._signs = len(form.moving), len(form.signs)
        compiled = partial(sp.lambdify, form.arguments, modules="math", cse=True)
        self._at = [compiled(list(e)) for e in zip(form.slips, form.holds, form.limits, strict=True)]
        self._positions = range(len(form.states) // 2)
        self._kinks = compiled(list(form.kinks))
        rates = None if form.hold_rates is None else zip(form.hold_rates, form.holds, form.limits, strict=True)
        self._rest = None if rates is None else compiled([list(e) for e in rates])
        self.shares = [[(i, share) for i, share in enumerate(row) if share] for row in form.shares.tolist()]
        self.arrivals = [self._arrival(k) for k in range(self._contacts)]

    def __call__(self) -> BenchAnswer:
        """Run once."""
        y = list(self._form.start)
        y, _, events = self.run(0.0, y, self.first(y), self._form.segments)
        return BenchAnswer(tuple(y), events)

    def run(
        self,
        t: float,
        y: list[float],
        mode: list[float],
        segments: Sequence[tuple[float, ...]],
        parameters: Sequence[float] = (),
    ) -> tuple[list[float], list[float], int]:
        """Integrate over the segments of the input; return state, mode and the number of events."""
        events, advance = 0, self._advance
        assert advance is not None, "a loop without a solver only finds modes"
        for end, *line in segments:
            line += parameters
            while t < end:
                if self.rests(mode):
                    t, y, released = self.resting(t, y, mode, line, end)
                    events += released
                else:
                    t, y, k = advance(t, y, mode, line, end)
                    if k is not None:
                        events += self.after(t, y, mode, line, k)
        return y, mode, events

    def rests(self, mode: list[float]) -> bool:
        """Whether all contacts stick and velocities are constant until one slips."""
        return self._form.straight and 1.0 not in mode[self._signs :]

    def resting(
        self, t: float, y: list[float], mode: list[float], line: list[float], end: float
    ) -> tuple[float, list[float], bool]:
        """Advance a system at rest to the end or to the first release; return time, state and whether one occurred."""
        n, release, first, sign = len(self._positions), end, None, 0.0
        if self._rest is None:
            release, first, sign = self._searched(t, y, mode, line, end)
        else:
            for k, (rate, hold, limit) in enumerate(self._rest(t, *y, *mode, *line)):
                at = t + ((limit if rate > 0.0 else -limit) - hold) / rate if rate else end
                if at < release:
                    release, first = max(at, t), k
                    sign = 1.0 if rate > 0.0 else -1.0
        length = release - t
        for i in self._positions:
            y[i] += y[n + i] * length
        if first is None:
            return release, y, False
        mode[first], mode[self._signs + first] = sign, 1.0
        return release, y, True

    def _searched(
        self, t: float, y: list[float], mode: list[float], line: list[float], end: float
    ) -> tuple[float, int | None, float]:
        """Search for the first release: time, contact and direction, where there is no formula."""
        from scipy.optimize import brentq

        n, start = len(y) // 2, t

        def hold_of(at: float, k: int) -> tuple[float, float]:
            moved = [q + u * (at - start) for q, u in zip(y, y[n:], strict=False)]
            _, hold, limit = self._at[k](at, *moved, *y[n:], *mode, *line)
            return hold, limit

        def left(at: float, k: int) -> float:
            hold, limit = hold_of(at, k)
            return limit - abs(hold)

        part = min(self._form.fastest, end - t) / _SAMPLES
        while t < end:
            until = min(t + part, end)
            fallen = [k for k in range(self._contacts) if left(until, k) < 0]
            if fallen:
                releases = [(brentq(left, t, until, (k,), 1e-15) if left(t, k) > 0 else t, k) for k in fallen]
                first, k = min(releases)
                return first, k, 1.0 if hold_of(first, k)[0] > 0.0 else -1.0
            t = until
        return end, None, 0.0

    def first(self, y: list[float], parameters: Sequence[float] = ()) -> list[float]:
        """Return the mode of the start."""
        line = [*self._form.segments[0][1:], *parameters]
        mode = [1.0] * (self._signs + self._contacts)
        for k, at in enumerate(self._at):
            w, hold, limit = at(0.0, *y, *mode, *line)
            mode[k] = 1.0 if (hold if w == 0 else w) > 0 else -1.0
            mode[self._signs + k] = float(w != 0 or abs(hold) > limit)
        for k, e in enumerate(self._kinks(0.0, *y, *mode, *line), self._contacts):
            mode[k] = 1.0 if e > 0 else -1.0
        return mode

    def after(self, t: float, y: list[float], mode: list[float], line: list[float], k: int) -> bool:
        """Change state and mode after guard k has fallen; return whether the contact turned, stuck or was released."""
        if k < self._contacts:
            return self.arrivals[k](t, y, mode, line)
        mode[k] = -mode[k]
        return False

    def _arrival(self, k: int) -> Arrival:
        """Return `after` for the guard of one contact."""
        at, place, shares = self._at[k], self._signs + k, self.shares[k]

        def arrive(t: float, y: list[float], mode: list[float], line: list[float]) -> bool:
            w, hold, limit = at(t, *y, *mode, *line)
            sign = 1.0 if hold > 0.0 else -1.0
            if mode[place] == 0.0:
                mode[k], mode[place] = sign, 1.0
                return True
            for i, share in shares:
                y[i] -= w * share
            if -limit <= hold <= limit:
                mode[place] = 0.0
                return True
            changed, mode[k] = mode[k] != sign, sign
            return changed

        return arrive
