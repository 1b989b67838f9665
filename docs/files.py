"""Write a made page only where it changed, so that Sphinx reads again what is new."""

from pathlib import Path


def put(path: Path, text: str) -> None:
    """Write a text file unless it has this text already."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
