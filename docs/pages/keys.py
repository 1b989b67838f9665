"""One table of the keys of a scene file, from the schema that reads it."""

import dataclasses
import inspect
import json
import types
import typing
from pathlib import Path

from numpydoc.docscrape import NumpyDocString
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from docs.files import put
from symfric import fields
from symfric.design import plan
from symfric.design.plans import PLANS
from symfric.scenefile import contact_tables, held, schema, structure_tables

WORDS = {  # annotated types: what one writes
    fields.Number: "number",
    fields.Positive: "number > 0",
    fields.Term: "number or expression",
    fields.Slip: "number, expression, or list of two expressions",
    fields.Coefficient: "number, expression or list",
    fields.Factors: "list of two numbers or expressions",
    fields.Option: "number, text, true or false, list",
    fields.Text: "text",
    fields.Unit: "text",
    fields.Names: "name or list of names",
    fields.Terms: "expression or list of them",
    fields.Axis: "list, or {start, stop, count}",
    fields.Mass: "number, diagonal or rows",
    fields.Range: "[lower, upper]",
    plan.Span: "[lower, upper]",
    plan.SignedSpan: "[lower, upper]",
    contact_tables.Row: "expression linear in names, or table of name = weight",
    structure_tables.Points: "name, list of names, or table of name = row",
    structure_tables.Matrices: "path, or table `[scene.structure]`",
}
TABLES = ("scene", "friction", "held", "reset", "sweep", "flutter", "design", "identify")  # with places of their own
PLACES = (
    ("", schema.Document),
    ("scene", schema.ReadyScene),
    ("scene", schema.OwnScene),
    ("scene", structure_tables.StructureScene),
    ("scene.structure", structure_tables.Source),
    ("friction", contact_tables.FrictionTable),
    ("friction", contact_tables.OwnFriction),
    ("friction", contact_tables.RowFriction),
    ("held.NAME", held.HeldTable),
    ("reset", held.ResetTable),
    ("sweep", schema.Sweep),
    ("flutter", structure_tables.FlutterTable),
    ("identify", schema.Identify),
)


def write(folder: Path) -> None:
    """Write the page."""
    lines = ["| key | value | meaning |", "|---|---|---|"]
    for place, section in PLACES:
        lines += [row for row in _rows(place, section) if row not in lines]
    for design in PLANS:
        lines += _rows(f"design.{design.kind}", design)
    text = (folder / "toml.in.md").read_text(encoding="utf-8")
    put(folder / "toml.md", text.replace("<!-- the table -->", "\n".join(lines)))


def meanings(section: type) -> dict[str, str]:
    """Return what the docstring of a section says of each key."""
    entries = NumpyDocString(inspect.cleandoc(section.__doc__ or ""))["Attributes"]
    return {name: " ".join(e.desc) for e in entries for name in e.name.split(", ")}


def _fields(section: type) -> dict[str, FieldInfo]:
    """Return the keys of a section, or of a dataclass whose fields are annotated like one."""
    if issubclass(section, BaseModel):
        return section.model_fields
    hints, make = typing.get_type_hints(section, include_extras=True), FieldInfo.from_annotated_attribute
    needed = {f.name: f.default is dataclasses.MISSING for f in dataclasses.fields(section)}
    return {
        n: FieldInfo.from_annotation(hints[n]) if e else make(hints[n], getattr(section, n)) for n, e in needed.items()
    }


def _rows(place: str, section: type) -> list[str]:
    said, hints = meanings(section), typing.get_type_hints(section, include_extras=True)
    rows = []
    for name, field in _fields(section).items():
        inner, key = _section(field.annotation), field.alias or name
        path = f"{place}.{key}" if place else key
        if name not in said:
            raise KeyError(f"{section.__name__}.{name} has no meaning; add it to the Attributes of its class")
        if not (place == "" and (inner or name in TABLES)):
            kind = f"table `[{path}]`" if inner else _kind(hints[name])
            rows.append(f"| `{path}` | {kind}{_default(field)} | {said[name]} |")
            if inner and name not in ("motion", "structure"):
                rows += _rows(path, inner)
    return rows


def _section(annotation) -> type | None:
    """Return the section that a key holds, if it is a table with fixed keys."""
    for part in (annotation, *typing.get_args(annotation)):
        if isinstance(part, type) and (issubclass(part, BaseModel) or dataclasses.is_dataclass(part)):
            return part
    return None


def _kind(hint) -> str:
    """Return the words for a type, without None."""
    if hint in WORDS:
        return WORDS[hint]
    origin, parts = typing.get_origin(hint), [p for p in typing.get_args(hint) if p is not type(None)]
    if origin is dict:
        return f"table of name = {_kind(parts[1])}"
    if origin is typing.Literal:
        return " or ".join(f"`{json.dumps(v)}`" for v in parts)
    if origin in (types.UnionType, typing.Union, typing.Annotated):
        return _kind(parts[0])
    return {list: "list", bool: "true or false", int: "whole number"}.get(origin or hint, "table")


def _default(field) -> str:
    if field.is_required():
        return "; needed"
    value = field.default
    if value is None or value is PydanticUndefined or value == "" or isinstance(value, BaseModel):
        return ""
    return f"; `{json.dumps(value)}` unless given"
