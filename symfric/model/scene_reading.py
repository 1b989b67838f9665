"""Read the arguments of a scene: keys become symbols of its expressions, numbers floats; wrong input raises."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import sympy as sp

from symfric.errors import SceneError
from symfric.model.contact_observables import observables_of, vector_words
from symfric.model.held import Held
from symfric.model.outputs import OF_CONTACTS, Output, OutputOfExpression
from symfric.model.resets import Reset, crossings_of
from symfric.model.symbols import (
    SPEED,
    TIME,
    Key,
    expression,
    finite,
    legible,
    mapped,
    name_of,
    nearest,
    refuse_speed,
)
from symfric.model.system import Contact, Signal, System
from symfric.model.validation import check_instants, check_symbols, refuse_observables

_Value = TypeVar("_Value")
_OBSERVED = tuple(f"{kind}(" for kind in OF_CONTACTS)  # how the names of their symbols begin


@dataclass(frozen=True)
class Parts:
    """The parts of a scene that hold expressions, before values are given to their symbols."""

    system: System
    contacts: tuple[Contact, ...]
    held: tuple[Held, ...]
    resets: tuple[Reset, ...]
    outputs: Mapping[str, Output]

    @property
    def clocks(self) -> tuple[Held | Reset, ...]:
        """Held variables and resets."""
        return (*self.held, *self.resets)

    @property
    def clocked(self) -> tuple[sp.Expr, ...]:
        """Every expression of held variables and resets, without previous values."""
        expressions = (e for part in self.clocks for e in part.expressions)
        return tuple(e.xreplace({h.previous: h.symbol for h in self.held}) for e in expressions)

    def symbols(self, initial: Mapping[Any, Any]) -> set[sp.Symbol]:
        """Return every symbol that some expression uses, the speed inside laws and previous values apart."""
        observed = [o.expr for o in self.outputs.values() if isinstance(o, OutputOfExpression)]
        starts = [e for e in (*initial.values(), *(h.initial for h in self.held)) if isinstance(e, sp.Expr)]
        parts = [e.free_symbols for e in (*self.system.expressions, *self.clocked, *observed, *starts)]
        return set().union(*parts, *(c.free_symbols for c in self.contacts)) - {h.previous for h in self.held}

    @property
    def states(self) -> dict[str, sp.Symbol]:
        """States by their names."""
        return {s.name: s for s in self.system.states}

    @property
    def contact_symbols(self) -> dict[str, sp.Symbol]:
        """Symbols of the forces, slips and powers of the contacts, by their names."""
        return {s.name: s for c in self.contacts for s in observables_of(c.name, c.in_plane)}

    def named_expressions(self) -> Iterator[tuple[str, sp.Expr]]:
        """Yield the right-hand sides and guards, which must be continuous, with their names in messages."""
        for i, e in enumerate(self.system.force):
            yield f"force[{i}]", e
        for i, e in enumerate(self.system.z_rate[: len(self.system.z) - self.system.made]):
            yield f"z_rate[{i}]", e
        for i, e in enumerate(self.system.linear.expressions if self.system.linear else ()):
            yield f"load[{i}]", e
        yield from crossings_of(self.clocks)


def by_name(entries: Mapping[Key, _Value], what: str) -> dict[str, _Value]:
    """Return a mapping with names as keys; raise if it is none."""
    return {name_of(k): v for k, v in mapped(entries, what, f"{what}={{...}}").items()}


def read_values(
    parts: Parts, values: Mapping[Key, float | None], initial: Mapping[Any, Any], inputs: Mapping[Key, Signal]
) -> tuple[dict[sp.Symbol, float | None], dict[sp.Symbol, Signal]]:
    """Return values and inputs by the symbols of the expressions; every parameter has one, and nothing else does."""
    given = by_name(values, "values")
    if len(given) < len(values):
        raise SceneError("a parameter is given twice in Scene.values, as a symbol and by name")
    signals = by_name(inputs, "inputs")
    for name, signal in signals.items():
        if not isinstance(signal, Signal):
            raise SceneError(f"input {name} is {signal!r}; give a sf.Signal")
    system, states = parts.system, parts.states
    symbols = parts.symbols(initial)
    if any(s.name.startswith(_OBSERVED) for s in symbols):
        refuse_observables(system, parts.contacts, by_name(initial, "initial"), parts.clocked)
    check_instants(parts.clocks, set(system.states) | set(system.rows))
    used: dict[str, sp.Symbol] = {}
    for symbol in sorted(symbols, key=str):
        used.setdefault(symbol.name, symbol)
    rows = {s.name: s for s in system.rows}
    allowed = states | rows | {name: used.get(name, sp.Symbol(name)) for name in signals}
    if clash := next((name for name in (*given, *signals) if name in states), None):
        cure = "its start belongs in Scene.initial, not in Scene.values" if clash in given else "rename the input"
        raise SceneError(f"{clash} is a state; {cure}")
    reserved = parts.contact_symbols | {TIME.name: TIME}
    check_symbols(symbols, allowed | reserved, set(given))
    parameters = set(used) - set(allowed) - set(reserved)
    _check_reserved(parts.contacts, [*given, *signals], used)
    for name in [*given, *signals]:
        where = "input" if name in signals else "value"
        legible(name, f"an {where}" if name in signals else f"a {where}")
        if name not in used:
            raise SceneError(f"{where} {name} is used by no expression{nearest(name, parameters)}")
    numbers = {used[n]: None if v is None else finite(v, f"the value of {n}") for n, v in given.items()}
    return numbers, {used[n]: s for n, s in signals.items()}


def _check_reserved(contacts: Sequence[Contact], names: Sequence[str], used: Mapping[str, sp.Symbol]) -> None:
    """Raise if time or the sliding speed is given a value."""
    in_laws = any(SPEED in e.free_symbols for c in contacts for e in c.law.expressions)
    for name in names:
        if name == TIME.name:
            raise SceneError("t is given a value, and is sf.TIME, which runs from 0; rename your symbol t")
        if name == SPEED.name and name not in used and in_laws:
            raise SceneError("v is given a value, and in a law is sf.SPEED, the sliding speed; rename your symbol v")


def read_initial(
    parts: Parts, initial: Mapping[Key, float | sp.Expr], parameters: Mapping[sp.Symbol, Any]
) -> dict[sp.Symbol, float | sp.Expr]:
    """Return the start of every state: those of contacts with memory zero, of held variables theirs, unless given."""
    states = parts.states
    given = {s.name: 0.0 for c in parts.contacts for s in c.states}
    for h in parts.held:
        given |= h.starts
    given |= by_name(initial, "initial")
    for name, value in given.items():
        if name not in states:
            raise SceneError(f"{name} in Scene.initial is no state{nearest(name, states)}")
        if isinstance(value, sp.Expr) and value.free_symbols:
            value = expression(value, f"the initial value of {name}")
            refuse_speed(value, f"the initial value of {name}")
            if value.free_symbols - set(parameters):
                raise SceneError(f"the initial value of {name} is {value}; it may depend on parameters only")
            given[name] = value
        else:
            given[name] = finite(value, f"the initial value of {name}")
    if missing := next((name for name in states if name not in given), None):
        raise SceneError(f"no initial value for {missing}; add it to Scene.initial")
    return {s: given[s.name] for s in parts.system.states}


def check_output_symbols(parts: Parts) -> None:
    """Raise if an output uses a force, slip or power of a contact that the scene does not have."""
    known = parts.contact_symbols
    for name, output in parts.outputs.items():
        if isinstance(output, OutputOfExpression):
            for s in output.expr.free_symbols:
                if s.name.startswith(_OBSERVED) and s.name not in known:
                    contacts, bare = [c.name for c in parts.contacts], s.name.split("(", 1)[1][:-1]
                    if bare.removesuffix(", 0").removesuffix(", 1") in contacts:
                        raise SceneError(vector_words(name, bare))
                    raise SceneError(f"output {name!r} uses contact {bare!r}{nearest(bare, contacts)}")
