"""Checks of a scene that need several of its parts or its numbers."""

import itertools
from collections.abc import Mapping

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.held import Held
from symfric.model.jumps import refuse_jumps
from symfric.model.laws.requirements import Requirement
from symfric.model.numeric import numeric_function
from symfric.model.outputs import OF_CONTACTS, Output, normal_force
from symfric.model.resets import Reset
from symfric.model.steps import check_lines, compare_across
from symfric.model.symbols import TIME, nearest, refuse_speed, shorten
from symfric.model.system import Contact, System
from symfric.model.tables import table_of
from symfric.model.tree import parts_of

_WITHIN = 1e-12  # of the way gone over a run: a gap as negative counts as closed, since the end of a run may be a start


def check_contacts(system: System, contacts: tuple[Contact, ...]) -> None:
    """Raise unless the names differ, the slips are linear in u and the normal loads free of u-dependent friction."""
    names = [c.name for c in contacts]
    for i, contact in enumerate(contacts):
        if contact.name in names[:i]:
            raise SceneError(f"two contacts are called {contact.name!r}; give each its own name")
        moving = {*system.u, *(s for s in system.rows if system.linear and system.linear.rows[s].of == "u")}
        for slip in contact.slips:
            _check_slip(system, contact, slip, moving)
        if contact.unilateral is not None:
            _check_unilateral(system, contact, moving)
        if contact.in_plane:
            _check_plane(system, contact, contacts)
        if contact.profile.free_symbols & {*system.u, *system.z, TIME}:
            raise SceneError(f"profile of contact {contact.name!r} is {contact.profile}; it may depend on q only")
        behind = not contact.along_line and not contact.frictionless
        if behind and contact.normal.free_symbols & {normal_force(name) for name in names}:
            raise SceneError(
                f"normal of contact {contact.name!r} is {contact.normal}, which jumps where that contact opens or "
                "strikes; behind a spring the limit of its force must be continuous"
            )
        if contact.stiffness is not None:
            _check_spring(system, contact, moving)
        elif behind:
            load = contact.normal * contact.profile
            if load.free_symbols & {*system.states, *system.rows, TIME} and not load.is_nonnegative:
                raise SceneError(
                    f"normal of contact {contact.name!r} is {contact.normal}, which may become negative; with sliders "
                    "behind springs write sympy.Max(0, ...) around it"
                )


def _check_slip(system: System, contact: Contact, slip: sp.Expr, moving: set[sp.Symbol]) -> None:
    """Raise unless a slip is linear in the velocities, of which it contains one."""
    entered = [e for e in moving if e in slip.free_symbols] if system.rows else system.u
    slopes = [slip.diff(u) for u in entered]
    if any(slope.free_symbols & moving for slope in slopes):
        raise SceneError(f"slip of contact {contact.name!r} is {slip}, which is not linear in the velocities u")
    if all(slope.is_zero for slope in slopes) and not contact.frictionless:
        raise SceneError(f"slip of contact {contact.name!r} is {slip}; it contains no velocity of the system")
    if slip.free_symbols & set(system.z):
        raise SceneError(f"slip of contact {contact.name!r} is {slip}; it may not depend on z")


def _check_plane(system: System, contact: Contact, contacts: tuple[Contact, ...]) -> None:
    """Raise if the components of a slip are parallel, or with contacts beside that do not go with it."""
    for other in contacts:
        if made_of_cells(other.profile):
            where = "in the plane" if other is contact else f"beside contact {contact.name!r} in the plane"
            raise SceneError(f"profile of contact {other.name!r} jumps; {where} it must be continuous")
    for e in contact.ellipse or ():
        if e.free_symbols & {*system.states, *system.rows, TIME}:
            raise SceneError(
                f"ellipse of contact {contact.name!r} contains {e}; its factors may depend on parameters only"
            )
    first, second = (list(system.slopes(slip)) for slip in contact.slips)
    crossed = (a * d - b * c for (a, b), (c, d) in itertools.combinations(zip(first, second, strict=True), 2))
    if all(sp.sympify(e).equals(0) for e in crossed):
        raise SceneError(
            f"the two slips of contact {contact.name!r} are {contact.slip} and {contact.across}, which are parallel; "
            "a contact in the plane needs two directions, one along a line a single slip"
        )


