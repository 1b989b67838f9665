"""Derivations of every equation of the sources; ``python -m derivations`` prints the ledger."""

import sys
from pathlib import Path

sys.path.insert(
    0, str(Path(__file__).with_name("evidence"))
)  # a package of its own, of which some entries take numbers
