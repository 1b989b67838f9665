"""Held variables, which change at sampling instants only, and resets, which change states at known times.

At one instant delayed values act first, then samples are taken, in the order of their dependence, then resets.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.symbols import Key, expression, legible, listed, name_of, nearest, refuse_speed

MOST_LATE = 64  # most samples on their way
MOST_TIMES = 64  # most times of one reset
_MARGIN = 1e-12  # relative difference up to which a delay is a whole number of periods


def _number_or_expression(value: object, what: str, least: float, strict: bool = False) -> sp.Expr:
    """Return a time as an expression; raise if it is a number out of range."""
    found = expression(value, what)
    refuse_speed(found, what)
    if found.is_number and not (found.is_finite and (found > least or (found == least and not strict))):
        raise SceneError(f"{what} is {value}; it must {'exceed' if strict else 'not be below'} {least:g}")
    return found


@dataclass(frozen=True, eq=False)
class Held:
    """A variable that is computed at sampling instants and constant between them.

    Attributes
    ----------
    name : str
        Also of a state of the scene, the value that acts.
    update : Expr
        Of states, time, parameters, sampled inputs and held variables. The symbol of another one without delay that is
        sampled at the same instant is its new value; `previous` is the value computed before.
    every, offset : float or Expr
        Sampling period, > 0, and time of the first sample, >= 0; may be parameters.
    delay : float or Expr
        Time from a sample until its value acts, >= 0. It may be longer than the period if both are numbers;
        a run with parameters that make it longer ends with the status NOT_FINITE.
    initial : float or Expr
        Value before the first one acts, and `previous` at the first sample.
    step : float or Expr, optional
        Of a quantiser: values are rounded to its multiples.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> command = sf.Held("command", update=-3 * x - u, every=0.01, delay=0.002)
    >>> command.symbol, command.previous
    (command, command.previous)
    """

    name: str
    update: sp.Expr
    every: float | sp.Expr
    offset: float | sp.Expr = 0.0
    delay: float | sp.Expr = 0.0
    initial: float | sp.Expr = 0.0
    step: float | sp.Expr | None = None

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError(f"the name of a held variable is {self.name!r}; it must be a string")
        legible(self.name, "a held variable")
        what = f"the update of {self.name!r}"
        update = expression(self.update, what)
        refuse_speed(update, what)
        object.__setattr__(self, "update", update)
        for part, strict in (("every", True), ("offset", False), ("delay", False)):
            time = _number_or_expression(getattr(self, part), f"{part} of {self.name!r}", 0.0, strict)
            object.__setattr__(self, part, time)
        object.__setattr__(self, "initial", expression(self.initial, f"the initial value of {self.name!r}"))
        if self.step is not None:
            step = _number_or_expression(self.step, f"the step of {self.name!r}", 0.0, strict=True)
            object.__setattr__(self, "step", step)
        if self.late > MOST_LATE:
            raise SceneError(f"the delay of {self.name!r} is longer than {MOST_LATE} periods")

    @cached_property
    def symbol(self) -> sp.Symbol:
        """The value that acts."""
        return sp.Symbol(self.name, real=True)

    @cached_property
    def previous(self) -> sp.Symbol:
        """The value computed at the sample before; for updates."""
        return sp.Symbol(f"{self.name}.previous", real=True)

    @property
    def late(self) -> int:
        """Number of values on their way at most; zero without delay, one if period or delay is a parameter."""
        delay = sp.sympify(self.delay)
        if delay.is_zero:
            return 0
        periods = delay / self.every
        return max(1, math.ceil(float(periods) * (1 - _MARGIN))) if periods.is_number else 1

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression, with the symbols of previous values."""
        step = () if self.step is None else (self.step,)
        return (self.update, self.every, self.offset, self.delay, *step)

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """The value that acts, and those on their way."""
        return (self.symbol, *(sp.Symbol(f"{self.name}.queue{k + 1}", real=True) for k in range(self.late)))


