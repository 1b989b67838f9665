"""Reproduction of Younes and Ashour: figures 3-10 as data, its word claims tested."""

from typing import Any

from symfric_evidence.sources.panels import panels_entry
from symfric_evidence.sources.registry import Entry, Finding, Inputs
from symfric_evidence.sources.younes_ashour import decay_figures
from symfric_evidence.sources.younes_ashour.claims import Claim, Reading, claims, claims_table

CLAIMS = "What the text claims, and which readings of it hold."


def _table(_inputs: Inputs) -> list[dict[str, Any]]:
    return claims_table()


def _text(rows: list[dict[str, Any]]) -> str:
    lines = [f"{r['where']}: {r['claim']}\n    {r['verdict']}; {r['reading']}: {r['holds']}" for r in rows]
    return "\n".join(lines) + "\n"


def _findings(rows: list[dict[str, Any]]) -> tuple[Finding, ...]:
    return tuple(Finding(f"{r['where']}: {r['claim']}", _found(r), _holds(r)) for r in rows)


def _holds(row: dict[str, Any]) -> bool | None:
    """Return whether a claim holds; the model may agree with measured records, but it cannot refute them."""
    return None if row["measured"] and not row["holds"] else row["holds"]


def _found(row: dict[str, Any]) -> str:
    """Return the reading and its numbers; of a claim about records, what the model says."""
    words = f"{row['reading']}: " + (", ".join(f"{k} {v:.4g}" for k, v in row["evidence"].items()) or "-")
    if not row["measured"] or row["holds"] is None:
        return words
    return f"about measured records, {'so' if row['holds'] else 'not so'} in the model; {words}"


FIGURES = {
    **{name: panels_entry(make) for name, make in decay_figures.FIGURES.items()},
    "younes-claims": Entry(CLAIMS, _table, text=_text, plain=list, findings=_findings),
}

__all__ = ["FIGURES", "Claim", "Reading", "claims", "claims_table"]
