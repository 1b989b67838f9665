"""A study as data: plain Python for JSON, and the tables beside it."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from symfric.report.study.section import StudyResult


def plain(value: Any) -> Any:
    """Convert to JSON types; NaN and infinity become None."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    return str(value)


def to_dict(study: StudyResult) -> dict[str, Any]:
    """Return a study as plain data."""
    tree: dict[str, Any] = {"file": study.file.path, "title": study.file.title}
    for section in study.sections:
        *outer, name = section.key.split(".")
        place = tree[outer[0]] if outer else tree
        if name and place is not None:
            value = study[section].value
            place[name] = section.without if value is None else section.data(study, value)
    rest = {"skipped": study.skipped(), "versions": dict(study.versions), "seconds": study.seconds}
    data: dict[str, Any] = plain({**tree, **rest})
    return data


def json_text(data: Mapping[str, Any]) -> str:
    """Return plain data as JSON."""
    return json.dumps(data, indent=2, allow_nan=False)


def data_files(study: StudyResult) -> dict[str, str]:
    """Return the files beside a page, by their names."""
    return {**study.tables(), "study.json": json_text(to_dict(study))}
