"""Units of a scene: every listed unit is read, the equations are checked with them, and others follow."""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC
from symfric.model.dimensions import Dimension, Dimensions, Mismatch, factor
from symfric.model.outputs import (
    Integral,
    OutputOfExpression,
    Period,
    StopTime,
    dissipated_power,
    friction_force,
    normal_force,
    stored_energy,
)
from symfric.model.outputs import slip as slip_of
from symfric.model.symbols import SPEED, TIME, nearest, shorten
from symfric.model.unit_texts import NUMBER, in_base_units, read_unit

if TYPE_CHECKING:
    from symfric.model.held import Held
    from symfric.model.laws import Law
    from symfric.model.resets import Reset
    from symfric.model.scene import Scene
    from symfric.model.system import Contact, System
    from symfric.model.unilateral import Unilateral

_COMMON = ("m", "m/s", "m/s²", "1/s", "s", "kg", "N", "J", "W", "N/m", "N s/m", "Pa", "N m s", "kg m²")


class Units(Mapping[str, str]):
    """Units of the symbols of a scene by name, as far as they are given or follow from its equations.

    A mapping to texts: as the file writes them, those that follow in the same manner, "" for plain numbers.
    """

    def __init__(self, written: Mapping[str, str], known: Dimensions, given: Iterable[str] | None = None):
        self._written, self._known = dict(written), known
        self._given = tuple(written.values()) if given is None else tuple(given)

    def __getitem__(self, name: str) -> str:
        return self._written[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._written)

    def __len__(self) -> int:
        return len(self._written)

    def of(self, e: sp.Expr) -> str:
        """Return the unit of an expression; "" for a plain number and where it is not known."""
        if not self:
            return ""
        try:
            return self._text(self._known.copy().of(sp.sympify(e)))
        except Mismatch:
            return ""

    def of_coefficient(self, contact: str, name: str) -> str:
        """Return the unit of a coefficient of a contact's law."""
        return self._text(self._known.of_name(coefficient_of(contact, name))) if self else ""

    @property
    def rate(self) -> str:
        """Unit of a rate of growth."""
        return self.of(1 / TIME)

    @property
    def angular(self) -> str:
        """Unit of an angular frequency."""
        return f"rad/{self[TIME.name]}" if self.get(TIME.name) else ""

    @property
    def hertz(self) -> float:
        """Factor from an angular frequency to one in Hz; NaN where the unit of time is not known."""
        time = self._known.of_name(TIME.name)
        if not self or time.unknown or dict(time.base) != {"[time]": 1}:
            return math.nan
        return 1 / (2 * math.pi * factor(time))

    def _text(self, dimension: Dimension) -> str:
        if dimension.unknown or dimension.is_plain:
            return ""
        time = self.get(TIME.name, "")
        if time and (dimension * read_unit(time)).is_plain:
            return f"1/{time}"
        for text in (*self._given, *_COMMON):
            if text and (dimension / read_unit(text)).is_plain:
                return text
        rate = next(
            (g for g in self._given if time and g and (dimension * read_unit(time) / read_unit(g)).is_plain), ""
        )
        if rate.isalpha():  # mm/ms, where neither is among the usual ones
            return f"{rate}/{time}"
        known = [text for text in (*self._given, *_COMMON) if text and read_unit(text).base == dimension.base]
        if known:
            return f"{factor(dimension / read_unit(known[0])):.6g} {known[0]}"
        return in_base_units(dimension)


_FACTOR = re.compile(r"(?<![\w.*])\d+(\.\d+)?(e[+-]?\d+)?\*(?!\*)")  # a number that multiplies

NO_UNITS = Units({}, Dimensions({}))


@dataclass(frozen=True)
class LetteredLaw:
    """A law with letters for its coefficients, so that those which are numbers have units that follow from it.

    Attributes
    ----------
    law : Law
    letters : mapping of str to Symbol
        The letter of each coefficient.
    values : mapping of str to Expr
        Coefficients that are expressions of the scene's parameters.
    """

    law: "Law"
    letters: Mapping[str, sp.Symbol]
    values: Mapping[str, sp.Expr]


_NO_LAWS: Mapping[str, LetteredLaw] = MappingProxyType({})


