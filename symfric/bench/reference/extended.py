"""Motions in many digits: extrapolated midpoint steps in multiple precision, independent of every route.

For any scene with smooth forces. The equations come straight from SymPy; the mode is found by trying every combination,
so that neither the graphs nor the rule of the solvers are trusted.
"""

import itertools
from dataclasses import dataclass

import mpmath as mp
import sympy as sp

from symfric.bench.reference.extrapolation import midpoint
from symfric.errors import NotFound
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME

_COLUMNS = 9  # of the extrapolation: order 18
_LONGEST = 0.4  # step
_MOST_STEPS = 5_000
_NOISE = 1e4  # roundings
_LOCATE = 60  # iterations for the time of an event


@dataclass(frozen=True)
class Extended:
    """State at the horizon, shape (n_x,), and the number of changes of mode on the way."""

    final: tuple[mp.mpf, ...]
    events: int


class _Equations:
    """The scene's expressions in multiple precision; numbers are the doubles that every route gets."""

    def __init__(self, scene: Scene):
        system, contacts = scene.system, scene.contacts
        self.n, self.n_c = len(system.q), len(contacts)
        number = {s: sp.Float(v, mp.mp.dps) for s, v in scene.numbers().items() if s not in system.states}
        state = (*system.q, *system.u, TIME)
        slips = sp.Matrix([c.slip for c in contacts])
        turning = slips.jacobian(system.q) * sp.Matrix(system.u) + slips.diff(TIME)
        parts = [system.mass, system.force, slips, slips.jacobian(system.u), turning]
        parts.append([c.normal * c.profile for c in contacts])
        self.at = sp.lambdify(state, [[e.subs(number) for e in sp.flatten(p)] for p in parts], "mpmath", cse=True)
        self.laws = [sp.lambdify(SPEED, c.law.kinetic.subs(number), "mpmath") for c in contacts]
        self.bounds = [mp.mpf(sp.Float(c.law.stick.subs(number), mp.mp.dps)) for c in contacts]

    def forces(self, y: list, t, mode: tuple[int, ...]) -> tuple[list, list, list, list]:
        """Return accelerations, friction forces, slips, and slip accelerations; raise if contacts cannot all stick."""
        n = self.n
        mass, force, slip, slopes, turning, load = self.at(*y, t)
        held = [i for i in range(self.n_c) if mode[i] == 0]
        pull = [mp.mpf(0)] * self.n_c
        right = list(force)
        for i in range(self.n_c):
            if mode[i]:
                pull[i] = -mode[i] * load[i] * self.laws[i](mode[i] * slip[i])
                for k in range(n):
                    right[k] += slopes[i * n + k] * pull[i]
        rows = [[*mass[k * n : k * n + n], *(-slopes[i * n + k] for i in held), right[k]] for k in range(n)]
        rows += [[*slopes[i * n : i * n + n], *[mp.mpf(0)] * len(held), -turning[i]] for i in held]
        solution = _solve(rows)
        for i, force_of in zip(held, solution[n:], strict=True):
            pull[i] = force_of
        rate = solution[:n]
        gain = [mp.fdot(slopes[i * n : i * n + n], rate) + turning[i] for i in range(self.n_c)]
        return rate, pull, slip, gain

    def room(self, y: list, t, i: int, pull) -> mp.mpf:
        """Return how much more friction contact i can carry while it sticks."""
        return self.at(*y, t)[5][i] * self.bounds[i] - abs(pull)


def extended(scene: Scene, digits: int = 28) -> Extended:
    """Compute the motion of a scene to all but the last few of so many digits.

    Parameters
    ----------
    scene : Scene
        With forces and laws that are smooth between its events, and no redundant contacts that stick.
    digits : int
        Working precision; the error of a step is kept below 1e-8 of it.

    Raises
    ------
    NotFound
        If no mode is consistent, or more than 5000 steps are needed.
    """
    with mp.workdps(digits):
        equations = _Equations(scene)
        numbers = scene.numbers()
        y, t, end = [mp.mpf(numbers[s]) for s in scene.system.states], mp.mpf(0), mp.mpf(scene.horizon)
        little = mp.mpf(10) ** (8 - digits)
        mode = _mode(equations, y, t, {}, little)
        events, h = 0, mp.mpf(_LONGEST) / 8
        for _ in range(_MOST_STEPS):
            h = min(h, end - t)
            after, error, guards = _step(equations, mode, y, t, h)
            if error > little:
                h /= 2
                continue
            fallen = _first_fallen(guards)
            if fallen is None:
                y, t = after, t + h
                if t >= end:
                    return Extended(tuple(y), events)
                h = min(h * (1 if error > 1e-4 * little else mp.mpf("1.5")), mp.mpf(_LONGEST))
                continue
            y, t = _locate(equations, mode, y, t, h, guards, fallen)
            known = {fallen: 0 if mode[fallen] else -1 if equations.forces(y, t, mode)[1][fallen] > 0 else 1}
            new = _mode(equations, y, t, known, little, mode)
            events, mode = events + sum(a != b for a, b in zip(mode, new, strict=True)), new
            h = min(h, mp.mpf(_LONGEST) / 8)
        raise NotFound(f"more than {_MOST_STEPS} steps in multiple precision; shorten the horizon")


