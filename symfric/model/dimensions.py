"""Dimensions of expressions: products of known and unknown units, compared term by term.

A dimension is a product of powers of base units with a scale, times powers of units that are not known yet. It is kept
as its logarithm, so that comparing two terms is a linear equation, which determines an unknown one or is contradicted.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import sympy as sp

_SAME = 1e-9  # relative difference of scales that are equal
_ANGLES = (sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.exp, sp.log, sp.erf, sp.erfc)
_INVERSES = (sp.asin, sp.acos, sp.atan, sp.asinh, sp.acosh, sp.atanh)


@dataclass(frozen=True)
class Dimension:
    """A product of powers of base units and of unknown units, and a scale.

    Attributes
    ----------
    base : mapping of str to Fraction
        Exponents of "[length]", "[mass]", ...; none is zero.
    scale : float
        Natural logarithm of the factor to the base units.
    unknown : mapping of str to Fraction
        Exponents of the units of symbols that are not known.
    """

    base: Mapping[str, Fraction] = field(default_factory=dict)
    scale: float = 0.0
    unknown: Mapping[str, Fraction] = field(default_factory=dict)

    def __mul__(self, other: "Dimension") -> "Dimension":
        """Return the dimension of a product."""
        return Dimension(_sum(self.base, other.base), self.scale + other.scale, _sum(self.unknown, other.unknown))

    def __pow__(self, power: Fraction) -> "Dimension":
        """Return the dimension of a power."""
        base, unknown = ({k: power * v for k, v in part.items() if power} for part in (self.base, self.unknown))
        return Dimension(base, float(power) * self.scale, unknown)

    def __truediv__(self, other: "Dimension") -> "Dimension":
        """Return the dimension of a quotient."""
        return self * other ** Fraction(-1)

    @property
    def is_plain(self) -> bool:
        """Whether it is that of a number."""
        return not self.base and not self.unknown and abs(self.scale) < _SAME


PLAIN = Dimension()


def _sum(a: Mapping[str, Fraction], b: Mapping[str, Fraction]) -> dict[str, Fraction]:
    powers = {k: a.get(k, Fraction(0)) + b.get(k, Fraction(0)) for k in (*a, *(k for k in b if k not in a))}
    return {k: v for k, v in powers.items() if v}


class Mismatch(Exception):
    """Two terms that are added or compared have different units; holds both with their dimensions."""

    def __init__(self, one: tuple[str, Dimension], other: tuple[str, Dimension]):
        super().__init__(one, other)
        self.one, self.other = one, other


class Dimensions:
    """What is known of the units of symbols by name; comparing terms adds to it."""

    def __init__(self, given: Mapping[str, Dimension]):
        self._known = dict(given)
        self._new = 0

    def copy(self, **also: Dimension) -> "Dimensions":
        """Return what is known so far, to add to; `also` holds further symbols."""
        known = Dimensions({**self._known, **also})
        known._new = self._new
        return known

    def define(self, name: str, dimension: Dimension) -> None:
        """Give a symbol a dimension."""
        self._known[name] = dimension

    def of_name(self, name: str) -> Dimension:
        """Return the dimension of a symbol, as far as known."""
        return self._resolved(self._known[name] if name in self._known else Dimension(unknown={name: Fraction(1)}))

    def new(self) -> Dimension:
        """Return a new unknown dimension."""
        self._new += 1
        return Dimension(unknown={f" {self._new}": Fraction(1)})  # no symbol has such a name

    def equal(self, one: tuple[str, Dimension], other: tuple[str, Dimension]) -> None:
        """Take both to be equal; determines an unknown unit, or raises Mismatch."""
        rest = self._resolved(one[1] / other[1])
        if not rest.unknown:
            if not rest.is_plain:
                raise Mismatch((one[0], self._resolved(one[1])), (other[0], self._resolved(other[1])))
            return
        name, power = next(iter(rest.unknown.items()))
        others = {k: v for k, v in rest.unknown.items() if k != name}
        self._known[name] = Dimension(rest.base, rest.scale, others) ** (-1 / power)

    def _resolved(self, dimension: Dimension) -> Dimension:
        while True:
            name = next((n for n in dimension.unknown if n in self._known), None)
            if name is None:
                return dimension
            power = dimension.unknown[name]
            rest = {k: v for k, v in dimension.unknown.items() if k != name}
            dimension = Dimension(dimension.base, dimension.scale, rest) * self._known[name] ** power

    def of(self, e: sp.Expr) -> Dimension:
        """Return the dimension of an expression, whose terms must agree; numbers in sums have the unit of the sum."""
        return self._resolved(self._of(e))

    def _of(self, e: sp.Expr) -> Dimension:
        if e.is_number or isinstance(e, sp.sign):
            return PLAIN
        if isinstance(e, sp.Symbol):
            return self.of_name(e.name)
        rule = next((rule for kinds, rule in _RULES if isinstance(e, kinds)), None)
        return self.new() if rule is None else rule(self, e)

    def _product(self, e: sp.Expr) -> Dimension:
        dimension = PLAIN
        for factor in e.args:
            dimension = dimension * self._of(factor)
        return dimension

    def _same(self, e: sp.Expr) -> Dimension:
        terms = [(str(a), self._of(a)) for a in e.args if not a.is_number]
        for other in terms[1:]:
            self.equal(terms[0], other)
        return terms[0][1]

    def _power(self, e: sp.Expr) -> Dimension:
        base, exponent = e.args
        if exponent.is_number and exponent.is_real:
            return self._of(base) ** Fraction(float(exponent)).limit_denominator(1000)
        self.plain(base)
        self.plain(exponent)
        return PLAIN

    def plain(self, e: sp.Expr) -> None:
        """Take an expression to be a plain number."""
        if not e.is_number:
            self.equal((str(e), self._of(e)), ("a plain number", PLAIN))

    def _function(self, e: sp.Expr) -> Dimension:
        for argument in e.args:
            self.plain(argument)
        return PLAIN

    def _branches(self, e: sp.Expr) -> Dimension:
        for _, condition in e.args:
            for relation in condition.atoms(sp.core.relational.Relational):
                self._same(relation) if not all(a.is_number for a in relation.args) else None
        values = [branch for branch, _ in e.args if not branch.is_number]
        terms = [(str(v), self._of(v)) for v in values]
        for other in terms[1:]:
            self.equal(terms[0], other)
        return terms[0][1] if terms else PLAIN

    def _quotient_angle(self, e: sp.Expr) -> Dimension:
        self._same(e)
        return PLAIN


_RULES: tuple[tuple[tuple[type, ...], Callable[[Dimensions, sp.Expr], Dimension]], ...] = (
    ((sp.Add, sp.Max, sp.Min, sp.Mod), Dimensions._same),
    ((sp.Mul,), Dimensions._product),
    ((sp.Abs,), lambda known, e: known._of(e.args[0])),
    ((sp.Pow,), Dimensions._power),
    ((sp.atan2,), Dimensions._quotient_angle),
    ((sp.Piecewise,), Dimensions._branches),
    ((*_ANGLES, *_INVERSES), Dimensions._function),
)


def factor(dimension: Dimension) -> float:
    """Return the factor to the base units."""
    return math.exp(dimension.scale)


def short_factor(dimension: Dimension) -> float:
    """Return the factor to the base units without rounding, if it is a short decimal number or one over it."""
    ratio = factor(dimension)
    for value in (ratio, 1 / ratio):
        short = float(f"{value:.12g}")
        if abs(short - value) <= 1e-13 * value:
            return short if value is ratio else 1 / short
    return ratio