@dataclass(frozen=True, eq=False, kw_only=True)
class Reset:
    """A change of states at known times, such as a kick.

    Attributes
    ----------
    set : mapping of state to Expr or sequence of Expr
        The states after it, in those before; with `at` also one for each time.
    at : sequence of float or Expr
        Its times, increasing.
    every, offset : float or Expr
        Instead of `at`, its period and first time.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> u = sp.Symbol("u", real=True)
    >>> kick = sf.Reset(at=[1.0, 2.0], set={u: [u + 0.1, u - 0.3]})
    >>> kick.targets
    ('u',)
    """

    set: Mapping[Key, sp.Expr]
    at: Sequence[float | sp.Expr] = ()
    every: float | sp.Expr | None = None
    offset: float | sp.Expr = 0.0

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        if not isinstance(self.set, Mapping) or not self.set:
            raise SceneError(f"set of a reset is {self.set!r}; give states with their values after it, set={{u: 0}}")
        times = tuple(_number_or_expression(t, "a time of a reset", 0.0) for t in listed(self.at, "at"))
        if bool(times) == (self.every is not None):
            raise SceneError("a reset needs either its times, at=[...], or a period, every=T")
        if len(times) > MOST_TIMES:
            raise SceneError(f"a reset has {len(times)} times; it takes {MOST_TIMES}, and a scene several resets")
        if any((b - a).is_number and b <= a for a, b in itertools.pairwise(times)):
            raise SceneError("the times of a reset must increase")
        object.__setattr__(self, "at", times)
        if self.every is not None:
            object.__setattr__(self, "every", _number_or_expression(self.every, "every of a reset", 0.0, strict=True))
        object.__setattr__(self, "offset", _number_or_expression(self.offset, "offset of a reset", 0.0))
        object.__setattr__(self, "set", {name_of(k): self._after(name_of(k), v) for k, v in self.set.items()})

    def _after(self, name: str, value: object) -> tuple[sp.Expr, ...]:
        """Return the values of a state after the resets, one for all or one for each time."""
        several = isinstance(value, Sequence) and not isinstance(value, str)
        entries: Sequence[object] = value if isinstance(value, Sequence) else [value]
        found = tuple(expression(e, f"{name} after a reset") for e in entries)
        if several and len(found) != len(self.at):
            raise SceneError(f"a reset has {len(self.at)} times and {len(found)} values of {name}; give one for each")
        for e in found:
            refuse_speed(e, f"{name} after a reset")
        return found

    @property
    def targets(self) -> tuple[str, ...]:
        """Names of the states that it changes."""
        return tuple(self.set)

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression."""
        period = () if self.every is None else (self.every,)
        return (*(e for after in self.set.values() for e in after), *self.at, *period, self.offset)


def in_order(held: Sequence[Held]) -> tuple[Held, ...]:
    """Return held variables in the order in which they are computed where they are sampled at one instant.

    Raises
    ------
    SceneError
        If two have one name, or new values depend on each other.
    """
    held = listed(held, "held")
    for h in held:
        if not isinstance(h, Held):
            raise SceneError(f"{h!r} in held is no sf.Held")
    names = [h.name for h in held]
    double = next((n for i, n in enumerate(names) if n in names[:i]), None)
    if double:
        raise SceneError(f"two held variables are called {double!r}; give each its own name")
    known = {h.previous for h in held}
    for h in held:
        unknown = {s for s in h.update.free_symbols if s.name.endswith(".previous")} - known
        if unknown:
            raise SceneError(f"the update of {h.name!r} contains {unknown.pop()}, and held has no such variable")
    left, ready = list(held), []
    while left:
        waits = {h.symbol for h in left if not h.late}
        free = next((h for h in left if not h.update.free_symbols & waits - {h.symbol}), None)
        if free is None:
            loop = ", ".join(h.name for h in left)
            raise SceneError(f"the new values of {loop} depend on each other; use the previous value of one")
        ready.append(free)
        left.remove(free)
    return tuple(ready)


def check_resets(resets: Sequence[Reset], states: set[str]) -> tuple[Reset, ...]:
    """Return resets as a tuple; raise on one that changes no state of the scene."""
    resets = listed(resets, "resets")
    for r in resets:
        if not isinstance(r, Reset):
            raise SceneError(f"{r!r} in resets is no sf.Reset")
        unknown = next((n for n in r.targets if n not in states), None)
        if unknown is not None:
            raise SceneError(f"a reset sets {unknown}, which is no state{nearest(unknown, states)}")
    return resets