def units_of(scene: "Scene", given: Mapping[str, str], laws: Mapping[str, LetteredLaw] = _NO_LAWS) -> Units:
    """Return the units of a scene from those given for some of its symbols.

    Parameters
    ----------
    scene : Scene
    given : mapping of str to str
        Units by name, "t" for time.
    laws : mapping of str to LetteredLaw
        By contact; of the others the units of numbers in them are not known.

    Raises
    ------
    SceneError
        If a name is unknown, a unit is not one, or terms of an equation that are added differ in theirs.

    Notes
    -----
    The numbers of a scene are used as they stand, so the units must fit without factors: newtons beside kilonewtons do
    not. A number that is added takes the unit of the sum; one that multiplies has none.
    """
    if not given:
        return NO_UNITS
    points = [s for s in scene.system.rows if s.name.isidentifier()]  # of a structure
    names = [s.name for s in (*scene.system.states, *points, *scene.parameters, *scene.inputs, TIME)]
    for name in given:
        if name not in names:
            raise SceneError(f"units.{shorten(name, 40)}: no such state or value{nearest(name, names)}")
    known = Dimensions({name: read_unit(text, f"units.{name}") for name, text in given.items()})
    with SYMBOLIC:
        units = Units(dict(given), known)
        for place, check in _equations(scene, known, laws):
            _checked(place, check, units, [c.name for c in scene.contacts])
        derived = {name: units._text(known.of_name(name)) for name in names if name not in given}
    shown = {name: "" if text in NUMBER else text for name, text in given.items()}
    return Units({**shown, **derived}, known, shown.values())


def check_outputs(units: Units, outputs: Mapping[str, object]) -> None:
    """Raise if an output adds terms of different units."""
    if not units:
        return
    known = units._known.copy()
    with SYMBOLIC:
        for name, output in outputs.items():
            if isinstance(output, OutputOfExpression):
                _checked(f"outputs.{name}", partial(known.of, output.expr), units, ())


def _checked(place: str, check: Callable[[], object], units: Units, contacts: Iterable[str]) -> None:
    try:
        check()
    except Mismatch as error:
        said = _said(place, error, units)
        for contact in contacts:
            said = said.replace(coefficient_of(contact, ""), "")
        raise SceneError(said) from None


def _said(place: str, error: Mismatch, units: Units) -> str:
    def shown(term: tuple[str, Dimension]) -> str:
        text, dimension = term
        unit = "a plain number" if dimension.is_plain else f"in {units._text(dimension) or 'another unit'}"
        return text if text == unit else f"{shorten(text, 60)} is {unit}"

    if error.other[0] == "a plain number":
        return f"{place}: {shown(error.one)} and must be a plain number; mend the units or the expression"
    cure = "mend the units or the expression"
    if any(_FACTOR.search(term[0]) for term in (error.one, error.other)):
        cure += "; a number that multiplies has no unit, so write a stiffness or a mass as a symbol with a value"
    return f"{place}: {shown(error.one)} and {shown(error.other)}; {cure}"


