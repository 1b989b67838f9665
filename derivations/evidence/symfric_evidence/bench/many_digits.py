"""Reference motions in multiple precision, by extrapolated midpoint steps, independent of all routes and peers.

For any scene. Nothing but SymPy's expressions is taken from the package, and the mode is found by trying every
combination, so that neither the graphs nor the rule of the solvers are trusted.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import sympy as sp

from symfric.errors import NotFound
from symfric.model.contact_states import opposing, rates_by_side
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric_evidence.event_reference.equations import KinkRegister

Numbers = list[Any]  # of mpmath, which has no types
# per velocity, contacts and derivatives of their slips; and the solution of the linear equations
_Solver = tuple[list[list[tuple[int, Any]]], Callable[[Numbers], Numbers]]
_COLUMNS = 12  # columns of the extrapolation: order 24
_LONGEST = 0.4  # step
_GUARD = 8  # additional digits, since forces are sums of larger numbers
_LOCATE = 60  # most iterations for the time of an event
_SHORTEST = 1e-12  # step relative to the longest below which its inner nodes are not checked again


@dataclass(frozen=True)
class ManyDigits:
    """State at the horizon, shape (n_x,), and the number of events."""

    final: tuple[mp.mpf, ...]
    events: int


@dataclass(frozen=True)
class _Mode:
    """Direction of slip of every contact, 0 where it sticks, and the sign of every kink's argument."""

    slips: tuple[int, ...]
    sides: tuple[int, ...] = ()


@dataclass(frozen=True)
class _Forces:
    """Rates of all states; friction, slip, its rate and what is left of the bound per contact; arguments of kinks."""

    rates: Numbers
    pull: Numbers
    slip: Numbers
    gain: Numbers
    room: Numbers
    kinks: Numbers

    def guards(self, mode: _Mode) -> Numbers:
        """Return what is positive while the mode is right."""
        slips = [m * w if m else room for m, w, room in zip(mode.slips, self.slip, self.room, strict=True)]
        return [*slips, *(s * g for s, g in zip(mode.sides, self.kinks, strict=True))]


def many_digits(
    scene: Scene, digits: int = 28, start: Sequence[mp.mpf] | None = None, horizon: mp.mpf | None = None
) -> ManyDigits:
    """Compute the motion of a scene to a given number of digits, except the last few.

    Parameters
    ----------
    scene : Scene
        Smooth between its events, with no redundant contacts that stick, and not on a kink at the start. Its floats
        are the binary numbers that every route gets.
    digits : int
        Working precision; the error of a step is kept below 1e-8 of it.
    start : sequence of mpf, optional
        State at the start, in place of the scene's.
    horizon : mpf, optional
        In place of the scene's.

    Raises
    ------
    NotFound
        If no mode is consistent.

    Notes
    -----
    Gragg's midpoint rule, extrapolated by Aitken and Neville in the square of the step (Hairer, Norsett and Wanner,
    Solving Ordinary Differential Equations I, section II.9). Events by the Illinois rule on the length of the step.
    """
    with mp.workdps(digits + _GUARD):
        run = _Run(scene, mp.mpf(10) ** (8 - digits), mp.mpf(10) ** (4 - digits))
        return run.run(start, horizon)


def _number(value: float) -> mp.mpf:
    return mp.mpf(float(value))


