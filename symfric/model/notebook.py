"""Tables of results for notebooks, made from `to_dict`."""

import html
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import sympy as sp
from sympy.printing.mathml import mathml

MOST = 12  # longest list whose entries are shown; of longer ones the number and the ends of the range
_ACROSS = 6  # most columns of a table with a single row; with more it stands upright
MODES = {-1: "slips backward", 0: "sticks", 1: "slips forward", 2: "open"}


def html_table(name: str, values: Mapping[str, object]) -> str:
    """Return an HTML table of a result's values; nested values carry the names of their parents.

    Matrices and lists of mappings become tables of their own, SymPy expressions MathML, which browsers typeset.

    Parameters
    ----------
    name : str
        Of the result's class.
    values : mapping
        Plain data, as `to_dict` returns it; complex numbers, expressions and `columns` besides.
    """
    from symfric.templates import render  # slow to import, and only notebooks need it

    return render("result.html", name=name, rows=list(_rows(values)))


def columns(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> list[dict[str, object]]:
    """Return rows as mappings from their heads, which `html_table` shows as a table of its own."""
    return [dict(zip(heads, row, strict=True)) for row in rows]


def changes_of_mode(events: Iterable[Any]) -> list[dict[str, object]]:
    """Return the events of a run for `html_table`, modes in words."""
    heads = ("t", "contact", "before", "after")
    return columns(heads, ((e.t, e.contact, MODES[e.before], MODES[e.after]) for e in events))


def _rows(values: Mapping[str, object], above: str = "") -> Iterator[tuple[str, object]]:
    """Yield the name and the text, or the table, of each value."""
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            yield from _rows(value, f"{above}{name}: ")
        else:
            yield f"{above}{name}", _table(value) or _shown(value)


def _table(value: Any) -> dict[str, list[Any]] | None:
    """Return the heads and the rows of a matrix or of a list of mappings; None for anything else."""
    if not isinstance(value, list | tuple) or not value or len(value) > MOST:
        return None
    if all(isinstance(v, Mapping) for v in value):
        heads = list(dict.fromkeys(k for v in value for k in v))
        if len(value) == 1 and len(heads) > _ACROSS:
            return {"heads": [], "cells": [[k, _shown(v)] for k, v in value[0].items()]}
        return {"heads": heads, "cells": [[_shown(v.get(k, "")) for k in heads] for v in value]}
    if all(isinstance(v, list | tuple) and 0 < len(v) == len(value[0]) <= MOST for v in value):
        return {"heads": [], "cells": [[_shown(e) for e in v] for v in value]}
    return None


def _shown(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "none"}[value]
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, complex):
        sign = "\u2212" if value.imag < 0 else "+"
        return f"{value.real:.6g} {sign} {abs(value.imag):.6g} i" if value.imag else f"{value.real:.6g}"
    if isinstance(value, sp.Expr):
        return _formula(value)
    if isinstance(value, Mapping):
        return ", ".join(f"{k} = {_shown(v)}" for k, v in value.items()) or "none"
    if isinstance(value, list | tuple):
        return _listed(value)
    return str(value) or "none"


def _formula(expr: sp.Expr) -> str:
    """Return an expression as MathML, names of symbols escaped and entities as their letters."""
    from markupsafe import Markup

    safe = {s: sp.Symbol(html.escape(s.name)) for s in expr.free_symbols}
    text = mathml(expr.xreplace(safe), printer="presentation")
    text = re.sub(r"&(?!lt;|gt;|amp;|quot;|#)\w+;", lambda entity: html.unescape(entity[0]), text)
    text = text.replace("<mo><</mo>", "<mo>&lt;</mo>").replace("<mo>></mo>", "<mo>&gt;</mo>")  # SymPy writes them bare
    return Markup(f"<math>{text}</math>")


def _listed(value: Sequence[Any]) -> str:
    """Return a list on one line, of a long one the number of entries and their range."""
    if len(value) <= MOST and not any(isinstance(v, Mapping) for v in value):
        nested = any(isinstance(v, list | tuple) for v in value)
        return ("; " if nested else ", ").join(_shown(v) for v in value) or "none"
    if all(isinstance(v, bool) for v in value):
        return f"{sum(value)} of {len(value)}"
    if all(isinstance(v, int | float) for v in value):
        finite = [v for v in value if v == v]
        return f"{len(value)} values from {_shown(min(finite))} to {_shown(max(finite))}" if finite else "all undefined"
    return f"{len(value)} values"