def _equations(
    scene: "Scene", known: Dimensions, laws: Mapping[str, LetteredLaw]
) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield what must agree, with its place; what matrices of numbers do is not known."""
    system = scene.system
    time = known.of_name(TIME.name)
    for q, u in zip(system.q, system.u, strict=True):
        rate = (f"the rate of {q.name}", known.of_name(q.name) / time)
        yield f"units.{u.name}", partial(known.equal, (u.name, known.of_name(u.name)), rate)
    written = system.linear is None
    for i, force in enumerate(system.force):
        yield f"scene.force[{i}]", partial(known.of, force)
        for j, u in enumerate(system.u if written else ()):
            mass = system.mass[i, j]
            if not mass.is_number:
                yield f"scene.mass[{i}][{j}]", partial(_of_mass, known, mass, u, force)
    for z, rate in zip(system.z[: len(system.z) - system.made], system.z_rate, strict=False):
        yield f"the rate of {z.name}", partial(_agree, known, rate, z)
    yield from _of_rows(system, known)
    for contact in scene.contacts:
        place = f"friction {contact.name!r}"
        for w in contact.slips:
            yield f"{place}, slip", partial(known.of, w)
        if contact.across is not None:
            yield f"{place}, slip", partial(_agree_in_plane, known, contact.slip, contact.across)
        yield f"{place}, normal", partial(known.of, contact.normal)
        if contact.unilateral is not None:
            yield from _of_opening(known, contact, contact.unilateral, system, written)
        for i, u in enumerate(system.u if written else ()):
            for lever in (w.diff(u) for w in contact.slips):
                if not lever.is_zero and not system.force[i].is_number:
                    yield place, partial(_of_load, known, contact, lever, system.force[i])
        for e in contact.ellipse or ():
            yield f"{place}, ellipse", partial(known.plain, e)
        yield f"{place}, profile", partial(known.plain, contact.profile)
        yield f"{place}, law", partial(_of_law, known, contact, laws.get(contact.name))
        yield place, partial(_of_outputs, known, contact)
        if contact.stiffness is not None:
            yield f"{place}, stiffness", partial(_of_spring, known, contact, contact.stiffness)
    for held in scene.held:
        yield f"held.{held.name}", partial(_of_held, known, held)
    for k, reset in enumerate(scene.resets):
        yield f"reset[{k}]", partial(_of_reset, known, reset)
    for name, output in scene.outputs.items():
        if isinstance(output, OutputOfExpression):
            yield f"outputs.{name}", partial(known.of, output.expr)
    for state, start in scene.initial.items():
        if isinstance(start, sp.Expr):
            yield f"initial.{state.name}", partial(_of_start, known, state, start)


def _of_rows(system: "System", known: Dimensions) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield what must agree in a structure: rates of its points, forces that act on it."""
    part, time = system.linear, known.of_name(TIME.name)
    if part is None:
        return
    names = {s.name for s in part.rows}
    for name in (n for n in names if f"d_{n}" in names):
        rate = (f"the rate of {name}", known.of_name(name) / time)
        yield f"units.d_{name}", partial(known.equal, (f"d_{name}", known.of_name(f"d_{name}")), rate)
    for k, (load, _) in enumerate(part.loads):
        yield f"scene.force[{k}]", partial(known.of, load)


def _of_held(known: Dimensions, held: "Held") -> None:
    own, time = (held.name, known.of_name(held.name)), (TIME.name, known.of_name(TIME.name))
    for symbol in (held.previous, *held.queue):
        known.equal((symbol.name, known.of_name(symbol.name)), own)
    for symbol in held.left:
        known.equal((symbol.name, known.of_name(symbol.name)), time)
    _of_instants(known, held)
    for e in (held.update, sp.sympify(held.initial), sp.sympify(held.step or 0)):
        if not e.is_number:
            known.equal((str(e), known.of(_as_branches(e))), own)


def _of_reset(known: Dimensions, reset: "Reset") -> None:
    _of_instants(known, reset)
    for name, entries in reset.set.items():
        for e in (e for e in entries if not e.is_number):
            known.equal((str(e), known.of(_as_branches(e))), (name, known.of_name(name)))


def _of_instants(known: Dimensions, part: "Held | Reset") -> None:
    """Check the times of a held variable or a reset, and its expression that crosses zero."""
    for e in (e for e in part.times if not e.is_number):
        known.equal((str(e), known.of(e)), (TIME.name, known.of_name(TIME.name)))
    if part.crossing is not None:
        known.of(part.crossing)


def _as_branches(e: sp.Expr) -> sp.Expr:
    """Return an expression with signs, which are plain numbers, as branches."""
    return e.replace(sp.sign, lambda a: sp.Piecewise((-1, a < 0), (1, True)))


def _of_start(known: Dimensions, state: sp.Symbol, start: sp.Expr) -> None:
    known.equal((f"the start {start}", known.of(start)), (state.name, known.of_name(state.name)))


def _of_mass(known: Dimensions, mass: sp.Expr, u: sp.Symbol, force: sp.Expr) -> None:
    inertia = known.of(mass) * known.of_name(u.name) / known.of_name(TIME.name)
    if not force.is_number:
        known.equal((f"{mass} times the rate of {u.name}", inertia), (str(force), known.of(force)))


def _of_load(known: Dimensions, contact: "Contact", lever: sp.Expr, force: sp.Expr) -> None:
    acting = known.of(lever) * _load(known, contact)
    known.equal((f"the load {contact.normal}", acting), (f"the force {force}", known.of(force)))