class _Equations:
    """The scene's expressions as functions of numbers in multiple precision."""

    def __init__(self, scene: Scene):
        system, contacts = scene.system, scene.contacts
        self.n, self.n_c = len(system.q), len(contacts)
        self.smooth = [c.law.smooth for c in contacts]
        lines = {s: sp.symbols(f"{s.name}_0 {s.name}_1", real=True) for s in scene.inputs}
        along = {s: a + b * TIME for s, (a, b) in lines.items()}
        modes, kinks = sp.symbols(f"mode_:{self.n_c}", real=True), KinkRegister()
        known = {s: _number(v) for s, v in scene.numbers().items() if s not in system.states}

        def read(e: sp.Expr) -> sp.Expr:  # numbers become arguments, converted once
            e = kinks.pieces(sp.sympify(e).xreplace(along))
            powers = {p.exp for p in e.atoms(sp.Pow)}
            decimals = [a for a in e.atoms(sp.Number) - powers if not a.is_Integer]
            put = {a: sp.Symbol(f"number_{a}", real=True) for a in decimals}
            known.update({s: _number(a) if a.is_Float else mp.mpf(a.p) / a.q for a, s in put.items()})
            return e.xreplace(put)

        slips = [read(c.slip) for c in contacts]
        slopes = [w.diff(v) for w in slips for v in system.u]
        turning = [w.diff(TIME) + sum(w.diff(a) * b for a, b in zip(system.q, system.u, strict=True)) for w in slips]
        loads = [read(c.normal * c.profile) for c in contacts]
        laws = [read(opposing(c, m)) for c, m in zip(contacts, modes, strict=True)]
        bounds = [read(c.law.stick) for c in contacts]
        force, rates = (
            [read(e) for e in several] for several in (system.force, rates_by_side(system, contacts, modes))
        )
        parts = [force, rates, slips, turning, loads, laws, bounds]
        matrices = [[read(e) for e in system.mass], slopes]
        self.constant = not set().union(*(e.free_symbols for e in itertools.chain(*matrices))) - set(known)
        head = [TIME, *system.states, *itertools.chain(*lines.values())]
        arguments = [*head, *modes, *kinks.signs, *known]
        own = [{"select": lambda side, above, below: above if side > 0 else below}, "mpmath"]
        self._parts = sp.lambdify(arguments, [*parts, list(kinks.guards)], own, cse=True)
        self._matrices = sp.lambdify(arguments, matrices, own, cse=True)
        self._known = tuple(known.values())
        self._inverses: dict[tuple[int, ...], _Solver] = {}
        self.n_k, self.line = len(kinks.guards), [mp.mpf(0)] * (2 * len(lines))

    def __call__(self, t: mp.mpf, y: Numbers, mode: _Mode) -> _Forces:
        """Return the forces and rates of a mode; raise ZeroDivisionError if its contacts cannot all stick."""
        n, slips = self.n, mode.slips
        arguments = (t, *y, *self.line, *slips, *mode.sides, *self._known)
        force, z_rate, slip, turning, load, law, bound, kinks = self._parts(*arguments)
        held = tuple(i for i in range(self.n_c) if slips[i] == 0)
        pull = [-m * normal * mu if m else mp.mpf(0) for m, normal, mu in zip(slips, load, law, strict=True)]
        slopes, solve = self._solver(held, arguments)
        right = [f + sum(pull[i] * s for i, s in column if slips[i]) for f, column in zip(force, slopes, strict=True)]
        solution = solve([*right, *(-turning[i] for i in held)])
        for i, value in zip(held, solution[n:], strict=True):
            pull[i] = value
        gain = list(turning)
        for a, column in zip(solution, slopes, strict=False):
            for i, s in column:
                gain[i] += s * a
        room = [normal * most - abs(p) for normal, most, p in zip(load, bound, pull, strict=True)]
        return _Forces([*y[n : 2 * n], *solution[:n], *z_rate], pull, slip, gain, room, kinks)

    def at_rest(self, t: mp.mpf, y: Numbers, mode: _Mode) -> Numbers:
        """Return the state with the slips of sticking contacts set to zero."""
        held = tuple(i for i, m in enumerate(mode.slips) if m == 0)
        if not held:
            return y
        arguments = (t, *y, *self.line, *mode.slips, *mode.sides, *self._known)
        slip, solve = self._parts(*arguments)[2], self._solver(held, arguments)[1]
        change = solve([*[mp.mpf(0)] * self.n, *(-slip[i] for i in held)])
        u = [a + b for a, b in zip(y[self.n : 2 * self.n], change, strict=False)]
        return [*y[: self.n], *u, *y[2 * self.n :]]

    def _solver(self, held: tuple[int, ...], arguments: tuple[Any, ...]) -> _Solver:
        """Return, per velocity, contacts and derivatives of their slips, and the solution of the linear equations."""
        if held in self._inverses:
            return self._inverses[held]
        n, (mass, rows) = self.n, self._matrices(*arguments)
        slopes = [[(i, rows[i * n + k]) for i in range(self.n_c) if rows[i * n + k]] for k in range(n)]
        matrix = [[*mass[k * n : k * n + n], *(-rows[i * n + k] for i in held)] for k in range(n)]
        matrix += [[*rows[i * n : i * n + n], *[mp.mpf(0)] * len(held)] for i in held]
        if not self.constant:
            return slopes, lambda right: _solved([[*row, r] for row, r in zip(matrix, right, strict=True)])
        size = range(len(matrix))
        columns = [_solved([[*matrix[k], mp.mpf(int(k == j))] for k in size]) for j in size]
        inverse = [[(j, columns[j][k]) for j in size if columns[j][k]] for k in size]
        solve = lambda right: [sum((c * right[j] for j, c in row), mp.mpf(0)) for row in inverse]  # noqa: E731
        self._inverses[held] = slopes, solve
        return slopes, solve


