"""Units of a scene file: every listed unit is read, the equations are checked with them, and others follow."""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from functools import cache, partial

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC
from symfric.model.outputs import (
    Integral,
    OutputOfExpression,
    StopTime,
    dissipated_power,
    friction_force,
    stored_energy,
)
from symfric.model.outputs import slip as slip_of
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME, superscript
from symfric.scenefile.dimensions import PLAIN, Dimension, Dimensions, Mismatch, factor
from symfric.scenefile.expressions import parse_expression, shorten
from symfric.scenefile.friction import friction_laws

_WRITTEN = re.compile(r"[\w\s·⋅*/^().%°²³⁻¹⁰⁴⁵⁶⁷⁸⁹+-]{0,40}")
_POWER = re.compile(r"(\*\*|\^)\s*([+-]?\d{1,2}(\.\d+)?(?!\s*(\*\*|\^|\d))|\(\s*-?\d{1,2}\s*/\s*\d{1,2}\s*\))")
_NUMBER = ("", "1", "-", "–")
_BASE = {"[mass]": "kg", "[length]": "m", "[time]": "s", "[current]": "A", "[temperature]": "K"}
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
        return self._text(self._known.of_name(_coefficient(contact, name))) if self else ""

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
        found = self._known.of_name(TIME.name)
        if not self or found.unknown or dict(found.base) != {"[time]": 1}:
            return math.nan
        return 1 / (2 * math.pi * factor(found))

    def _text(self, found: Dimension) -> str:
        if found.unknown or found.is_plain:
            return ""
        time = self.get(TIME.name, "")
        if time and (found * _read(time)).is_plain:
            return f"1/{time}"
        for text in (*self._given, *_COMMON):
            if text and (found / _read(text)).is_plain:
                return text
        known = [text for text in (*self._given, *_COMMON) if text and _read(text).base == found.base]
        if known:
            return f"{factor(found / _read(known[0])):.6g} {known[0]}"
        return _in_base_units(found)


def units_of(scene: Scene, given: Mapping[str, str], laws=()) -> Units:
    """Return the units of a scene from those given for some of its symbols.

    Raises
    ------
    SceneError
        If a unit is not one, or terms of an equation that are added differ in theirs.

    Notes
    -----
    The numbers of a scene are used as they stand, so the units must fit without factors: newtons beside kilonewtons do
    not. A number that is added takes the unit of the sum; one that multiplies has none.
    """
    if not given:
        return Units({}, Dimensions({}))
    known = Dimensions({name: _read(text, f"units.{name}") for name, text in given.items()})
    with SYMBOLIC:
        for place, check in _equations(scene, known, laws):
            try:
                check()
            except Mismatch as error:
                said = _said(place, error, Units(dict(given), known))
                for contact in scene.contacts:
                    said = said.replace(_coefficient(contact.name, ""), "")
                raise SceneError(said) from None
        units = Units(dict(given), known)
        points = [s for s in scene.system.rows if s.name.isidentifier()]
        names = [s.name for s in (*scene.system.states, *points, *scene.parameters, TIME)]
        found = {name: units._text(known.of_name(name)) for name in names if name not in given}
    shown = {name: "" if text in _NUMBER else text for name, text in given.items()}
    return Units({**shown, **found}, known, shown.values())


def _said(place: str, error: Mismatch, units: Units) -> str:
    def shown(term: tuple[str, Dimension]) -> str:
        text, dimension = term
        unit = "a plain number" if dimension.is_plain else f"in {units._text(dimension) or 'another unit'}"
        return text if text == unit else f"{shorten(text, 60)} is {unit}"

    if error.other[0] == "a plain number":
        return f"{place}: {shown(error.one)} and must be a plain number; mend [units] or the expression"
    return f"{place}: {shown(error.one)} and {shown(error.other)}; mend [units] or the expression"


def _equations(scene: Scene, known: Dimensions, laws) -> Iterator[tuple[str, Callable[[], object]]]:
    """Yield what must agree, with its place in the file."""
    system = scene.system
    time = known.of_name(TIME.name)
    for q, u in zip(system.q, system.u, strict=True):
        rate = (f"the rate of {q.name}", known.of_name(q.name) / time)
        yield f"units.{u.name}", partial(known.equal, (u.name, known.of_name(u.name)), rate)
    for i, force in enumerate(system.force):
        yield f"scene.force[{i}]", partial(known.of, force)
        for j, u in enumerate(system.u if system.mass is not None else ()):
            mass = system.mass[i, j]
            if not mass.is_number:
                yield f"scene.mass[{i}][{j}]", partial(_of_mass, known, mass, u, force)
    for z, rate in zip(system.z, system.z_rate, strict=True):
        yield f"the rate of {z.name}", partial(_agree, known, rate, z)
    yield from _of_rows(system, known)
    specs = {spec.contact: spec for spec in laws}
    for contact in scene.contacts:
        place = f"friction {contact.name!r}"
        yield f"{place}, slip", partial(known.of, contact.slip)
        yield f"{place}, normal", partial(known.of, contact.normal)
        for i, u in enumerate(system.u):
            lever = contact.slip.diff(u)
            if not lever.is_zero and not system.force[i].is_number:
                yield place, partial(_of_load, known, contact, lever, system.force[i])
        yield f"{place}, profile", partial(known.plain, contact.profile)
        yield f"{place}, law", partial(_of_law, known, contact, specs.get(contact.name), scene)
        yield place, partial(_of_outputs, known, contact)
    for name, output in scene.outputs.items():
        if isinstance(output, OutputOfExpression):
            yield f"outputs.{name}", partial(known.of, output.expr)


