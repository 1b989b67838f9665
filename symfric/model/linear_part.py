"""The linear part of a system as numbers: matrices, and rows whose values expressions may contain by name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import sympy as sp

from symfric.errors import SceneError

if TYPE_CHECKING:  # slow to import, and few scenes have matrices
    import scipy.sparse as sps


@dataclass(frozen=True, eq=False)
class Row:
    """A combination of the coordinates or of the velocities.

    Attributes
    ----------
    of : {"q", "u"}
    weights : ndarray, shape (n,)
    """

    of: Literal["q", "u"]
    weights: np.ndarray


@dataclass(frozen=True, eq=False)
class LinearPart:
    """Terms that matrices add to a system, ``(mass + M) u' = force - C u - K q - sum_k s_k A_k q + sum_j f_j r_j``.

    The matrices never become SymPy entries.

    Attributes
    ----------
    M, K : sparse, shape (n, n)
    C : sparse, shape (n, n), or None
    scaled : tuple of (Expr, sparse)
        Factors s_k, expressions of parameters, and what they multiply.
    rows : dict of Symbol to Row
        Combinations of the states; expressions may contain the symbols.
    loads : tuple of (Expr, ndarray)
        Forces f_j and the rows r_j along which they act, (n,).
    """

    M: "sps.csr_array"
    K: "sps.csr_array"
    C: "sps.csr_array | None" = None
    scaled: "tuple[tuple[sp.Expr, sps.csr_array], ...]" = ()
    rows: Mapping[sp.Symbol, Row] = field(default_factory=dict)
    loads: tuple[tuple[sp.Expr, np.ndarray], ...] = ()

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression in it."""
        return (*(e for e, _ in self.scaled), *(e for e, _ in self.loads))

    @property
    def arrays(self) -> list[np.ndarray]:
        """Every number in it, for a fingerprint."""
        matrices = [self.M, self.K, *([] if self.C is None else [self.C]), *(A for _, A in self.scaled)]
        parts = [a for A in matrices for a in (A.data, A.indices, A.indptr)]
        return [*parts, *(r.weights for r in self.rows.values()), *(r for _, r in self.loads)]

    def values(self, q: Sequence[float] | np.ndarray, u: Sequence[float] | np.ndarray) -> dict[sp.Symbol, float]:
        """Return what the rows are for given coordinates and velocities."""
        return {s: float(r.weights @ np.asarray(q if r.of == "q" else u, float)) for s, r in self.rows.items()}


def slopes_of(slip: sp.Expr, u: Sequence[sp.Symbol], part: LinearPart | None) -> list[sp.Expr] | np.ndarray:
    """Return the derivatives of a slip by the velocities: numbers if all are, an array; otherwise expressions.

    Raises
    ------
    SceneError
        If a row of many velocities enters with a factor that is no number.
    """
    rows = {} if part is None else {s: r for s, r in part.rows.items() if s in slip.free_symbols and r.of == "u"}
    own = [slip.diff(e) if e in slip.free_symbols else sp.S.Zero for e in u]
    if not rows:
        return np.array(own, dtype=float) if part is not None and all(e.is_number for e in own) else own
    factors = {s: slip.diff(s) for s in rows}
    if not all(e.is_number for e in (*own, *factors.values())):
        raise SceneError(f"the slip {slip} is not a row of velocities with a number as its factor")
    total = np.array(own, dtype=float)
    for s, r in rows.items():
        total = total + float(factors[s]) * r.weights
    return total


def with_replaced(part: LinearPart | None, change: Mapping[sp.Basic, sp.Basic]) -> LinearPart | None:
    """Return a linear part with its expressions rewritten."""
    if part is None:
        return None
    scaled = tuple((e.xreplace(dict(change)), A) for e, A in part.scaled)
    return replace(part, scaled=scaled, loads=tuple((e.xreplace(dict(change)), r) for e, r in part.loads))