def _solved(rows: list[Numbers]) -> Numbers:
    """Eliminate with the largest pivots; the last column is the right-hand side."""
    size, rows = len(rows), list(rows)
    for k in range(size):
        best = max(range(k, size), key=lambda r: abs(rows[r][k]))
        rows[k], rows[best] = rows[best], rows[k]
        if abs(rows[k][k]) <= 1e6 * mp.eps:
            raise ZeroDivisionError("a pivot vanishes")
        for r in range(k + 1, size):
            factor = rows[r][k] / rows[k][k]
            if factor:
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[k], strict=True)]
    solution: Numbers = [None] * size
    for k in reversed(range(size)):
        solution[k] = (rows[k][-1] - mp.fdot(rows[k][k + 1 : -1], solution[k + 1 :])) / rows[k][k]
    return solution


class _Run:
    """One run, from mode to mode."""

    def __init__(self, scene: Scene, little: mp.mpf, noise: mp.mpf):
        self.equations, self.little, self.noise = _Equations(scene), little, noise
        self._signals = tuple(scene.inputs.values())
        self._y: Numbers = [_number(scene.numbers()[s]) for s in scene.system.states]
        self._end, self._h = _number(scene.horizon), mp.mpf(_LONGEST) / 8

    def run(self, start: Sequence[mp.mpf] | None = None, horizon: mp.mpf | None = None) -> ManyDigits:
        """Integrate between the kinks of sampled inputs, and between events."""
        if horizon is not None:
            self._end = horizon
        y, t, events = list(self._y if start is None else start), mp.mpf(0), 0
        mode: _Mode | None = None
        for stop in self._stops():
            self._inputs(t, stop)
            before, mode = mode, self._first(t, y) if mode is None else self._mode(t, y, {}, mode)
            events += self._changes(before, mode)
            while t < stop:
                t, y, fallen = self._advance(t, y, mode, stop)
                if fallen is not None:
                    before, mode = mode, self._after(t, y, mode, fallen)
                    y = self.equations.at_rest(t, y, mode)
                    events += self._changes(before, mode)
        return ManyDigits(tuple(y), events)

    def _changes(self, before: _Mode | None, after: _Mode) -> int:
        if before is None:
            return 0
        pairs = zip(before.slips, after.slips, self.equations.smooth, strict=True)
        return sum(a != b and not smooth for a, b, smooth in pairs)

    def _stops(self) -> Numbers:
        grids = [[_number(s.t0) + k * _number(s.dt) for k in range(s.samples.size)] for s in self._signals]
        return [*sorted({t for t in itertools.chain(*grids) if 0 < t < self._end}), self._end]

    def _inputs(self, t: mp.mpf, stop: mp.mpf) -> None:
        """Set the linear inputs between two stops."""
        line = []
        for signal in self._signals:
            dt, k = _number(signal.dt), int(mp.floor(((t + stop) / 2 - _number(signal.t0)) / _number(signal.dt)))
            inside = 0 <= k < signal.samples.size - 1
            left, right = map(_number, signal.samples[[k, k + 1]] if inside else (0.0, 0.0))
            slope = (right - left) / dt
            line += [left - slope * (_number(signal.t0) + k * dt), slope]
        self.equations.line = line

    def _first(self, t: mp.mpf, y: Numbers) -> _Mode:
        """Return the mode of the start."""
        n_c, n_k = self.equations.n_c, self.equations.n_k
        slip = self.equations(t, y, _Mode((1,) * n_c, (1,) * n_k)).slip
        moving = _Mode(tuple(1 if w >= 0 else -1 for w in slip), (1,) * n_k)
        kinks = self.equations(t, y, moving).kinks
        if any(abs(g) <= self.little for g in kinks):
            raise NotFound("the start lies on a kink of the forces")
        sides = tuple(1 if g > 0 else -1 for g in kinks)
        return self._mode(t, y, {}, _Mode(moving.slips, sides))

    def _after(self, t: mp.mpf, y: Numbers, mode: _Mode, fallen: int) -> _Mode:
        """Return the mode after a guard has fallen."""
        n_c = self.equations.n_c
        if fallen >= n_c:
            sides = tuple(-s if k == fallen - n_c else s for k, s in enumerate(mode.sides))
            return self._mode(t, y, {}, _Mode(mode.slips, sides))  # forces may have stepped
        known = 0
        if mode.slips[fallen] == 0:
            known = -1 if self.equations(t, y, mode).pull[fallen] > 0 else 1
        return self._mode(t, y, {fallen: known}, mode)

    def _mode(self, t: mp.mpf, y: Numbers, known: dict[int, int], before: _Mode) -> _Mode:
        """Return the one consistent mode; `known` names a contact at zero slip (0) or its release (-1, 1)."""
        equations, slip = self.equations, self.equations(t, y, before).slip
        ways: list[tuple[int, ...]] = []
        for i in range(equations.n_c):
            if known.get(i, 0) != 0:
                ways.append((known[i],))
            elif i in known or before.slips[i] == 0 or abs(slip[i]) <= self.little:
                ways.append((1, -1) if equations.smooth[i] else (0, 1, -1))
            else:
                ways.append((1 if slip[i] > 0 else -1,))
        for slips in sorted(itertools.product(*ways), key=lambda m: sum(map(abs, m))):
            mode = _Mode(slips, before.sides)
            try:
                forces = equations(t, y, mode)
            except ZeroDivisionError:
                continue
            if all(
                forces.room[i] >= -self.little if slips[i] == 0 else slips[i] * forces.gain[i] > 0 or known.get(i)
                for i in range(equations.n_c)
                if len(ways[i]) > 1 or slips[i] == 0
            ):
                return mode
        raise NotFound(f"no consistent mode at t = {mp.nstr(t, 8)}")

    def _advance(self, t: mp.mpf, y: Numbers, mode: _Mode, stop: mp.mpf) -> tuple[mp.mpf, Numbers, int | None]:
        """Integrate to the stop or to the first event; return time, state and the guard that fell."""
        while True:
            h = min(self._h, stop - t)
            after, error, guards = self._step(t, y, mode, h)
            if error > self.little:
                self._h = h * max(mp.mpf("0.2"), self._factor(error))
                continue
            node, fallen = self._first_fallen(guards)
            if fallen is not None and h > _SHORTEST * _LONGEST and self._doubtful(t, y, mode, h, guards, node, fallen):
                self._h = h / 2
                continue
            if fallen is not None:
                also = [g for g, value in enumerate(guards[node]) if value < -self.noise]  # the earliest may be another
                found = [(*self._located(t, y, mode, h, guards, g), g) for g in also]
                return min(found, key=lambda event: event[0])
            t, y = (stop if h == stop - t else t + h), after
            if h == self._h or error > 0.1 * self.little:
                self._h = min(h * min(mp.mpf(2), self._factor(error)), mp.mpf(_LONGEST))
            if t >= stop:
                return t, y, None

    def _doubtful(
        self, t: mp.mpf, y: Numbers, mode: _Mode, h: mp.mpf, guards: list[Numbers], node: int, fallen: int
    ) -> bool:
        """Whether a guard that fell at a node inside the step, where values are rough, stands there and at the end."""
        nodes = len(guards) - 1
        return node < nodes and guards[-1][fallen] >= 0 and self._guards(t, y, mode, h * node / nodes)[0][fallen] >= 0

    def _factor(self, error: mp.mpf) -> mp.mpf:
        """Return by how much a step may grow."""
        return 0.8 * (self.little / error) ** (mp.mpf(1) / (2 * _COLUMNS - 1)) if error else mp.mpf(2)

    def _step(self, t: mp.mpf, y: Numbers, mode: _Mode, h: mp.mpf) -> tuple[Numbers, mp.mpf, list[Numbers]]:
        """Advance by h; return the state, its error, and the guards at the nodes of the finest column."""
        seen: list[_Forces] = []

        def rate(at: mp.mpf, now: Numbers) -> Numbers:
            seen.append(self.equations(at, now, mode))
            return seen[-1].rates

        final, before = _midpoint(rate, t, y, h)
        scale = [max(abs(a), abs(b), mp.mpf(1) / 10) for a, b in zip(final, y, strict=True)]
        error = max(abs(a - b) / s for a, b, s in zip(final, before, scale, strict=True))
        nodes = [seen[0], *seen[-2 * _COLUMNS : -1], self.equations(t + h, final, mode)]
        return final, error, [forces.guards(mode) for forces in nodes]

    def _guards(self, t: mp.mpf, y: Numbers, mode: _Mode, h: mp.mpf) -> tuple[Numbers, Numbers]:
        """Return guards and state after a step of length h."""
        state = self._step(t, y, mode, h)[0]
        return self.equations(t + h, state, mode).guards(mode), state

    def _first_fallen(self, guards: list[Numbers]) -> tuple[int, int | None]:
        """Return node and row of the first guard that is negative beyond rounding."""
        for node, row in enumerate(guards[1:], 1):
            if row and min(row) < -self.noise:
                return node, row.index(min(row))
        return 0, None

    def _located(
        self, t: mp.mpf, y: Numbers, mode: _Mode, h: mp.mpf, guards: list[Numbers], which: int
    ) -> tuple[mp.mpf, Numbers]:
        """Return time and state where a guard falls, by the Illinois rule on the length of the step."""
        nodes = len(guards) - 1
        k = next(k for k in range(1, nodes + 1) if guards[k][which] < -self.noise)

        def value(length: mp.mpf) -> tuple[mp.mpf, Numbers]:
            guards, state = self._guards(t, y, mode, length)
            return guards[which], state

        part = h / nodes
        k_low, high = k - 1, k * part
        below, state = value(high)
        while below >= 0:  # the nodes inside a step are rough
            high += part
            below, state = value(high)
        above = value(k_low * part)[0] if k_low else guards[0][which]
        while k_low and above < 0:
            high, below, k_low = k_low * part, above, k_low - 1
            above = value(k_low * part)[0] if k_low else guards[0][which]
        low = k_low * part
        above = above if above > 0 else -below * mp.eps  # it starts at zero where a slip begins
        for _ in range(_LOCATE):
            length = (low * below - high * above) / (below - above)
            now, state = value(length)
            if abs(now) <= self.noise / 100 or high - low <= self.noise / 100 * high:
                break
            if now < 0:
                high, below, above = length, now, above / 2
            else:
                low, above, below = length, now, below / 2
        return t + length, state


def _midpoint(rate: Callable[[mp.mpf, Numbers], Numbers], t: mp.mpf, y: Numbers, h: mp.mpf) -> tuple[Numbers, Numbers]:
    """Extrapolate the midpoint rule over a step h; return the state of the last column and of the one before.

    ``rate(t, y)`` is asked at the start once, and then, column after column, at the inner nodes and the end of each.
    """
    row: list[Numbers] = []
    start = rate(t, y)
    for j in range(1, _COLUMNS + 1):
        n = 2 * j
        part = h / n
        before, now = y, [a + part * b for a, b in zip(y, start, strict=True)]
        for i in range(1, n):
            slope = rate(t + i * part, now)
            before, now = now, [a + 2 * part * b for a, b in zip(before, slope, strict=True)]
        slope = rate(t + h, now)
        coarser, row = row, [[(a + b + part * c) / 2 for a, b, c in zip(now, before, slope, strict=True)]]
        for i, old in enumerate(coarser, 1):
            factor = (mp.mpf(n) / (2 * (j - i))) ** 2 - 1
            row.append([a + (a - b) / factor for a, b in zip(row[-1], old, strict=True)])
    return row[-1], row[-2]
