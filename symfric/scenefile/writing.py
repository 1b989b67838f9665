"""Write scene files: the tables of a file with other numbers, and with the numbers of its friction laws as values."""

import copy
import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from symfric.errors import SceneError
from symfric.scenefile.read import SceneFile, read_scene_text

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_PLACES = ("name", "law", "slip", "normal", "profile", "gap")  # keys of a contact that are no coefficients


def tables_of(file: SceneFile) -> dict[str, Any] | None:
    """Return the tables of a scene file as they are written; None if it was not read from a file."""
    path = Path(file.path)
    return tomllib.loads(path.read_text(encoding="utf-8-sig")) if path.is_file() else None


def read_tables(tables: Mapping[str, Any], path: str) -> SceneFile:
    """Read a scene file from its tables; it refers to records as a file at `path` does."""
    return read_scene_text(written(tables), path, Path(path).parent)


def with_friction_values(tables: Mapping[str, Any], path: str) -> dict[str, Any]:
    """Return the tables with each number of a friction law as an entry of ``[values]``, where the file allows it."""
    whole = copy.deepcopy(dict(tables))
    for contact, key in _numbers_of_laws(whole):
        _open(whole, contact, key)
    if _readable(whole, path):
        return whole
    changed = copy.deepcopy(dict(tables))
    for contact, key in _numbers_of_laws(changed):  # some number must stay one: find which
        before = copy.deepcopy((changed.get("values", {}), contact[key]))
        _open(changed, contact, key)
        if not _readable(changed, path):
            changed["values"], contact[key] = before
    return changed


def with_numbers(
    tables: Mapping[str, Any], values: Mapping[str, float], initial: Mapping[str, float]
) -> dict[str, Any]:
    """Return the tables with other values and initial values."""
    changed = copy.deepcopy(dict(tables))
    scene = changed.setdefault("scene", {})
    for name, value in values.items():
        (scene if name in scene else changed.setdefault("values", {}))[name] = value
    if initial:
        scene["initial"] = {**scene.get("initial", {}), **initial}
    return changed


def _contacts(tables: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the tables of the contacts: ``[[contact]]``, ``[friction]`` or ``[friction.name]``."""
    if "contact" in tables:
        return list(tables["contact"])
    friction = tables.get("friction", {})
    alone = "law" in friction or "gap" in friction
    return [friction] if alone else [c for c in friction.values() if isinstance(c, dict)]


def _numbers_of_laws(tables: Mapping[str, Any]) -> list[tuple[dict[str, Any], str]]:
    """Return the contacts and keys of the coefficients that are numbers."""
    return [(c, key) for c in _contacts(tables) for key, v in c.items() if key not in _PLACES and _is_number(v)]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _open(tables: dict[str, Any], contact: dict[str, Any], key: str) -> None:
    """Make a coefficient a value, under its own name if that is free."""
    scene, values = tables.get("scene", {}), tables.setdefault("values", {})
    text = json.dumps([scene, values, *(tables.get(key, {}) for key in ("outputs", "held", "reset"))])
    name, count = key, 1
    while re.search(rf"\b{re.escape(name)}\b", text):
        count += 1
        name = f"{key}_{count}"
    values[name], contact[key] = contact[key], name


def _readable(tables: Mapping[str, Any], path: str) -> bool:
    try:
        read_tables(tables, path)
    except SceneError:
        return False
    return True


def written(tables: Mapping[str, Any]) -> str:
    """Return tables as TOML; comments are not kept.

    Examples
    --------
    >>> print(written({"title": "A", "scene": {"mass": 1.0}}))
    title = "A"
    <BLANKLINE>
    [scene]
    mass = 1.0
    """
    return "\n".join(_section(tables, "")).strip("\n")


def _section(table: Mapping[str, Any], place: str) -> Iterator[str]:
    plain = {k: v for k, v in table.items() if not isinstance(v, Mapping) and not _is_array_of_tables(v)}
    for key, value in plain.items():
        yield f"{_key(key)} = {_value(value)}"
    for key, value in table.items():
        inner = f"{place}.{_key(key)}" if place else _key(key)
        if isinstance(value, Mapping):
            yield from ("", f"[{inner}]", *_section(value, inner))
        elif _is_array_of_tables(value):
            for part in value:
                yield from ("", f"[[{inner}]]", *_section(part, inner))


def _is_array_of_tables(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else json.dumps(key, ensure_ascii=False)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, list):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    return json.dumps(str(value), ensure_ascii=False)
