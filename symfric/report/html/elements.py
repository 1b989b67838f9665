"""Elements of a page: headings, paragraphs, notes, tables, figures."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.util import find_spec
from typing import Any

from markupsafe import Markup

from symfric.templates import template


@dataclass(frozen=True)
class Picture:
    """A figure of a page.

    Attributes
    ----------
    uri : str
        Data URI of an SVG.
    alt, caption : str
    """

    uri: str
    alt: str
    caption: str


@cache
def _macros() -> Any:
    return template("parts.html").module


def heading(text: str, name: str) -> Markup:
    """Return the heading of a section, and what links to it are called."""
    return Markup(_macros().heading(text, name))


def subheading(text: str) -> Markup:
    """Return the heading of a part of a section."""
    return Markup("<h3>{}</h3>").format(text)


def paragraph(text: str) -> Markup:
    """Return a paragraph."""
    return Markup("<p>{}</p>").format(text)


def note(text: str) -> Markup:
    """Return a paragraph in small letters."""
    return Markup(_macros().note(text))


def bullets(lines: Iterable[str]) -> Markup:
    """Return a list."""
    return Markup("<ul>{}</ul>").format(Markup("").join(Markup("<li>{}</li>").format(line) for line in lines))


def can_draw() -> bool:
    """Whether Matplotlib is installed, without which pages hold words and tables only."""
    return find_spec("matplotlib") is not None


def gallery(draw: Callable[[], Iterable[Picture | None]], said: Callable[[str], Markup] | None = None) -> Markup:
    """Return figures side by side, their captions as they are said; nothing without figures or Matplotlib."""
    pictures = [p for p in draw() if p is not None] if can_draw() else []
    shown = [p if said is None else replace(p, caption=said(p.caption)) for p in pictures]
    return Markup(_macros().gallery(shown))


def table(head: Sequence[str], rows: Sequence[Sequence[str]], numeric: Collection[int] = ()) -> Markup:
    """Return a table; `numeric` are the numbers of the columns that are set to the right.

    A column of units that is empty throughout is left out.
    """
    kept = [k for k, name in enumerate(head) if name != "unit" or any(row[k] for row in rows)]
    numeric = [i for i, k in enumerate(kept) if k in numeric]
    return Markup(_macros().table([head[k] for k in kept], [[row[k] for k in kept] for row in rows], numeric))


def matrix(name: str, rows: Sequence[Sequence[Markup]]) -> Markup:
    """Return a displayed matrix with its name."""
    return Markup(_macros().matrix(name, rows))
