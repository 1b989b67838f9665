"""One page of reproduced figures and tables, with the claims of the sources and the results."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from jinja2 import ChoiceLoader, PackageLoader, Template

from symfric.report.html.versions import used
from symfric.templates import template
from symfric_evidence.sources.registry import SOURCES, Entry, Made, title
from symfric_evidence.sources.reproduction import NOT_MADE

VERDICTS = {True: "true", False: "false", None: "true only if"}


def gallery(made: Mapping[str, tuple[Entry[Any], Made, float]], versions: Mapping[str, str]) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    made : mapping of name to (Entry, Made, seconds)
        The figures are in the folder of the page, as ``name.png``.
    versions : mapping of str to str
    """
    sources = [_source(s, made) for s in SOURCES if any(name.startswith(f"{s}-") for name in made)]
    return _template().render(
        title="Reproduction",
        sources=sources,
        counts=_counts(sources),
        seconds=sum(time for _, _, time in made.values()),
        used=used(versions),
    )


@cache
def _template() -> Template:
    """Return the template, which extends the page of the package."""
    known = template("page.html").environment
    assert known.loader is not None
    both = ChoiceLoader([PackageLoader("symfric_evidence"), known.loader])
    return known.overlay(loader=both).get_template("gallery.html")


def _source(source: str, made: Mapping[str, tuple[Entry[Any], Made, float]]) -> dict[str, Any]:
    """Return the template data of one source."""
    return {
        "name": source,
        "title": SOURCES[source],
        "entries": [_entry(n, *reproduced) for n, reproduced in made.items() if n.startswith(f"{source}-")],
        "left_out": [(n, why) for n, why in NOT_MADE.items() if n.startswith(source)],
    }


def _counts(sources: list[dict[str, Any]]) -> list[list[Any]]:
    """Return how many claims of each source have each verdict, and of all."""
    rows = []
    for source in sources:
        verdicts = [v for entry in source["entries"] for _, v, _ in entry["findings"]]
        rows.append([source["title"], *(verdicts.count(v) for v in VERDICTS.values()), len(verdicts)])
    return [*rows, ["all", *(sum(column) for column in list(zip(*rows, strict=True))[1:])]] if rows else []


def _entry(name: str, entry: Entry[Any], made: Made, seconds: float) -> dict[str, Any]:
    return {
        "name": name,
        "title": title(name),
        "caption": entry.caption,
        "made": made,
        "findings": [[f.claim, VERDICTS[f.holds], f.found] for f in made.findings],
        "seconds": seconds,
    }
