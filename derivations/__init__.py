"""Derivations of every equation of the sources; ``python -m derivations`` prints the ledger."""
