"""Held variables: computed at sampling instants or where an expression crosses zero, constant between them.

At one instant delayed values act first, then values are computed, in the order of their dependence, then states are
reset; see `symfric.model.resets`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.steps import STAIRS, STEPPED, with_steps
from symfric.model.symbols import Key, expression, legible, listed, name_of, refuse_speed, shortened
from symfric.model.tree import parts_of
from symfric.spelling import spelt

MOST_WAITING = 64  # most values on their way
EMPTY = -1.0  # time left of a place for a value on its way that is empty
_PLACES = 4  # such places of a variable that is computed at crossings
_MARGIN = 1e-12  # relative difference up to which a delay is a whole number of periods


def time_of(value: object, what: str, least: float, strict: bool = False) -> sp.Expr:
    """Return a time as an expression; raise if it is a number out of range."""
    time = expression(value, what)
    refuse_speed(time, what)
    if time.is_number and not (time.is_finite and (time > least or (not strict and float(time) == least))):
        raise SceneError(f"{what} is {value}; it must {'exceed' if strict else 'not be below'} {least:g}")
    return time


def crossing_of(value: object, what: str) -> sp.Expr:
    """Return an expression whose zeros are events; raise if it is a number."""
    crossing = with_steps(expression(value, what), what)
    refuse_speed(crossing, what)
    jump = next((e for e in parts_of(crossing, *STEPPED, *STAIRS)), None)
    if jump is not None:
        raise SceneError(f"{what} contains {jump}, which jumps; give the expression whose zeros are meant")
    if crossing.is_number:
        raise SceneError(f"{what} is {value}, which crosses zero never; give an expression of states and time")
    return crossing


def at_side(e: sp.Expr, crossing: sp.Expr, side: sp.Expr) -> sp.Expr:
    """Return an expression at a zero of `crossing`, with the signs of its multiples as they are just after.

    Parameters
    ----------
    e, crossing : Expr
    side : Expr
        Of which `crossing` has the sign just after: a symbol, or -1 or 1.

    Examples
    --------
    >>> import sympy as sp
    >>> x, s = sp.symbols("x s", real=True)
    >>> at_side(3 * sp.sign(2 * x), x, s)
    3*Piecewise((-1, s < 0), (1, s > 0), (0, True))
    >>> at_side(sp.Heaviside(x - 1), x, s) == sp.Piecewise((0, x - 1 < 0), (1, True))
    True
    """
    e = e.replace(sp.sign, lambda a: sp.Piecewise((-1, a < 0), (1, a > 0), (0, True)))
    e = e.replace(lambda f: isinstance(f, sp.Heaviside), lambda f: sp.Piecewise((0, f.args[0] < 0), (1, True)))
    rule = {}
    for relation in e.atoms(sp.core.relational.Relational):
        factor = sp.cancel((relation.lhs - relation.rhs) / crossing)
        if factor.is_number and factor != 0:
            rule[relation] = relation.func(sp.sign(factor) * side, 0)
    return e.xreplace(rule) if rule else e


@spelt
@dataclass(frozen=True, eq=False)
class Held:
    """A variable that is computed at sampling instants, or at the zeros of an expression, and constant between them.

    Attributes
    ----------
    name : str
        Also of a state of the scene, the value that acts.
    update : Expr
        Of states, time, parameters, sampled inputs and held variables. The symbol of another one without delay that is
        computed at the same instant is its new value; `previous` is the value computed before. It may jump (``floor``,
        ``Mod``, ``sign``, a ``Piecewise``); a step in time at the instant, to rounding, has been. Where `when` crosses
        zero, ``sympy.sign`` of it, or a condition on it, is that just after.
    every, offset : float or Expr
        Sampling period, > 0, and time of the first sample, >= 0; may be parameters.
    delay : float or Expr
        Time from the computation until the value acts, >= 0; may be a parameter, and exceed the period.
    initial : float or Expr
        Value before the first one acts, and `previous` at the first computation.
    step : float or Expr, optional
        Of a quantiser: values are rounded to its multiples.
    when : Expr, optional
        Instead of `every`: a continuous expression of states, held variables and time; the value is computed where it
        crosses zero in either direction, also by a jump.
    waiting : int, optional
        Most values on their way to act. Unless given, 4 with `when`, otherwise as many as period and delay need with
        the first values of the scene. A run in which there are more ends with the status QUEUE_FULL.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> command = sf.Held("command", update=-3 * x - u, every=0.01, delay=0.002)
    >>> command.symbol, command.previous
    (command, command.previous)
    >>> relay = sf.Held("relay", update=-sp.sign(x), when=x, delay=0.3, waiting=1)
    >>> relay.states
    (relay, relay.queue1, relay.left1)
    >>> relay.where({x: x - 1}).when
    x - 1
    >>> T = sp.Symbol("T", positive=True)
    >>> sf.Held("late", update=x, every=T, delay=0.5).with_places({T: 0.2}).waiting
    3
    """

    name: str
    update: sp.Expr
    every: float | sp.Expr | None = None
    offset: float | sp.Expr = 0.0
    delay: float | sp.Expr = 0.0
    initial: float | sp.Expr = 0.0
    step: float | sp.Expr | None = None
    when: sp.Expr | None = None
    waiting: int | None = None

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError(f"the name of a held variable is {shortened(self.name)}; it must be a string")
        legible(self.name, "a held variable")
        if (self.every is None) == (self.when is None):
            raise SceneError(f"{self.name!r} needs either a sampling period, every=T, or an expression, when=x - 1")
        what = f"the update of {self.name!r}"
        update = expression(self.update, what)
        refuse_speed(update, what)
        self._set("update", update)
        if self.when is not None:
            self._set("when", crossing_of(self.when, f"when of {self.name!r}"))
        for part, strict in (("every", True), ("offset", False), ("delay", False)):
            if part != "every" or self.every is not None:
                self._set(part, time_of(getattr(self, part), f"{part} of {self.name!r}", 0.0, strict))
        if self.when is not None and not sp.sympify(self.offset).is_zero:
            raise SceneError(f"{self.name!r} has an offset, which belongs to every; remove it")
        self._set("initial", expression(self.initial, f"the initial value of {self.name!r}"))
        if self.step is not None:
            self._set("step", time_of(self.step, f"the step of {self.name!r}", 0.0, strict=True))
        self._check_places()

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)  # assignment in a frozen class

    def _check_places(self) -> None:
        given = self.waiting
        if given is not None and (isinstance(given, bool) or not isinstance(given, int) or given < 1):
            raise SceneError(f"waiting of {self.name!r} is {given!r}; it must be a whole number from 1 on")
        needed = self._needed({})
        if max(given or 0, needed or 0) > MOST_WAITING:
            raise SceneError(f"{self.name!r} has more than {MOST_WAITING} values on their way; shorten the delay")
        if given is not None and needed is not None and given < needed:
            raise SceneError(f"{self.name!r} has {needed} values on their way; waiting={given} is too few")

    def _needed(self, values: Mapping[sp.Symbol, float]) -> int | None:
        """Return how many values are on their way with some values of parameters; None if that is not determined."""
        if self.every is None:
            return None
        periods = sp.sympify(self.delay / self.every).subs(values)
        if not (periods.is_number and periods.is_finite):
            return None
        return max(1, math.ceil(float(periods) * (1 - _MARGIN))) if periods > 0 else 0

    def with_places(self, values: Mapping[Key, float | None]) -> "Held":
        """Return the variable with as many places for values on their way as it needs with values of parameters.

        Parameters
        ----------
        values : mapping of symbol or name to float
            Those that are None are not given yet.

        Returns
        -------
        Held
            Itself if that was determined before.
        """
        given = {name_of(k): v for k, v in values.items() if isinstance(v, int | float)}
        symbols = set().union(*(e.free_symbols for e in self.times))
        needed = self._needed({s: given[s.name] for s in symbols if s.name in given})
        if self.waiting is not None or needed is None or needed == self.late:
            return self
        return replace(self, waiting=max(1, needed))

    def where(self, changes: Mapping[sp.Symbol, sp.Expr]) -> "Held":
        """Return the variable with other expressions in place of symbols, in what it computes and when.

        Parameters
        ----------
        changes : mapping of Symbol to Expr

        Returns
        -------
        Held
        """
        when = None if self.when is None else self.when.xreplace(changes)
        return replace(self, update=self.update.xreplace(changes), when=when)

    @cached_property
    def symbol(self) -> sp.Symbol:
        """The value that acts."""
        return sp.Symbol(self.name, real=True)

    @cached_property
    def previous(self) -> sp.Symbol:
        """The value computed before; for updates."""
        return sp.Symbol(f"{self.name}.previous", real=True)

    @property
    def late(self) -> int:
        """Number of places for values on their way; zero without delay."""
        if sp.sympify(self.delay).is_zero:
            return 0
        return self.waiting or (_PLACES if self.when is not None else self._needed({}) or 1)

    @property
    def crossing(self) -> sp.Expr | None:
        """The expression at whose zeros it is computed."""
        return self.when

    @property
    def times(self) -> tuple[sp.Expr, ...]:
        """Period, offset and delay, which may depend on parameters alone."""
        return tuple(sp.sympify(e) for e in (self.every, self.offset, self.delay) if e is not None)

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression, with the symbols of previous values."""
        return (self.update, *self.times, *(e for e in (self.step, self.when) if e is not None))

    @cached_property
    def queue(self) -> tuple[sp.Symbol, ...]:
        """The values on their way: sampled ones from the newest on, others from the first that acts on."""
        return tuple(sp.Symbol(f"{self.name}.queue{k + 1}", real=True) for k in range(self.late))

    @cached_property
    def left(self) -> tuple[sp.Symbol, ...]:
        """The times until values computed at crossings act, `EMPTY` where there is none."""
        return tuple(sp.Symbol(f"{self.name}.left{k + 1}", real=True) for k in range(self.late if self.when else 0))

    @property
    def states(self) -> tuple[sp.Symbol, ...]:
        """The value that acts, and those on their way."""
        return (self.symbol, *self.queue, *self.left)

    @property
    def starts(self) -> dict[str, float | sp.Expr]:
        """Initial values of the states by name."""
        waiting = 0.0 if self.when is not None else self.initial
        return {
            self.name: self.initial,
            **{s.name: waiting for s in self.queue},
            **{s.name: EMPTY for s in self.left},
        }


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
            raise SceneError(f"{shortened(h)} in held is no sf.Held")
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