def _check_spring(system: System, contact: Contact, moving: set[sp.Symbol]) -> None:
    """Raise unless the limit of the force of a contact behind a spring has a rate without accelerations."""
    assert contact.stiffness is not None
    if contact.normal.free_symbols & {*moving, *system.z}:
        raise SceneError(
            f"normal of contact {contact.name!r} is {contact.normal}; behind a spring it may depend on q and time only"
        )
    if contact.stiffness.free_symbols & {*system.states, *system.rows, TIME}:
        raise SceneError(
            f"stiffness of contact {contact.name!r} is {contact.stiffness}; it may depend on parameters only"
        )
    if made_of_cells(contact.profile):
        raise SceneError(
            f"profile of contact {contact.name!r} jumps; behind a spring the limit of its force must be continuous"
        )


def _check_unilateral(system: System, contact: Contact, moving: set[sp.Symbol]) -> None:
    """Raise unless the gap of a contact depends on coordinates, with a rate that their velocities are."""
    assert contact.unilateral is not None
    gap, restitution = contact.unilateral.gap, contact.unilateral.restitution
    what = f"gap of contact {contact.name!r}"
    if gap.free_symbols & {*moving, *system.z}:
        raise SceneError(f"{what} is {gap}; it may depend on the coordinates q, time and parameters")
    if not gap.free_symbols & {*system.q, *system.rows}:
        raise SceneError(f"{what} is {gap}; it contains no coordinate of the system")
    refuse_jumps(gap, what)
    if restitution.free_symbols & {*system.states, *system.rows, TIME}:
        raise SceneError(f"restitution of contact {contact.name!r} is {restitution}; it may depend on parameters only")
    if contact.law.smooth and not contact.frictionless:
        raise SceneError(
            f"contact {contact.name!r} opens, and its law is regularised, which does not define friction in an impact; "
            "use the law itself"
        )


def check_symbols(symbols: set[sp.Symbol], allowed: dict[str, sp.Symbol], parameters: set[str]) -> None:
    """Raise on a symbol without a value, on a reserved symbol, and on two symbols with one name."""
    seen: dict[str, sp.Symbol] = {}
    for symbol in sorted(symbols, key=str):
        name = symbol.name
        refuse_speed(symbol, "an expression outside a law")
        if name == TIME.name and symbol != TIME:
            raise SceneError("the symbol t is reserved for time; use sf.TIME for time, or rename your symbol t")
        if name not in allowed and name not in parameters:
            hint = nearest(name, parameters | set(allowed)) if parameters else ""
            raise SceneError(f"no value for {name}; add it to Scene.values" + (hint if "did you" in hint else ""))
        if allowed.get(name, seen.setdefault(name, symbol)) != symbol:
            raise SceneError(
                f"{name} is used as two different symbols; create it once, with its assumptions, and use that"
            )


def check_instants(parts: tuple[Held | Reset, ...], states: set[sp.Symbol]) -> None:
    """Raise if times of held variables or resets depend on states or on time."""
    for part in parts:
        what = f"held variable {part.name!r}" if isinstance(part, Held) else "a reset"
        for e in part.times:
            moving = sorted(e.free_symbols & {*states, TIME}, key=str)
            if moving:
                raise SceneError(f"a time of {what} is {e}; it may depend on parameters only, not on {moving[0]}")


def refuse_observables(
    system: System, contacts: tuple[Contact, ...], initial: Mapping[str, object], clocked: tuple[sp.Expr, ...]
) -> None:
    """Raise if forces and slips of contacts, which only outputs have, stand in an equation."""
    beginnings = tuple(f"{kind}(" for kind in OF_CONTACTS)
    allowed = {normal_force(c.name) for c in contacts if c.unilateral is not None}
    places = [(f"force[{i}]", e) for i, e in enumerate(system.force)]
    places += [(f"z_rate[{i}]", e) for i, e in enumerate(system.z_rate[: len(system.z) - system.made])]
    places += [("an entry of the mass matrix", e) for e in system.mass or ()]
    places += [("a load of the structure", e) for e in (system.linear.expressions if system.linear else ())]
    for c in contacts:
        own = (
            ("slip", c.slip),
            ("slip", c.across),
            *(("ellipse", e) for e in c.ellipse or ()),
            ("normal", c.normal),
            ("profile", c.profile),
            ("stiffness", c.stiffness),
        )
        places += [(f"{part} of contact {c.name!r}", e) for part, e in own if e is not None]
        places += [(f"law of contact {c.name!r}", e) for e in c.law.expressions]
    places += [(f"the initial value of {name}", e) for name, e in initial.items() if isinstance(e, sp.Expr)]
    places += [("a held variable or a reset", e) for e in clocked]
    for what, e in places:
        for s in sorted(e.free_symbols - allowed, key=str):
            if s.name.startswith(beginnings):
                kind, contact = s.name[:-1].split("(", 1)
                raise SceneError(
                    f"{what} contains {s.name}, which only outputs know; {_instead(kind, contact, contacts)}"
                )