def _of_opening(
    known: Dimensions, contact: "Contact", direction: "Unilateral", system: "System", written: bool
) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield what must agree in a contact that opens: its normal force does work along the gap."""
    place = f"friction {contact.name!r}"
    yield f"{place}, gap", partial(known.of, direction.gap)
    yield f"{place}, restitution", partial(known.plain, direction.restitution)
    for i, q in enumerate(system.q if written else ()):
        lever = direction.gap.diff(q)
        if not lever.is_zero and not system.force[i].is_number:
            yield f"{place}, gap", partial(_of_load, known, contact, lever, system.force[i])


def _load(known: Dimensions, contact: "Contact") -> Dimension:
    """Return the dimension of a load, which is that of the forces if it is a number."""
    return known.of_name(f"load of {contact.name}") if contact.normal.is_number else known.of(contact.normal)


def _agree_in_plane(known: Dimensions, first: sp.Expr, second: sp.Expr) -> None:
    """Check that the components of a slip vector have the same dimension."""
    known.equal((str(first), known.of(first)), (str(second), known.of(second)))


def _of_law(known: Dimensions, contact: "Contact", lettered: LetteredLaw | None) -> None:
    """Check a law, whose coefficients that are numbers have units that follow from it."""
    law, slip = contact.law, known.of(contact.slip)
    if law.memory:
        return
    if lettered is not None:
        law = lettered.law
        for name, value in lettered.values.items():
            known.equal((str(value), known.of(value)), (name, known.of_name(lettered.letters[name].name)))
    elif any(e.atoms(sp.Float, sp.Rational) for e in (law.kinetic, law.stick)):
        slip = known.new()  # the units of the numbers in it are not said
    known.define(SPEED.name, slip)
    for e in (law.kinetic, law.stick):
        if e.free_symbols:
            known.plain(e)


def coefficient_of(contact: str, name: str) -> str:
    """Return the name of a coefficient of a contact's law among the symbols that have units."""
    return f"{name} of {contact}"


def _of_outputs(known: Dimensions, contact: "Contact") -> None:
    """Assign dimensions to the symbols of contacts that outputs may contain."""
    load, slip = _load(known, contact), known.of(contact.slip)
    for component in (0, 1) if contact.in_plane else (None,):
        known.define(friction_force(contact.name, component).name, load)
    if contact.unilateral is None:
        known.define(normal_force(contact.name).name, load)
    known.define(slip_of(contact.name).name, slip)
    known.define(dissipated_power(contact.name).name, load * slip)
    known.define(stored_energy(contact.name).name, load * slip * known.of_name(TIME.name))


def _of_spring(known: Dimensions, contact: "Contact", stiffness: sp.Expr) -> None:
    (z,) = contact.states
    known.equal(
        (z.name, known.of_name(z.name)), ("the slip times t", known.of(contact.slip) * known.of_name(TIME.name))
    )
    if not stiffness.is_number:
        force = known.of(stiffness) * known.of_name(z.name)
        known.equal((f"{stiffness} times {z.name}", force), (str(contact.normal), _load(known, contact)))


def _agree(known: Dimensions, rate: sp.Expr, z: sp.Symbol) -> None:
    if not rate.is_number:
        rate_unit = (f"the rate of {z.name}", known.of_name(z.name) / known.of_name(TIME.name))
        known.equal((str(rate), known.of(rate)), rate_unit)


def with_unit(name: str, units: Mapping[str, str]) -> str:
    """Return the unit of a symbol in brackets to be put after its name; empty if there is none."""
    return f" [{units[name]}]" if units.get(name) else ""


def attributes_of(name: str, units: Mapping[str, str]) -> dict[str, str]:
    """Return the attributes of an array of xarray that hold numbers of a symbol: its unit, if there is one."""
    return {"units": units[name]} if units.get(name) else {}


def output_unit(units: Units, output: object) -> str:
    """Return the unit of an output of an expression or of a time; "" for others."""
    if isinstance(output, StopTime | Period):
        return units.of(TIME)
    if not isinstance(output, OutputOfExpression):
        return ""
    return units.of(output.expr * TIME if isinstance(output, Integral) else output.expr)
