"""The one list of sources, and the checks of their entries, in parallel."""

import importlib
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import as_completed
from dataclasses import replace

from derivations.ledger import Ledger, Row, evaluate, stated
from symfric.solve.case_values import processors
from symfric_evidence.processes import interrupts_ignored, processes

SOURCES = (
    "thomsen",
    "thomsen_beyond",
    "effective_friction",
    "effective_closed",
    "oscillations",
    "methods",
    "handbook",
    "guida",
    "younes_ashour",
    "rolling_isolation",
    "absorber",
    "foundation",
    "waviness",
    "presliding",
    "plane",
    "numbers",
)
CHUNK = 6  # neighbouring entries share intermediate results, so they go to one process


def ledger_of(source: str) -> Ledger:
    """Return what the file or folder `source` of ``derivations`` enters."""
    return importlib.import_module(f"derivations.{source}").LEDGER


def rows_of(source: str, first: int, last: int) -> list[Row]:
    """Carry out the checks of some entries of a source; a check that cannot be carried out leaves its error."""
    rows = []
    for entry in ledger_of(source).entries[first:last]:
        try:
            rows.append(evaluate(entry))
        except Exception as error:  # whatever it is, it concerns this row alone
            rows.append(replace(stated(entry), residual=f"{type(error).__name__}: {error}", sound=False))
    return rows


def checked(sources: Iterable[str], progress: Callable[[str, float], None]) -> dict[str, list[Row]]:
    """Carry out all checks of some sources on all processors.

    Parameters
    ----------
    sources : iterable of str
        From `SOURCES`.
    progress : callable ``(stage, fraction)``

    Notes
    -----
    Checks are closures, which do not travel; so every process imports the sources, and is told source and places.
    """
    sources = tuple(sources)
    chunks = list(_chunks(sources))
    found = {}
    with processes(min(processors(), len(chunks))) as pool:
        with interrupts_ignored():  # the processes start here, and leave an interrupt to this one
            waiting = {pool.submit(rows_of, *chunk): chunk for chunk in chunks}
        for done in as_completed(waiting):
            source, first, last = waiting[done]
            found[source, first] = done.result()
            progress(f"{source}, rows {first + 1} to {last}", len(found) / len(chunks))
    return {s: [row for source, first, _ in chunks if source == s for row in found[source, first]] for s in sources}


def _chunks(sources: Iterable[str]) -> Iterator[tuple[str, int, int]]:
    for source in sources:
        size = len(ledger_of(source).entries)
        yield from ((source, first, min(first + CHUNK, size)) for first in range(0, size, CHUNK))
