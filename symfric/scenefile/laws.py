"""Friction laws of a scene file, by their names and signatures."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from symfric.errors import SceneError
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.symbols import SPEED, nearest, shorten
from symfric.scenefile.arguments import call_at, check_arguments, exact, finite_value, functions_returning
from symfric.scenefile.contact_tables import FrictionTable
from symfric.scenefile.expressions import parse_expression
from symfric.scenefile.schema import Document


@dataclass(frozen=True)
class LawSpec:
    """A friction law as written in the file, for display.

    Attributes
    ----------
    contact, law : str
    coefficients : dict
        Argument of the law to a number, the text of an expression, or a list of them.
    """

    contact: str
    law: str
    coefficients: dict[str, Any]


def friction_laws() -> dict[str, Callable[..., Law]]:
    """Return the friction laws by name."""
    return functions_returning(laws, Law)


def law_of(friction: FrictionTable, place: str, names: Mapping[str, sp.Symbol], values: Mapping[str, float]) -> Law:
    """Return the law of one contact; `names` are the parameters available to it."""
    known = friction_laws()
    if friction.law is None:
        raise SceneError(f"{place}.law is missing; add it")
    if friction.law not in known:
        raise SceneError(f"{place}.law: no law {shorten(friction.law, 40)!r}{nearest(friction.law, known)}")
    function, given = known[friction.law], friction.__pydantic_extra__
    check_arguments(f"[{place}]", function, given)

    def read(value: Any, where: str, own: Mapping[str, sp.Expr]) -> Any:
        if isinstance(value, list):
            return [read(v, f"{where}[{i}]", own) for i, v in enumerate(value)]
        if not isinstance(value, str):
            return exact(value)
        result = parse_expression(value, own, where)
        if not result.free_symbols:
            raise SceneError(f"{where} is the string {shorten(value, 30)!r}; write the number without quotes")
        return result

    coefficients = {}
    for key, value in given.items():
        own = {**names, SPEED.name: SPEED} if key == "kinetic" else names
        coefficients[key] = read(value, f"{place}.{key}", own)
    law = call_at(f"[{place}]", function, coefficients)
    numbers = {names[n]: v for n, v in values.items() if n in names}
    for what, e in (("static coefficient", law.stick), ("kinetic coefficient", law.kinetic)):
        if law.free_symbols <= set(numbers):
            finite_value(e, {**numbers, SPEED: 0.0}, f"the {what} of [{place}]")
    return law


def spec_of(friction: FrictionTable, contact: str) -> LawSpec:
    """Return the law of a contact as it is written."""
    return LawSpec(contact, friction.law, dict(friction.__pydantic_extra__))


def contact_place(document: Document, i: int) -> str:
    """Return the place of the i-th contact in the file, for messages."""
    if len(document.friction) == 1:
        return "friction"
    return f"friction.{shorten(document.friction[i].name or i + 1, 30)}"


def contact_name(document: Document, i: int) -> str:
    """Return the name of the i-th contact."""
    return document.friction[i].name or ("contact" if len(document.friction) == 1 else f"contact {i + 1}")
