"""Check tables of a scene file; errors of pydantic become one line with place and cure."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError

from symfric.errors import SceneError
from symfric.fields import MAX_TABLES, kind_of
from symfric.model.symbols import nearest, shorten
from symfric.motions.table import ONE, PAIR

_Table = TypeVar("_Table")
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")  # of a model, of a dataclass


def checked(kind: type[_Table], data: object, place: str, extra: tuple[str, ...] = ()) -> _Table:
    """Return a table as an object, or raise the first error as one line.

    Parameters
    ----------
    kind : type
        A `Section`, or a dataclass whose fields are annotated as those of a section are.
    data : object
        The table as it was read.
    place : str
        Of the table in the file, for messages.
    extra : tuple of str
        Further keys to propose in the place of an unknown one.
    """
    if isinstance(data, dict) and len(data) > MAX_TABLES:
        raise SceneError(f"{place or 'the file'} has {len(data)} keys; at most {MAX_TABLES} are read")
    try:
        return TypeAdapter(kind).validate_python(data)
    except ValidationError as error:
        findings = error.errors(include_url=False)
        finding = findings[0]
        if finding["type"] == "missing":  # a misspelt key says more than the one that is missing therefore
            finding = next((f for f in findings if f["type"] in _UNKNOWN), finding)
    except RecursionError:
        raise SceneError(f"{place or 'the file'} is nested too deeply") from None
    raise SceneError(_one_line(kind, finding, place, extra)) from None


def _one_line(kind: type, finding: Mapping[str, Any], place: str, extra: tuple[str, ...]) -> str:
    """Return an error of pydantic as place, problem and cure."""
    where, section = place, kind
    path = [step for step in finding["loc"] if step not in (ONE, PAIR)]
    for i, step in enumerate(path):
        if isinstance(step, int):
            where += f"[{step}]"
        else:
            where += ("." if where else "") + shorten(step, 40)
        if i < len(path) - 1:
            section = _inner(section, step)
    last = shorten(path[-1], 40) if path else ""
    match finding["type"]:
        case "extra_forbidden" | "unexpected_keyword_argument":
            known = [*keys_of(section), *extra]
            inside = where.rpartition(".")[0]
            return f"{f'[{inside}]' if inside else 'the file'} has no key {last!r}{nearest(last, known)}"
        case "missing":
            return f"{where} is missing; add it"
        case "value_error":
            return f"{where} {finding['ctx']['error']}"
        case "greater_than":
            return f"{where} is {finding['input']}; it must be positive"
        case "dict_type" | "model_type" | "dataclass_type":
            return f"{where} is {kind_of(finding['input'])}; write a section [{where}]"
        case "literal_error":
            return f"{where} is {shorten(repr(finding['input']), 30)}; it must be {finding['ctx']['expected']}"
        case "string_too_long":
            return f"{where} is longer than {finding['ctx']['max_length']} characters; shorten it"
    given = shorten(repr(finding["input"]), 40)
    return f"{where} is {given}: {finding['msg'][0].lower()}{finding['msg'][1:]}"


def keys_of(table: Any) -> dict[str, Any]:
    """Return the types of the keys of a section or of a dataclass."""
    if issubclass(table, BaseModel):
        return {f.alias or name: f.annotation for name, f in table.model_fields.items()}
    return {f.name: f.type for f in fields(table)}


def _inner(section: type, step: object) -> type:
    """Return the class of the table that a key holds; the section itself if it holds none."""
    kind = keys_of(section).get(step) if isinstance(step, str) else None
    kinds = (kind, *getattr(kind, "__args__", ()))
    return next((k for k in kinds if isinstance(k, type) and (is_dataclass(k) or issubclass(k, BaseModel))), section)
