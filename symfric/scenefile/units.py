"""Units of a scene file: the laws as written, whose coefficients that are numbers have units of their own."""

from collections.abc import Iterable, Mapping

import sympy as sp

from symfric.model.scene import Scene
from symfric.model.units import LetteredLaw, Units, coefficient_of, output_unit, units_of
from symfric.scenefile.expressions import parse_expression
from symfric.scenefile.laws import LawSpec, friction_laws

__all__ = ["Units", "output_unit", "units_in_file"]


def units_in_file(scene: Scene, given: Mapping[str, str], specs: Iterable[LawSpec]) -> Units:
    """Return the units of a scene from those of its file, see `symfric.model.units.units_of`."""
    return units_of(scene, given, {spec.contact: law for spec in specs if (law := _lettered(scene, spec)) is not None})


def _lettered(scene: Scene, spec: LawSpec) -> LetteredLaw | None:
    """Return a law with letters; None if its coefficients are lists, or it is written out."""
    contact = next((c for c in scene.contacts if c.name == spec.contact), None)
    listed = any(isinstance(v, list) for v in spec.coefficients.values())
    if contact is None or contact.law.memory or listed or spec.law == "custom":
        return None
    letters = {n: sp.Symbol(coefficient_of(spec.contact, n), positive=True) for n in spec.coefficients}
    names = {s.name: s for s in scene.parameters}
    values = {n: parse_expression(v, names, n) for n, v in spec.coefficients.items() if isinstance(v, str)}
    return LetteredLaw(friction_laws()[spec.law](**letters), letters, values)