def _mode(equations: _Equations, y, t, known: dict[int, int], little, before=None) -> tuple[int, ...]:
    """Return the one consistent mode; `known` names a contact at zero slip (0) or its release (-1, 1)."""
    slip = equations.at(*y, t)[2]
    ways: list[tuple[int, ...]] = []
    for i in range(equations.n_c):
        still = before is not None and before[i] == 0
        if known.get(i, 0) != 0:
            ways.append((known[i],))
        elif i in known or still or abs(slip[i]) <= little:
            ways.append((0, 1, -1))
        else:
            ways.append((1 if slip[i] > 0 else -1,))
    for mode in sorted(itertools.product(*ways), key=lambda m: sum(map(abs, m))):
        try:
            _, pull, _, gain = equations.forces(y, t, mode)
        except ZeroDivisionError:
            continue
        right = all(
            equations.room(y, t, i, pull[i]) >= -little if mode[i] == 0 else mode[i] * gain[i] > 0 or known.get(i)
            for i in range(equations.n_c)
            if len(ways[i]) > 1 or mode[i] == 0
        )
        if right:
            return mode
    raise NotFound(f"no consistent mode at t = {mp.nstr(t, 8)}")


def _step(equations: _Equations, mode, y, t, h) -> tuple[list, mp.mpf, list[list]]:
    """Advance by h; return the state, its error, and the guards of the contacts at the nodes of the finest column."""
    n, seen = equations.n, []

    def rate(at, now):
        accelerations, pull, slip, _ = equations.forces(now, at, mode)
        seen.append(_guards(equations, mode, now, at, pull, slip))
        return [*now[n:], *accelerations]

    final, before = midpoint(rate, t, y, h, _COLUMNS)
    guards = [seen[0], *seen[-2 * _COLUMNS : -1]]
    scale = [max(abs(a), abs(b), mp.mpf(1) / 10) for a, b in zip(final, y, strict=True)]
    error = max(abs(a - b) / s for a, b, s in zip(final, before, scale, strict=True))
    _, pull, slip, _ = equations.forces(final, t + h, mode)
    guards.append(_guards(equations, mode, final, t + h, pull, slip))
    return final, error, guards


def _guards(equations: _Equations, mode, y, t, pull, slip) -> list:
    """Return what is positive while the mode is right: the slip in its direction, or the room of the sticking force."""
    return [mode[i] * slip[i] if mode[i] else equations.room(y, t, i, pull[i]) for i in range(equations.n_c)]


def _first_fallen(guards: list[list]) -> int | None:
    """Return the contact whose guard is first negative after the beginning, by more than rounding leaves of zero."""
    for row in guards[1:]:
        if min(row) < -_NOISE * mp.eps:
            return row.index(min(row))
    return None


def _locate(equations: _Equations, mode, y, t, h, guards, which: int) -> tuple[list, mp.mpf]:
    """Return state and time where a guard falls, by the Illinois rule on the length of the step."""
    nodes = len(guards) - 1
    k = next(k for k in range(1, nodes + 1) if guards[k][which] < -_NOISE * mp.eps)

    def value(length) -> tuple[mp.mpf, list]:
        state = _step(equations, mode, y, t, length)[0]
        _, pull, slip, _ = equations.forces(state, t + length, mode)
        return _guards(equations, mode, state, t + length, pull, slip)[which], state

    low, high = h * (k - 1) / nodes, h * k / nodes
    below, state = value(high)
    while below >= 0:  # the nodes inside a step are rough
        high += h / nodes
        below, state = value(high)
    above = value(low)[0] if k > 1 else guards[0][which]
    above = above if above > 0 else -below * mp.eps  # it starts at zero where a slip begins
    for _ in range(_LOCATE):
        length = (low * below - high * above) / (below - above)
        now, state = value(length)
        if abs(now) <= 100 * mp.eps or high - low <= 100 * mp.eps * high:
            break
        if now < 0:
            high, below, above = length, now, above / 2
        else:
            low, above, below = length, now, below / 2
    return state, t + length


def _solve(rows: list[list]) -> list:
    """Eliminate with the largest pivots; the last column is the right-hand side."""
    size = len(rows)
    for k in range(size):
        best = max(range(k, size), key=lambda r: abs(rows[r][k]))
        rows[k], rows[best] = rows[best], rows[k]
        if abs(rows[k][k]) <= 1e6 * mp.eps:
            raise ZeroDivisionError("a pivot vanishes")
        for r in range(k + 1, size):
            factor = rows[r][k] / rows[k][k]
            if factor:
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[k], strict=True)]
    solution: list = [None] * size
    for k in reversed(range(size)):
        solution[k] = (rows[k][-1] - mp.fdot(rows[k][k + 1 : -1], solution[k + 1 :])) / rows[k][k]
    return solution