def _instead(kind: str, contact: str, contacts: tuple[Contact, ...]) -> str:
    """Return what stands in an equation for an observable of a contact."""
    of = next((c for c in contacts if c.name == contact), None)
    if kind == "slip":
        return "write the slip itself" + (f", {shorten(of.slip)}" if of else "")
    return "friction follows from loads; to feel it, put a spring there, whose elongation is a state"


def check_times(outputs: Mapping[str, Output], horizon: float) -> None:
    """Raise if an output is taken at a time after the horizon, by more than rounding, or counts nothing before it."""
    for name, output in outputs.items():
        if output.latest > horizon * (1 + 1e-12):
            raise SceneError(
                f"output {name!r} takes a value at t = {output.latest:.12g}, and the run ends at the horizon "
                f"{horizon:.12g}; choose a later horizon or an earlier time"
            )
        if output.begins >= horizon:
            raise SceneError(
                f"output {name!r} counts after t = {output.begins:.12g}, and the run ends at the horizon "
                f"{horizon:.12g}; choose a later horizon or a smaller after"
            )


def check_continuous(expr: sp.Expr, numbers: dict[sp.Symbol, float], what: str, place: sp.Symbol | None = None) -> None:
    """Raise if a Piecewise in `expr` is discontinuous where its condition changes, unless that is a step in time.

    Each condition's boundary is solved for a symbol in which it is linear or quadratic, and the two neighbouring
    branches are compared there for three random values of the others. Other boundaries are not checked if time is not
    in them. With a `place`, a boundary in time without it is taken for a step.
    """
    for piecewise in parts_of(expr, sp.Piecewise):
        known = piecewise.xreplace(numbers)  # may have no branches left
        table = table_of(known) if isinstance(known, sp.Piecewise) else None
        if table is not None and table.argument != TIME and check_lines(table, what):
            continue
        relations = sorted({r for _, c in piecewise.args for r in parts_of(c, sp.core.relational.Relational)}, key=str)
        for relation in relations:
            boundary = (relation.lhs - relation.rhs).xreplace(numbers)
            timed = TIME in boundary.free_symbols
            if timed and (boundary.free_symbols == {TIME} or (place and place not in boundary.free_symbols)):
                continue
            for unknown in sorted(boundary.free_symbols, key=str):
                if boundary.is_polynomial(unknown) and sp.degree(boundary, unknown) <= 2:
                    compare_across(known, boundary, unknown, what)
                    break
            else:
                if timed:
                    others = ", ".join(sorted(s.name for s in boundary.free_symbols - {TIME}))
                    raise SceneError(
                        f"{what} has the condition {shorten(relation)} of time and state together, with {others}; a "
                        "step in time has one of time and parameters alone. Pulses of a width that a controller "
                        "commands are sf.control.pwm; what else switches with time and state is sf.Held(..., when=...)"
                    )


def made_of_cells(profile: sp.Expr) -> bool:
    """Whether a friction profile is piecewise constant over one coordinate.

    Such a profile may jump: the body passes the edge of a cell with a velocity, as on a floor of different materials.
    """
    if not isinstance(profile, sp.Piecewise):
        return False
    values, conditions = zip(*profile.args, strict=True)
    edges = [c for c in conditions if c != sp.true]
    if not all(isinstance(c, sp.core.relational.Relational) and c.lhs.is_Symbol for c in edges):
        return False
    coordinates = {c.lhs for c in edges}
    return len(coordinates) == 1 and not any(v.free_symbols & coordinates for v in values)


def _number(expr: sp.Expr, numbers: dict[sp.Symbol, float]) -> float | None:
    """Evaluate in floats, since an exact number such as cosh(exp(1e9)) exceeds the memory; None if symbols remain."""
    symbols = tuple(sorted(expr.free_symbols, key=str))
    if not set(symbols) <= set(numbers):
        return None
    return float(numeric_function(symbols, expr)(*(numbers[s] for s in symbols)))


def _rounding(expr: sp.Expr, numbers: dict[sp.Symbol, float]) -> float:
    """Return a bound of the rounding error of a sum, from the sizes of its terms."""
    terms = [_number(term, numbers) for term in sp.Add.make_args(sp.expand(expr))]
    return 1e-14 * sum(abs(term) for term in terms if term is not None) if len(terms) > 1 else 0.0


