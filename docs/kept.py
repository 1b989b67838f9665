"""What pages show is made anew where its own text, or a source that it is made with, has changed since."""

import hashlib
import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

from docs.files import put

ROOT = Path(__file__).parents[1]
PROGRAM = ("symfric", "derivations/evidence/symfric_evidence")
DATA = ("examples",)  # that pages read
_ENDINGS = {".py", ".toml", ".csv", ".npz", ".html", ".css", ".js", ".xz"}


@cache
def sources_key(*folders: str, scripts: bool = True) -> str:
    """Return a key of the package and of what lies in further folders, there with or without the scripts."""
    found = hashlib.sha256()
    for folder in (*PROGRAM, *folders):
        for path in sorted((ROOT / folder).rglob("*")):
            wanted = scripts or folder in PROGRAM or path.suffix != ".py"
            if wanted and path.suffix in _ENDINGS and path.is_file():
                found.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    return found.hexdigest()[:16]


def kept(place: Path, text: str, make: Callable[[], dict], *, data: bool = False) -> dict:
    """Return what was made before from the same text and program, else make it and keep it.

    Parameters
    ----------
    place : Path
        Of the JSON file that keeps it.
    text : str
        Of which it is made, besides the program: that of its maker among it.
    make : callable
        Returns plain values.
    data : bool
        Whether it may read files that lie beside the examples.
    """
    sources = sources_key(*DATA, scripts=False) if data else sources_key()
    key = f"{sources} {hashlib.sha256(text.encode()).hexdigest()}"
    if place.is_file() and not os.environ.get("SYMFRIC_DOCS_FRESH"):
        found = json.loads(place.read_text(encoding="utf-8"))
        if found.get("key") == key:
            return found["made"]
    made = make()
    put(place, json.dumps({"key": key, "made": made}))
    return made
