"""The Routh-Hurwitz criterion, on numbers and on symbols."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.results import Result
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import finite, shortened

MOST_STATES = 4  # limit of the symbolic criterion, whose determinants grow very long


@dataclass(frozen=True, repr=False)
class Hurwitz(Result):
    """Result of the Routh-Hurwitz criterion for ``c_0 s^n + c_1 s^(n-1) + ... + c_n``.

    Attributes
    ----------
    coefficients : tuple of float, length n + 1
        Highest power first, c_0 > 0.
    determinants : tuple of float, length n
        Leading principal minors of the Hurwitz matrix.
    stable : bool
        Whether all are positive: every root has a negative real part.
    """

    coefficients: tuple[float, ...]
    determinants: tuple[float, ...]
    stable: bool

    def __repr__(self) -> str:
        minors = ", ".join(f"{d:.4g}" for d in self.determinants)
        return f"Hurwitz({'stable' if self.stable else 'not stable'}; determinants {minors})"


@alone(SYMBOLIC)
def routh_hurwitz(coefficients: Sequence[float]) -> Hurwitz:
    """Apply the Routh-Hurwitz criterion to the coefficients of a characteristic polynomial.

    Parameters
    ----------
    coefficients : sequence of numbers
        Highest power first, at least two; mpmath numbers keep their precision.

    Raises
    ------
    SceneError
        If the leading coefficient vanishes or one is not finite.

    Notes
    -----
    Minors of the matrix ``H[i, j] = c_(2j - i + 1)``, i, j = 0 ... n - 1, computed with 30 + 5 n digits.
    """
    import mpmath

    for k, c in enumerate(coefficients):
        finite(float(c), f"coefficient {k} of the characteristic polynomial")
    if len(coefficients) < 2 or coefficients[0] == 0:
        raise SceneError("the characteristic polynomial needs a nonzero leading coefficient and at least one root")
    n = len(coefficients) - 1
    with mpmath.workdps(30 + 5 * n):
        lead = mpmath.sign(mpmath.mpf(coefficients[0]))
        positive = [lead * mpmath.mpf(v) for v in coefficients]
        matrix = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                if 0 <= 2 * j - i + 1 <= n:
                    matrix[i, j] = positive[2 * j - i + 1]
        minors = [mpmath.det(matrix[: k + 1, : k + 1]) for k in range(n)]
        return Hurwitz(tuple(float(v) for v in positive), tuple(float(d) for d in minors), all(d > 0 for d in minors))


@alone(SYMBOLIC)
def characteristic_coefficients(matrix: np.ndarray) -> tuple[Any, ...]:
    """Return the coefficients of ``det(s I - matrix)``, highest power first, as mpmath numbers.

    Notes
    -----
    Faddeev-LeVerrier recursion; it would lose many digits in double precision.
    """
    import mpmath

    n = len(matrix)
    with mpmath.workdps(30 + 5 * n):
        a, power = mpmath.matrix(matrix.tolist()), mpmath.eye(n)
        result = [mpmath.mpf(1)]
        for k in range(1, n + 1):
            product = a * power
            result.append(-sum(product[i, i] for i in range(n)) / k)
            power = product + result[-1] * mpmath.eye(n)
        return tuple(result)


@alone(SYMBOLIC)
def symbolic_hurwitz(scene: Scene) -> tuple[sp.Expr, ...]:
    """Return the Routh-Hurwitz determinants of steady sliding in the scene's symbols.

    Parameters
    ----------
    scene : Scene
        At most four states. Its numbers decide only which way each contact slips; positions of the equilibrium stay
        symbols where the determinants depend on them.

    Returns
    -------
    tuple of Expr, length n_x
        All positive if and only if steady sliding is stable.

    Raises
    ------
    SceneError
        If there are more than four states.

    Notes
    -----
    Minors for the polynomial ``det(s^2 M + s B + K)``, or ``det(s I - J)`` with first-order states.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> len(sf.theory.symbolic_hurwitz(belt))
    2
    """
    from symfric.theory.equilibrium import solve
    from symfric.theory.sliding import field_of

    check_scene(scene)
    scene = scene.written_out()
    field = field_of(scene)
    n, n_x = field.n, len(field.states)
    if n_x > MOST_STATES:
        raise SceneError(f"the scene has {n_x} states; a symbolic criterion is given for up to {MOST_STATES}")
    p = field.vector(scene.parameter_values())
    numbers = scene.numbers()
    x = solve(field, p, np.array([numbers[s] for s in field.states]))
    signs = dict(zip(field.signs, (int(s) for s in field.directions(x, p)), strict=True))
    rest = dict.fromkeys(field.system.u, sp.Integer(0))
    slopes = sp.Matrix(field.parts).jacobian(field.states).subs(signs).subs(rest).doit()
    s = sp.Symbol("s")
    top = sp.zeros(n, n_x)
    top[:, n : 2 * n] = sp.eye(n)
    weight = sp.diag(sp.eye(n), sp.Matrix(field.system.mass), sp.eye(field.n_z))
    return _minors(sp.Poly((s * weight - top.col_join(slopes)).det(), s))


@alone(SYMBOLIC)
def symbolic_hurwitz_of_matrices(M: sp.Matrix, B: sp.Matrix, K: sp.Matrix) -> tuple[sp.Expr, ...]:
    """Return the Routh-Hurwitz determinants of ``M q'' + B q' + K q = 0``, n = 1 or 2.

    Parameters
    ----------
    M, B, K : matrices of Expr, shape (n, n)
        det M positive.

    Returns
    -------
    tuple of Expr, length 2 n
        All positive if and only if rest is asymptotically stable.

    Raises
    ------
    SceneError
        If the matrices are not square and of one size, 1 or 2.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> m, c, k = sp.symbols("m c k", positive=True)
    >>> sf.theory.symbolic_hurwitz_of_matrices(sp.Matrix([[m]]), sp.Matrix([[c]]), sp.Matrix([[k]]))
    (c, c*k)
    """
    M, B, K = (_matrix(e, name) for e, name in ((M, "M"), (B, "B"), (K, "K")))
    if not M.shape == B.shape == K.shape or M.rows != M.cols:
        raise SceneError(f"M, B and K have the shapes {M.shape}, {B.shape} and {K.shape}; give square matrices")
    if 2 * M.rows > MOST_STATES:
        raise SceneError(f"{M.rows} coordinates have {2 * M.rows} states; a symbolic criterion is for {MOST_STATES}")
    s = sp.Symbol("s")
    return _minors(sp.Poly((s**2 * M + s * B + K).det(), s))


def _matrix(value: object, name: str) -> sp.Matrix:
    try:
        return sp.Matrix(value)
    except (TypeError, ValueError, sp.SympifyError):
        raise SceneError(f"{name} is {shortened(value)}; give a matrix, {name}=[[...]]") from None


def _minors(polynomial: sp.Poly) -> tuple[sp.Expr, ...]:
    n, c = polynomial.degree(), polynomial.all_coeffs()
    matrix = sp.Matrix(n, n, lambda i, j: c[2 * j - i + 1] if 0 <= 2 * j - i + 1 <= n else 0)
    return tuple(sp.simplify(matrix[: k + 1, : k + 1].det()) for k in range(n))
