"""Held variables and resets of a scene file: the tables ``[held.NAME]`` and ``[[reset]]``."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import sympy as sp
from pydantic import BeforeValidator, Field

from symfric.fields import MAX_TABLES, Section, Term, Terms
from symfric.model.held import MOST_WAITING, Held
from symfric.model.resets import MOST_TIMES, Reset
from symfric.model.symbols import shorten
from symfric.scenefile.arguments import as_expr, call_at


class HeldTable(Section):
    """The section ``[held.NAME]``: a variable that is computed at instants and constant between them.

    Attributes
    ----------
    update
        What is computed; NAME.previous is the value computed before.
    every
        Sampling period.
    offset
        Time of the first sample.
    when
        Instead of ``every``: it is computed where this expression crosses zero; ``sign`` of it in the update is that
        just after.
    delay
        Time until a value acts.
    initial
        Value before the first one acts.
    step
        Values are rounded to multiples of it.
    waiting
        Most values on their way, if delay or period are names, or with ``when``.
    """

    update: Term
    every: Term | None = None
    offset: Term = 0.0
    when: Term | None = None
    delay: Term = 0.0
    initial: Term = 0.0
    step: Term | None = None
    waiting: Annotated[int, Field(ge=1, le=MOST_WAITING, strict=True)] | None = None


class ResetTable(Section):
    """One table ``[[reset]]``: a change of states at known times, or where an expression falls through zero.

    Attributes
    ----------
    set
        The states after it, in those before; with several times a list has one for each.
    at
        Its times.
    every
        Instead of ``at``, its period.
    offset
        Time of the first one with ``every``.
    guard
        Instead of ``at``, an expression that falls through zero then.
    """

    set: Annotated[dict[str, Terms], Field(min_length=1, max_length=MAX_TABLES)]
    at: Annotated[Terms, Field(max_length=MOST_TIMES)] = Field(default_factory=list)
    every: Term | None = None
    offset: Term = 0.0
    guard: Term | None = None


def as_tables(value: object) -> list[Any]:
    """Return one table or several as a list."""
    return value if isinstance(value, list) else [value]


HeldTables = Annotated[dict[str, HeldTable], Field(max_length=MAX_TABLES)]
ResetTables = Annotated[list[ResetTable], BeforeValidator(as_tables), Field(max_length=MAX_TABLES)]


def held_symbols(tables: Mapping[str, HeldTable]) -> dict[str, sp.Symbol]:
    """Return the symbols of held variables by name."""
    return {name: sp.Symbol(name, real=True) for name in tables}


def held_variables(tables: Mapping[str, HeldTable], names: Mapping[str, sp.Expr]) -> list[Held]:
    """Return the held variables of a file; `names` gives the meaning of those in expressions."""
    before = {f"{name}.previous": sp.Symbol(f"{name}.previous", real=True) for name in tables}
    made = []
    for name, table in tables.items():
        place = f"held.{shorten(name, 40)}"
        given = {}
        for key in HeldTable.model_fields:
            text = getattr(table, key)
            if key != "waiting" and text is not None:
                given[key] = as_expr(text, f"{place}.{key}", {**names, **before} if key == "update" else names)
        made.append(call_at(place, Held, {"name": name, **given, "waiting": table.waiting}))
    return made


def resets(tables: Sequence[ResetTable], names: Mapping[str, sp.Expr]) -> list[Reset]:
    """Return the resets of a file."""
    made = []
    for k, table in enumerate(tables):
        place = f"reset[{k}]"
        given: dict[str, Any] = {
            key: as_expr(text, f"{place}.{key}", names)
            for key in ("every", "offset", "guard")
            if (text := getattr(table, key)) is not None
        }
        given["at"] = [as_expr(e, f"{place}.at[{i}]", names) for i, e in enumerate(table.at)]
        after = {n: [as_expr(e, f"{place}.set.{shorten(n, 40)}", names) for e in es] for n, es in table.set.items()}
        given["set"] = {n: es if len(es) > 1 else es[0] for n, es in after.items()}
        made.append(call_at(place, Reset, given))
    return made
