"""A scene's equations as an engineer would write them for another solver: one list of rates, a sign for each contact.

Nothing of this package's own lowering is used, so that what the peers compute is independent of it.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from symfric.bench.result import Answer
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME


@dataclass(frozen=True)
class Form:
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
        The input is ``line[0] + line[1] t`` on each segment.
    segments : tuple of (float, float, float)
        End of each segment and its line.
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
    line: tuple[sp.Symbol, sp.Symbol]
    segments: tuple[tuple[float, float, float], ...]

    @property
    def arguments(self) -> tuple[sp.Symbol, ...]:
        """What every expression may contain, in the order of the compiled functions."""
        return (TIME, *self.states, *self.signs, *self.moving, *self.line)

    @property
    def guards(self) -> tuple[sp.Expr, ...]:
        """Per contact and absolute value: positive while its sign, or its sticking, lasts."""
        contacts = zip(self.signs, self.moving, self.slips, self.limits, self.holds, strict=False)
        found = [m * s * w + (1 - m) * (limit**2 - hold**2) for s, m, w, limit, hold in contacts]
        return (*found, *(s * e for s, e in zip(self.signs[len(self.moving) :], self.kinks, strict=True)))


def form_of(scene: Scene) -> Form:
    """Write a scene out.

    Raises
    ------
    NotImplementedError
        If two contacts work on one body, a law is smooth or has branches, or the scene has several inputs.
    """
    system, numbers = scene.system, scene.numbers()
    known = {s: v for s, v in numbers.items() if s in scene.values}
    line = sp.symbols("line0 line1", real=True)
    if len(scene.inputs) > 1:
        raise NotImplementedError("several inputs")
    if any(c.law.smooth or c.law.breaks for c in scene.contacts):
        raise NotImplementedError("a smooth friction law, or one with branches")
    known |= dict.fromkeys(scene.inputs, line[0] + line[1] * TIME)
    read = lambda e: sp.sympify(e).subs(known)  # noqa: E731
    states, mass = system.states, sp.Matrix(system.mass).subs(known)
    slips = [read(c.slip) for c in scene.contacts]
    jacobian = sp.Matrix([[w.diff(v) for v in system.u] for w in slips]).reshape(len(slips), len(system.u))
    inverse = mass.inv()
    coupling = jacobian * inverse * jacobian.T
    if not coupling.is_diagonal():
        raise NotImplementedError("two contacts work on one body")
    force = sp.Matrix([read(e) for e in system.force])
    free = inverse * force
    signs = sp.symbols(f"sign0:{len(slips)}", real=True)
    moving = sp.symbols(f"moving0:{len(slips)}", real=True)
    holds = [(jacobian.row(j) * free)[0] / coupling[j, j] for j in range(len(slips))]
    limits, pulls = [], []
    for j, contact in enumerate(scene.contacts):
        load, law = read(contact.normal * contact.profile), contact.law
        limits.append(load * read(law.stick))
        sliding = signs[j] * load * read(law.kinetic).subs(SPEED, signs[j] * slips[j])
        pulls.append(moving[j] * sliding + (1 - moving[j]) * holds[j])
    rates = list(free - inverse * jacobian.T * sp.Matrix(pulls)) if pulls else list(free)
    rates = [*system.u, *rates, *(read(e) for e in system.z_rate)]
    kinks = sorted({a.args[0] for e in rates for a in e.atoms(sp.Abs)}, key=str)
    kink_signs = sp.symbols(f"sign{len(slips)}:{len(slips) + len(kinks)}", real=True)
    plain = {sp.Abs(e): s * e for e, s in zip(kinks, kink_signs, strict=True)}
    shares = np.zeros((len(slips), len(states)))
    unit = inverse * jacobian.T
    for j, i in itertools.product(range(len(slips)), range(len(system.u))):
        shares[j, len(system.q) + i] = float(unit[i, j] / coupling[j, j])
    return Form(
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
    )


def _segments(scene: Scene) -> tuple[tuple[float, float, float], ...]:
    if not scene.inputs:
        return ((scene.horizon, 0.0, 0.0),)
    (signal,) = scene.inputs.values()
    found, times = [], signal.t0 + signal.dt * np.arange(signal.samples.size)
    for t, end, left, right in zip(times, times[1:], signal.samples, signal.samples[1:], strict=False):
        slope = (right - left) / signal.dt
        found.append((float(min(end, scene.horizon)), float(left - slope * t), float(slope)))
    return (*(s for s in found if s[0] <= scene.horizon), (scene.horizon, 0.0, 0.0))


def _no_solver(t, y, mode, line, end):
    raise NotImplementedError("this loop finds modes only; give it a solver to run")


class Loop:
    """The stick-slip logic around a solver that goes from event to event.

    Parameters
    ----------
    form : Form
    advance : callable
        ``advance(t, y, mode, line, end) -> (t, y, k)``, with k the number of the guard that fell, None at the end; y a
        list, mode the signs and then `moving`.
    modules : str
        Whose functions the expressions are evaluated with.
    number : callable
        Type of the numbers.
    """

    def __init__(
        self, form: Form, advance: Callable = _no_solver, modules: str = "math", number: Callable[[float], Any] = float
    ):
        self._form, self._advance, self._number = form, advance, number
        compiled = lambda e: sp.lambdify(form.arguments, e, modules, cse=True)  # noqa: E731
        self._slips, self._holds = compiled(list(form.slips)), compiled(list(form.holds))
        self._limits, self._kinks = compiled(list(form.limits)), compiled(list(form.kinks))

    def __call__(self) -> Answer:
        """Run once."""
        t, y, events = self._number(0), [self._number(v) for v in self._form.start], 0
        mode = self.first(y)
        for segment in self._form.segments:
            end, *line = map(self._number, segment)
            while t < end:
                t, y, k = self._advance(t, y, mode, line, end)
                if k is not None:
                    y, mode, changed = self.after(t, y, mode, line, k)
                    events += changed
        return Answer(tuple(y), events)

    def first(self, y: list[float]) -> list[float]:
        """Return the mode of the start."""
        form = self._form
        mode = [1.0] * (len(form.signs) + len(form.moving))
        arguments = (0.0, *y, *mode, *form.segments[0][1:])
        for j, w in enumerate(self._slips(*arguments)):
            mode = self._decided(0.0, y, mode, form.segments[0][1:], j) if w == 0 else _signed(mode, j, w)
        for k, e in enumerate(self._kinks(*arguments), len(form.moving)):
            mode = _signed(mode, k, e)
        return mode

    def after(self, t, y, mode, line, k):
        """Return state and mode after guard k has fallen, and whether the contact turned, stuck or was released."""
        contacts = len(self._form.moving)
        if k >= contacts:
            return y, _signed(mode, k, -mode[k]), False
        place = len(self._form.signs) + k
        if mode[place] == 0.0:
            hold = self._holds(t, *y, *mode, *line)[k]
            released = _signed(mode, k, hold)
            released[place] = 1.0
            return y, released, True
        w = self._slips(t, *y, *mode, *line)[k]
        y = [value - w * share for value, share in zip(y, self._form.shares[k], strict=True)]
        after = self._decided(t, y, mode, line, k)
        return y, after, after[k] != mode[k] or after[place] == 0.0

    def _decided(self, t, y, mode, line, k) -> list[float]:
        """Return the mode of a contact that comes to rest: it sticks, or slips the way it is pulled."""
        hold = self._holds(t, *y, *mode, *line)[k]
        after = _signed(mode, k, hold)
        after[len(self._form.signs) + k] = float(abs(hold) > self._limits(t, *y, *mode, *line)[k])
        return after


def _signed(mode: list[float], k: int, value: float) -> list[float]:
    result = list(mode)
    result[k] = 1.0 if value > 0 else -1.0
    return result