def _slope(expr: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """Return the derivative of an expression in real symbols: SymPy has none of Abs otherwise."""
    real = {s: sp.Dummy(s.name, real=True) for s in expr.free_symbols if s.is_extended_real is None}
    back = {d: s for s, d in real.items()}
    return expr.xreplace(real).diff(real.get(variable, variable)).xreplace(back)


def _check_gap(system: System, contact: Contact, numbers: dict[sp.Symbol, float], horizon: float) -> None:
    """Raise if the bodies are within each other at the start by more than a run leaves, or a restitution is wrong."""
    assert contact.unilateral is not None
    e = contact.unilateral.gap
    gap, rate = _number(e, numbers), _number(_slope(e, TIME), numbers)
    size = 0.0 if rate is None else abs(rate) * horizon
    for q, u in zip(system.q, system.u, strict=True):
        slope = _number(_slope(e, q), numbers)
        if slope is not None and {q, u} <= set(numbers):
            size += abs(slope) * (abs(numbers[q]) + abs(numbers[u]) * horizon)
    if gap is not None and not gap >= -_rounding(e, numbers) - _WITHIN * size:
        raise SceneError(f"gap of contact {contact.name!r} is {gap:.6g} at the start; it must not be negative")
    restitution = _number(contact.unilateral.restitution, numbers)
    if restitution is not None and not 0 <= restitution <= 1:
        raise SceneError(f"restitution of contact {contact.name!r} is {restitution:.6g}; it must lie between 0 and 1")


def negative_load(contact: Contact, numbers: dict[sp.Symbol, float]) -> float | None:
    """Return the normal load of a contact where it is negative by more than rounding or no number, else None."""
    normal = _number(contact.normal, numbers)
    return None if normal is None or normal >= 0 or normal >= -_rounding(contact.normal, numbers) else normal


def requirements_of(contact: Contact) -> list[Requirement]:
    """Return what the numbers of a contact and of its law must satisfy; all depend on parameters only."""
    own = [Requirement(f"a factor of the ellipse of contact {contact.name!r}", e) for e in contact.ellipse or ()]
    if contact.stiffness is not None:
        own.append(Requirement(f"stiffness of contact {contact.name!r}", contact.stiffness))
    of = f"law of contact {contact.name!r}: "
    return [*own, *(e._replace(name=of + e.name) for e in contact.law.requirements)]


def check_start(system: System, contacts: tuple[Contact, ...], numbers: dict[sp.Symbol, float], horizon: float) -> None:
    """Raise unless the mass is positive definite and the normal loads are not negative at the start."""
    if system.mass is not None:
        entries = [_number(e, numbers) for e in system.mass]
        if None in entries:
            return
        mass = np.array(entries).reshape(system.mass.shape)
        mass = mass if system.linear is None else mass + system.linear.M.toarray()
        if not np.all(np.isfinite(mass)) or np.min(np.linalg.eigvalsh(mass)) <= 0:
            raise SceneError(f"the mass matrix is not positive definite at the start: {mass.tolist()}")
    fixed = {s: v for s, v in numbers.items() if s not in {*system.states, *system.rows, TIME}}
    for i, e in enumerate(system.force):
        value = _number(e, numbers)
        if value is not None and not np.isfinite(value):
            raise SceneError(f"force[{i}] is {value} at the start; it must be finite")
    for contact in contacts:
        if contact.unilateral is not None:
            _check_gap(system, contact, numbers, horizon)
        if (normal := negative_load(contact, numbers)) is not None:
            raise SceneError(
                f"normal of contact {contact.name!r} is {normal:.6g} at the start; it must not be negative"
            )
        for asked in requirements_of(contact):
            value = _number(asked.value, numbers)
            if value is not None and not asked.holds(value):
                raise SceneError(asked.complaint(value))
        rest, stick = (_number(e, numbers) for e in (contact.law.at_rest, contact.law.stick))
        for which, value in (("kinetic", rest), ("static", stick)):
            if value is not None and value < -1e-12 * abs(stick or 0.0):
                raise SceneError(
                    f"law of contact {contact.name!r}: the {which} coefficient at rest is {value:.6g}; "
                    "it must not be negative"
                )
        if rest is not None and stick is not None and rest > stick * (1 + 1e-12) + 1e-300:
            raise SceneError(
                f"law of contact {contact.name!r}: the static coefficient {stick:.6g} is smaller than the "
                f"kinetic one at rest, {rest:.6g}; neither sticking nor slipping would be possible between them"
            )
        check_continuous(contact.law.kinetic, fixed, f"law of contact {contact.name!r}")
        if not made_of_cells(contact.profile):
            check_continuous(contact.profile, fixed, f"profile of contact {contact.name!r}")
        check_continuous(contact.normal, fixed, f"normal of contact {contact.name!r}")
