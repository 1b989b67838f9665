"""Resets, which change states at known times or where an expression falls through zero."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.held import Held, crossing_of, time_of
from symfric.model.symbols import Key, expression, listed, name_of, nearest, refuse_speed, shortened
from symfric.spelling import spelt

MOST_TIMES = 64  # most times of one reset


@spelt
@dataclass(frozen=True, eq=False, kw_only=True)
class Reset:
    """A change of states: at known times, such as a kick, or where an expression falls through zero.

    Attributes
    ----------
    set : mapping of state to Expr or sequence of Expr
        The states after it, in those before; with `at` also one for each time. With `guard`, ``sympy.sign`` of it is
        that just after, -1.
    at : sequence of float or Expr
        Its times, increasing.
    every, offset : float or Expr
        Instead of `at`, its period and first time.
    guard : Expr
        Instead of `at`, a continuous expression of states, held variables and time: the states are set where it falls
        through zero, also by a jump. It has to be positive again before the next time. For one that rises give -guard.

    Notes
    -----
    A guard that the reset leaves at zero decides by its rate: if it falls on, it has crossed (the kick of a clock's
    escapement); if it rises, it is positive (a ball that bounces). A reset that leaves its guard at zero without a
    rate, and falling by its next derivative, ends the run with the status CHATTER: impacts that pile up are contacts.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> u = sp.Symbol("u", real=True)
    >>> kick = sf.Reset(at=[1.0, 2.0], set={u: [u + 0.1, u - 0.3]})
    >>> kick.targets
    ('u',)
    >>> x = sp.Symbol("x", real=True)
    >>> bounce = sf.Reset(guard=x, set={u: -0.8 * u})
    >>> bounce.guard
    x
    >>> bounce.where({x: x - 1}).guard
    x - 1
    """

    set: Mapping[Key, sp.Expr]
    at: Sequence[float | sp.Expr] = ()
    every: float | sp.Expr | None = None
    offset: float | sp.Expr = 0.0
    guard: sp.Expr | None = None

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        if not isinstance(self.set, Mapping) or not self.set:
            raise SceneError(
                f"set of a reset is {shortened(self.set)}; give states with their values after it, set={{u: 0}}"
            )
        times = tuple(time_of(t, "a time of a reset", 0.0) for t in listed(self.at, "at"))
        if bool(times) + (self.every is not None) + (self.guard is not None) != 1:
            raise SceneError("a reset needs either its times, at=[...], a period, every=T, or an expression, guard=x")
        if len(times) > MOST_TIMES:
            raise SceneError(f"a reset has {len(times)} times; it takes {MOST_TIMES}, and a scene several resets")
        if any((b - a).is_number and b <= a for a, b in itertools.pairwise(times)):
            raise SceneError("the times of a reset must increase")
        self._put("at", times)
        if self.every is not None:
            self._put("every", time_of(self.every, "every of a reset", 0.0, strict=True))
        self._put("offset", time_of(self.offset, "offset of a reset", 0.0))
        if self.every is None and not sp.sympify(self.offset).is_zero:
            raise SceneError("a reset has an offset, which belongs to every; remove it")
        if self.guard is not None:
            self._put("guard", crossing_of(self.guard, "the guard of a reset"))
        self._put("set", {name_of(k): self._after(name_of(k), v) for k, v in self.set.items()})

    def _put(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)  # assignment in a frozen class

    def _after(self, name: str, value: object) -> tuple[sp.Expr, ...]:
        """Return the values of a state after the resets, one for all or one for each time."""
        several = isinstance(value, Sequence) and not isinstance(value, str)
        entries: Sequence[object] = value if isinstance(value, Sequence) else [value]
        values = tuple(expression(e, f"{name} after a reset") for e in entries)
        if several and len(values) != len(self.at):
            raise SceneError(f"a reset has {len(self.at)} times and {len(values)} values of {name}; give one for each")
        for e in values:
            refuse_speed(e, f"{name} after a reset")
        return values

    def where(self, changes: Mapping[sp.Symbol, sp.Expr]) -> "Reset":
        """Return the reset with other expressions in place of symbols, in what it sets and its guard.

        Parameters
        ----------
        changes : mapping of Symbol to Expr

        Returns
        -------
        Reset
        """
        several = len(self.at) > 1
        after = {n: tuple(e.xreplace(changes) for e in es) for n, es in self.set.items()}
        guard = None if self.guard is None else self.guard.xreplace(changes)
        return replace(self, set={n: es if several and len(es) > 1 else es[0] for n, es in after.items()}, guard=guard)

    @property
    def targets(self) -> tuple[str, ...]:
        """Names of the states that it changes."""
        return tuple(self.set)

    @property
    def crossing(self) -> sp.Expr | None:
        """The expression at whose zeros it acts."""
        return self.guard

    @property
    def times(self) -> tuple[sp.Expr, ...]:
        """Its times, or period and offset, which may depend on parameters alone."""
        return tuple(sp.sympify(e) for e in (*self.at, self.every, self.offset) if e is not None)

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression."""
        guard = () if self.guard is None else (self.guard,)
        return (*(e for after in self.set.values() for e in after), *self.times, *guard)


def crossings_of(parts: Sequence[Held | Reset]) -> Iterator[tuple[str, sp.Expr]]:
    """Yield the expressions at whose zeros some of them act, with what they are."""
    for part in parts:
        if part.crossing is not None:
            yield "guard of a reset" if isinstance(part, Reset) else f"when of {part.name!r}", part.crossing


def check_order(parts: Sequence[Held | Reset], numbers: Mapping[sp.Symbol, float]) -> None:
    """Raise if values of parameters make a period, a delay or the order of times impossible."""
    for part in parts:
        for name, least in (("every", "exceed 0"), ("offset", "not be below 0"), ("delay", "not be below 0")):
            given = getattr(part, name, None)
            value = None if given is None else sp.sympify(given).subs(numbers)
            if value is not None and value.is_number and (value <= 0 if name == "every" else value < 0):
                of = f"{part.name!r}" if isinstance(part, Held) else "a reset"
                raise SceneError(f"{name} of {of} is {given} = {float(value):g}; it must {least}")
        times = [sp.sympify(t).subs(numbers) for t in (part.at if isinstance(part, Reset) else ())]
        known = [float(t) for t in times if t.is_number]
        if any(after < before for before, after in itertools.pairwise([0.0, *known])):
            raise SceneError(
                f"the times of a reset are {', '.join(f'{t:g}' for t in known)}; they must increase from 0 on, and a "
                "scene takes several resets"
            )


def check_resets(resets: Sequence[Reset], states: set[str]) -> tuple[Reset, ...]:
    """Return resets as a tuple; raise on one that changes no state of the scene."""
    resets = listed(resets, "resets")
    for r in resets:
        if not isinstance(r, Reset):
            raise SceneError(f"{shortened(r)} in resets is no sf.Reset")
        unknown = next((n for n in r.targets if n not in states), None)
        if unknown is not None:
            raise SceneError(f"a reset sets {unknown}, which is no state{nearest(unknown, states)}")
    return resets
