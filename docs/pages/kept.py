"""What pages show is made anew where its own text, or any source of the package, has changed since."""

import hashlib
import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

from docs.pages.files import put

ROOT = Path(__file__).parents[2]
_FOLDERS = "symfric", "derivations/evidence/symfric_evidence", "examples", "docs/pages"
_ENDINGS = {".py", ".toml", ".csv", ".npz", ".html", ".css", ".js", ".xz"}


@cache
def sources_key() -> str:
    """Return a key of everything that what pages show may depend on."""
    found = hashlib.sha256()
    for folder in _FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in _ENDINGS and path.is_file():
                found.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    return found.hexdigest()[:16]


def kept(place: Path, text: str, make: Callable[[], dict]) -> dict:
    """Return what was made before from the same text and sources, else make it and keep it.

    Parameters
    ----------
    place : Path
        Of the JSON file that keeps it.
    text : str
        Of which it is made, besides the sources.
    make : callable
        Returns plain values.
    """
    key = f"{sources_key()} {hashlib.sha256(text.encode()).hexdigest()}"
    if place.is_file() and not os.environ.get("SYMFRIC_DOCS_FRESH"):
        found = json.loads(place.read_text(encoding="utf-8"))
        if found.get("key") == key:
            return found["made"]
    made = make()
    put(place, json.dumps({"key": key, "made": made}))
    return made
