"""Letters for names: as mathematics writes them."""

import sympy as sp

_WRITTEN = {"lam": "lambda"}  # a reserved word of Python, so that no argument has the name


def letter(symbol: sp.Symbol) -> sp.Symbol:
    """Return the symbol whose name SymPy's printers set as the letter that is meant."""
    return sp.Symbol(_WRITTEN[symbol.name]) if symbol.name in _WRITTEN else symbol
