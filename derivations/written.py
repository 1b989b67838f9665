"""The ledger as text, as Markdown, and as plain values for JSON."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict

from derivations.ledger import Row, Verdict
from derivations.revised import revised
from derivations.sources import ledger_of

Found = dict[str, list[Row]]
LONGEST = 160  # characters of a formula that are shown; JSON and the files of the sources have all of them

INTRODUCTION = """# The ledger

<!-- Written by `python -m derivations --markdown > derivations/README.md`; do not edit. -->

Every numbered equation of the five documents that symfric implements, and every closed form of `symfric.theory`,
derived from first principles with SymPy. Each source is one file or folder here, to be read from top to bottom.

`python -m derivations` carries out all checks and prints this ledger; `python -m derivations guida --json` one source
of it, with the formulas in full. Exit status 1 means that a row does not hold.

| verdict | meaning |
|---|---|
| verified | the equation as printed; what a derivation without it leaves of it is zero |
| corrected | wrong as printed: the corrected form leaves zero, and the printed form does not |
| definition | a definition or an assumption of the model: there is nothing to prove |
| unverifiable | cannot be checked, and why |

A row that rests on *numbers* is no identity: it says which numbers stand in the place of a proof. The tests change
every claim, by a sign, a factor or an exponent, and demand that its check then fails.
"""


def counts(rows: list[Row]) -> dict[str, int]:
    """Return how many rows there are of each verdict, and how many of all rest on numbers."""
    seen = Counter(row.verdict for row in rows)
    return {**{str(v): seen[v] for v in Verdict}, "numbers": sum(bool(row.numbers) for row in rows)}


def to_dict(found: Found) -> dict:
    """Return plain values."""
    return {
        "sound": all(row.sound for rows in found.values() for row in rows),
        "sources": [
            {
                "source": source,
                "document": ledger_of(source).document,
                "counts": counts(rows),
                "rows": [asdict(row) for row in rows],
            }
            for source, rows in found.items()
        ],
    }


def text(found: Found) -> str:
    """Return the ledger for reading on a terminal."""
    lines = []
    for source, rows in found.items():
        lines += [f"{source}: {ledger_of(source).document}", ""]
        for row in rows:
            lines += [f"{row.equation}  {'' if row.sound else 'FAILS, '}{row.verdict}: {row.title}"]
            lines += [f"    {name:9} {value}" for name, value in _details(row)]
        lines += ["", f"{source}: {_summary(rows)}", ""]
    everything = [row for rows in found.values() for row in rows]
    failed = [row for row in everything if not row.sound]
    lines += [f"{row.source} {row.equation} does not hold: {_shown(_failure(row))}" for row in failed]
    lines += [f"{len(everything)} rows: {_summary(everything)}; {len(failed) or 'none'} unsound"]
    return "\n".join(lines)


def _details(row: Row) -> Iterator[tuple[str, str]]:
    if row.printed:
        yield "printed", _shown(row.printed)
    if row.right:
        yield "right", _shown(row.right)
    if row.residual:
        yield "residual", _residual(row)
    if row.note:
        yield "why" if row.verdict in (Verdict.CORRECTED, Verdict.UNVERIFIABLE) else "note", row.note


def _residual(row: Row) -> str:
    return _shown(row.residual) + (f" (numbers: {row.numbers})" if row.numbers else "")


def _failure(row: Row) -> str:
    return "the printed form passes the check too" if row.residual == "0" else f"residual {row.residual}"


def _summary(rows: list[Row]) -> str:
    return ", ".join(f"{n} {'on ' if name == 'numbers' else ''}{name}" for name, n in counts(rows).items())


def markdown(found: Found) -> str:
    """Return the ledger as the README of ``derivations``."""
    parts = [INTRODUCTION, _totals(found)]
    for source, rows in found.items():
        parts += [f"## {source}\n\n{ledger_of(source).document}\n\n" + "".join(map(_line, _table(rows)))]
    head = ("source", "equation", "statement", "before", "now", "why")
    table = [head, ("---",) * len(head), *(tuple(map(_safe, row)) for row in revised())]
    parts += ["## Verdicts that were revised\n\n" + "".join(map(_line, table))]
    return "\n".join(parts)


def revisions() -> str:
    """Return the revised verdicts for reading on a terminal."""
    lines = []
    for source, equation, statement, before, now, why in revised():
        lines += [f"{source} {equation}: {statement}", f"    before    {before}", f"    now       {now}: {why}"]
    return "\n".join(lines)


def _totals(found: Found) -> str:
    head = ("source", *map(str, Verdict), "of all on numbers")
    lines = [(f"[{source}](#{source})", *map(str, counts(rows).values())) for source, rows in found.items()]
    together = counts([row for rows in found.values() for row in rows]).values()
    return "".join(map(_line, [head, ("---", *["---:"] * (len(head) - 1)), *lines, ("all", *map(str, together))]))


def _table(rows: list[Row]) -> Iterator[tuple[str, ...]]:
    yield "equation", "says", "verdict", "right", "printed, and why it is wrong; notes", "residual"
    yield ("---",) * 6
    for row in rows:
        printed = _safe(row.printed) if row.printed.startswith('"') else _code(row.printed)
        yield (
            _safe(row.equation),
            _safe(row.title),
            row.verdict if row.sound else f"**FAILS**, {row.verdict}",
            _code(row.right),
            "; ".join(filter(None, (printed, _safe(row.note)))),
            _safe(_residual(row)),
        )


def _line(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |\n"


def _code(formula: str) -> str:
    return f"`{_shown(formula)}`".replace("|", "\\|") if formula else ""


def _safe(words: str) -> str:
    return words.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")


def _shown(formula: str) -> str:
    return formula if len(formula) <= LONGEST else f"{formula[:LONGEST].rstrip()} ..."
