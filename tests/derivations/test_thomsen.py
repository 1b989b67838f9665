"""Every numbered equation of Thomsen's paper has a row of the ledger."""

import re
from pathlib import Path

import pytest

from derivations.sources import ledger_of

SOURCE = Path(__file__).parents[3] / "shared" / "sources" / "thomsen_fast_vibrations.txt"
TAG = re.compile(r"\\tag\{(\d+)\}|\\quad \((\d+)\)\s*$")  # \quad (9) where the transcription has no tag


def numbered(text):
    """Numbers of the displayed formulas."""
    formulas = re.findall(r"\$\$(.*?)\$\$", text, re.DOTALL)
    return {int(tag or plain) for formula in formulas for tag, plain in TAG.findall(formula)}


def test_every_numbered_equation_has_a_row():
    if not SOURCE.exists():
        pytest.skip(f"the source is not beside the project: {SOURCE}")
    numbers = numbered(SOURCE.read_text())
    assert numbers == set(range(1, 62))
    rows = {int(m[1]) for e in ledger_of("thomsen").entries if (m := re.match(r"\((\d+)\)", e.equation))}
    assert rows == numbers