def _of_rows(system, known: Dimensions) -> Iterator[tuple[str, Callable[[], object]]]:
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


def _of_mass(known: Dimensions, mass: sp.Expr, u: sp.Symbol, force: sp.Expr) -> None:
    inertia = known.of(mass) * known.of_name(u.name) / known.of_name(TIME.name)
    if not force.is_number:
        known.equal((f"{mass} times the rate of {u.name}", inertia), (str(force), known.of(force)))


def _of_load(known: Dimensions, contact, lever: sp.Expr, force: sp.Expr) -> None:
    acting = known.of(lever) * known.of(contact.normal)
    known.equal((f"the load {contact.normal}", acting), (f"the force {force}", known.of(force)))


def _of_law(known: Dimensions, contact, spec, scene: Scene) -> None:
    """Check a law, whose coefficients that are numbers have units that follow from it."""
    law, slip = contact.law, known.of(contact.slip)
    if law.memory:
        return
    if spec is not None and not any(isinstance(v, list) for v in spec.coefficients.values()) and spec.law != "custom":
        names = {s.name: s for s in scene.parameters}
        letters = {n: sp.Symbol(_coefficient(spec.contact, n), positive=True) for n in spec.coefficients}
        law = friction_laws()[spec.law](**letters)
        for name, value in spec.coefficients.items():
            if isinstance(value, str):
                one = (value, known.of(parse_expression(value, names, name)))
                known.equal(one, (name, known.of_name(letters[name].name)))
    elif any(e.atoms(sp.Float, sp.Rational) for e in (law.kinetic, law.stick)):
        slip = known.new()  # the units of the numbers in it are not said
    known.define(SPEED.name, slip)
    for e in (law.kinetic, law.stick):
        if e.free_symbols:
            known.plain(e)


def _coefficient(contact: str, name: str) -> str:
    return f"{name} of {contact}"


def _of_outputs(known: Dimensions, contact) -> None:
    """Give what an output may ask of a contact its dimension."""
    load, slip = known.of(contact.normal), known.of(contact.slip)
    known.define(friction_force(contact.name).name, load)
    known.define(slip_of(contact.name).name, slip)
    known.define(dissipated_power(contact.name).name, load * slip)
    known.define(stored_energy(contact.name).name, load * slip * known.of_name(TIME.name))


def _agree(known: Dimensions, rate: sp.Expr, z: sp.Symbol) -> None:
    if not rate.is_number:
        wanted = (f"the rate of {z.name}", known.of_name(z.name) / known.of_name(TIME.name))
        known.equal((str(rate), known.of(rate)), wanted)


@cache
def _registry():
    import pint

    return pint.UnitRegistry(cache_folder=None)


@cache
def _parsed(text: str) -> Dimension:
    if text.strip() in _NUMBER:
        return PLAIN
    rest = _POWER.sub("", text)  # powers of powers would take for ever
    if not _WRITTEN.fullmatch(text) or "**" in rest or "^" in rest:
        raise ValueError(text)
    unit = _registry().parse_units(text.replace("⋅", "·"))
    if _registry().Quantity(0.0, unit).to_base_units().magnitude:  # degrees Celsius have their zero elsewhere
        raise ValueError(text)
    found = _registry().Quantity(1.0, unit).to_base_units()
    powers = {k: Fraction(v).limit_denominator(100) for k, v in found.dimensionality.items() if v}
    return Dimension(powers, math.log(float(found.magnitude)))


def _read(text: str, place: str = "") -> Dimension:
    try:
        with SYMBOLIC:
            return _parsed(text)
    except Exception:  # pint raises errors of many kinds on what is no unit
        raise SceneError(
            f"{place}: {shorten(text, 40)!r} is not a unit; write N/m, kg, m/s, rad/s, or 1 for a plain number"
        ) from None


def _in_base_units(found: Dimension) -> str:
    """Return a dimension in m, kg, s, with its factor."""
    order = [k for k in _BASE if k in found.base] + sorted(k for k in found.base if k not in _BASE)
    parts = [(k, found.base[k]) for k in order]
    above = " ".join(_power(_BASE.get(k, k.strip("[]")), v) for k, v in parts if v > 0)
    below = " ".join(_power(_BASE.get(k, k.strip("[]")), -v) for k, v in parts if v < 0)
    text = (above or "1") + (f"/({below})" if " " in below else f"/{below}" if below else "")
    size = factor(found)
    return text if abs(size - 1) < 1e-9 else f"{size:.6g} {text}"


def _power(unit: str, power: Fraction) -> str:
    return unit if power == 1 else unit + (superscript(int(power)) if power.denominator == 1 else f"^({power})")


def output_unit(units: Units, output) -> str:
    """Return the unit of an output of an expression or of a time; "" for others."""
    if isinstance(output, StopTime):
        return units.of(TIME)
    if not isinstance(output, OutputOfExpression):
        return ""
    return units.of(output.expr * TIME if isinstance(output, Integral) else output.expr)
