"""Complete elliptic integrals as expressions of square roots, by the arithmetic-geometric mean.

Solvers know no elliptic integrals. The arithmetic-geometric mean M(1, b) is a few square roots: each step squares the
difference of both numbers, so that a fixed number of steps and the first terms of a series reach rounding.
"""

from typing import NamedTuple

import sympy as sp

STEPS = 5  # after which the ratio of both numbers is above .99 for b >= LEAST
LEAST = 1e-9  # b down to which the relative error is below 1e-15

#: Added to a product, so that SymPy does not take its powers apart into powers of its factors, which overflow.
APART = sp.Float("1e-40", 20)


class GeometricMean(NamedTuple):
    """Arithmetic-geometric mean of 1 and ``b <= 1``, and the sum in the elliptic integral of the second kind.

    Attributes
    ----------
    mean : Expr
        M(1, b); ``K(m) = pi/(2 M)`` with the complementary parameter ``1 - m = b^2``.
    squares : Expr
        ``(c_1^2 + 2 c_2^2 + 4 c_3^2 + ...)/m^2`` with ``c_(n+1) = (a_n - b_n)/2``; then
        ``E(m) = K(m) (1 - m/2 - m^2 squares)``.
    """

    mean: sp.Expr
    squares: sp.Expr


def geometric_mean(b: sp.Expr, m: sp.Expr) -> GeometricMean:
    r"""Return the arithmetic-geometric mean of 1 and ``0 <= b <= 1`` as an expression; `m` is ``1 - b^2`` and a sum.

    Notes
    -----
    :math:`a_{n+1} = (a_n + b_n)/2`, :math:`b_{n+1} = \sqrt{a_n b_n}`, and :math:`c_{n+1} = c_n^2/(4 a_{n+1})`
    without the difference of nearly equal numbers, from :math:`c_0^2 = m`. At the end :math:`M = a_{n+1}/F(h^2)` with
    :math:`h = c_{n+1}/a_{n+1}` and the hypergeometric series :math:`F = 1 + h^2/4 + 9h^4/64 + \dots`. Abramowitz and
    Stegun 17.6. With ``b = 0`` the expression is a number above zero, where the mean itself is 0.
    """
    a: sp.Expr = sp.Integer(1)
    parts: list[sp.Expr] = []
    for n in range(STEPS):
        a, b = (a + b) / 2, sp.sqrt(a * b)
        parts.append(m**2 * (parts[-1] / (4 * a)) ** 2 + APART if n else 1 / (4 * a) ** 2)
    a = (a + b) / 2
    for _ in range(3):  # from here on a_n changes below rounding of these terms
        parts.append(m**2 * (parts[-1] / (4 * a)) ** 2 + APART)
    h2 = m**2 * parts[STEPS] / a**2
    series = 1 + h2 * (sp.Rational(1, 4) + h2 * (sp.Rational(9, 64) + h2 * sp.Rational(25, 256)))
    return GeometricMean(a / series, sp.Add(*(2**n * part for n, part in enumerate(parts))))
