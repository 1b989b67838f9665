"""Corners and jumps of gaps: a contact that passes one would strike there, which a run does not look for.

While a contact is closed its gap stays zero by a force. A force cannot follow a gap whose slope jumps at a place: the
velocities would have to jump, in an impact of a contact that is closed already. At a known time they do.
"""

import re
from collections.abc import Iterator

import numpy as np
import sympy as sp
from sympy.core.relational import Relational

from symfric.errors import SceneError
from symfric.model.kinks import gradient
from symfric.model.numeric import numeric_function
from symfric.model.symbols import TIME
from symfric.model.system import Contact, System
from symfric.model.tree import parts_of
from symfric.model.validation import check_continuous

_PLACES = "where it is the smaller of two gaps, give each a contact of its own; round a corner that stands out"
_TIMES = "write a bend in time as a Piecewise with a condition on sf.TIME"
_SAMPLES = 4096  # of a run, between which a condition on time changes once at most
_STEP = 1e-9  # of a run, on both sides of a step in time


def check_gaps(system: System, contacts: tuple[Contact, ...], numbers: dict[sp.Symbol, float], horizon: float) -> None:
    """Raise if a gap jumps, or has a corner at a place.

    Parameters
    ----------
    system : System
    contacts : tuple of Contact
    numbers : dict of Symbol to float
        Parameters, and the state at the start.
    horizon : float
        Length of the run.

    Raises
    ------
    SceneError
        Naming the contact and the cure.
    """
    for contact in contacts:
        if contact.unilateral is not None and parts_of(
            contact.unilateral.gap, sp.Abs, sp.Max, sp.Min, sp.Piecewise, sp.sign
        ):
            _check_gap(system, contact.name, contact.unilateral.gap, numbers, horizon)


def _check_gap(system: System, name: str, gap: sp.Expr, numbers: dict[sp.Symbol, float], horizon: float) -> None:
    what = f"gap of contact {name!r}"
    moving = [s for s in (*system.q, *system.rows) if s in gap.free_symbols]
    known = {s: v for s, v in numbers.items() if s in gap.free_symbols and s not in {*moving, TIME}}
    fixed = gap.xreplace(known)
    _refuse_steps(fixed, what, moving, numbers, horizon)
    real = {s: sp.Dummy(s.name, real=True) for s in (*moving, TIME)}
    names = {d: sp.Symbol(s.name) for s, d in real.items()}
    branches = list(_without_steps(fixed, moving))
    for variable, cure in [*((q, _PLACES) for q in moving), *([(TIME, _TIMES)] if TIME in gap.free_symbols else [])]:
        for branch in branches:
            _refuse_corner(branch.xreplace(real), real[variable], what, cure, names)


def _refuse_corner(gap: sp.Expr, variable: sp.Symbol, what: str, cure: str, names: dict[sp.Symbol, sp.Symbol]) -> None:
    """Raise if a gap jumps, or its slope over a variable does."""
    try:
        check_continuous(gap, {}, what)
        gradient(gap, variable, "slope", "")
    except SceneError as error:
        where = str(error)
        for dummy, symbol in names.items():
            where = re.sub(rf"(?<!\w){re.escape(str(dummy))}\b", symbol.name, where)
        where = re.sub(r"d slope/d \S+", "its slope", where.split(";")[0]).removeprefix(f"{what} ")
        raise SceneError(f"{what} has a corner or a jump over {names[variable]} ({where}); {cure}") from None


def _without_steps(gap: sp.Expr, moving: list[sp.Symbol]) -> Iterator[sp.Expr]:
    """Yield the gap between steps in time: with every choice of branches of a Piecewise of time alone."""
    for piecewise in sorted(parts_of(gap, sp.Piecewise), key=lambda e: (-e.count_ops(), str(e))):
        conditions = set().union(*(c.free_symbols for _, c in piecewise.args))
        if TIME in conditions and not conditions & set(moving):
            for branch, _ in piecewise.args:
                yield from _without_steps(gap.xreplace({piecewise: branch}), moving)
            return
    yield gap


def _refuse_steps(
    gap: sp.Expr, what: str, moving: list[sp.Symbol], numbers: dict[sp.Symbol, float], horizon: float
) -> None:
    """Raise if a gap jumps at a known time."""
    relations = {r for p in parts_of(gap, sp.Piecewise) for _, c in p.args for r in parts_of(c, Relational)}
    value = numeric_function((TIME, *moving), gap)
    start = [numbers.get(q, 0.0) for q in moving]
    for relation in sorted(relations, key=str):
        if relation.free_symbols != {TIME}:
            continue
        boundary = numeric_function((TIME,), relation.lhs - relation.rhs)
        t = np.linspace(0.0, horizon, _SAMPLES)
        b = np.broadcast_to(boundary(t), t.shape)
        for k in np.flatnonzero(np.sign(b[:-1]) * np.sign(b[1:]) <= 0.0):
            low, high = t[k], t[k + 1]
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if boundary(low) * boundary(middle) > 0.0 else (low, middle)
            h = _STEP * horizon
            g = [float(value(high + d, *start)) for d in (-2 * h, -h, h, 2 * h)]
            if abs(g[2] - g[1]) > 20 * max(abs(g[1] - g[0]), abs(g[3] - g[2])) + 1e-9 * (abs(g[1]) + abs(g[2])):
                raise SceneError(
                    f"{what} jumps by {g[2] - g[1]:.3g} at t = {high:.6g}; a body does not move a distance in no time: "
                    "give it a time to do so"
                )
