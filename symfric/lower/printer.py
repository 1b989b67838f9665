"""Convert SymPy expressions to CasADi; unknown functions are errors that name them.

Kinks (Abs, Max, Min, conditions of a Piecewise) of quantities that move become *switches*: a sign held as data and a
guard that stays positive as long as the sign is right. Every printed expression is therefore smooth.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import casadi as ca
import sympy as sp
from sympy.core.relational import Relational

from symfric.errors import SceneError
from symfric.lower.chebyshev import ChebyshevSeries
from symfric.lower.lookup import LEAST, looked_up
from symfric.lower.mode_layout import JUST_AFTER
from symfric.model.alternations import Alternation, alternations_of
from symfric.model.numeric import gauss_legendre
from symfric.model.symbols import TIME
from symfric.model.tables import Table, table_of
from symfric.scalars import binary

_UNARY: dict[type, Callable[[ca.SX], ca.SX]] = {
    sp.exp: ca.exp,
    sp.log: ca.log,
    sp.sin: ca.sin,
    sp.cos: ca.cos,
    sp.tan: ca.tan,
    sp.asin: ca.asin,
    sp.acos: ca.acos,
    sp.atan: ca.atan,
    sp.sinh: ca.sinh,
    sp.cosh: ca.cosh,
    sp.tanh: ca.tanh,
    sp.asinh: ca.asinh,
    sp.acosh: ca.acosh,
    sp.atanh: ca.atanh,
    sp.erf: ca.erf,
}
_RELATIONS = {sp.StrictLessThan: ca.lt, sp.LessThan: ca.le, sp.StrictGreaterThan: ca.gt, sp.GreaterThan: ca.ge}
_LITTLE, _LARGE = 1e-30, 1e30  # factors of an exponential outside these limits are moved into its argument
_LEAN = 0.25  # e in the guard of an alternation
_SLOWEST = 1e-100  # least rate of an alternation, so that one which does not alternate has finite instants


def _double(e: sp.Expr) -> float:
    number = float(e)
    if math.isinf(number) and e.is_finite:
        raise SceneError(f"the number {e.evalf(3)} is beyond double precision; use other units, or divide it out")
    return number


@dataclass
class Switches:
    """Signs of the kinks of printed expressions, SX symbols of value -1 or +1, and their guards."""

    horizon: float = 1.0  # relative to which instants are the same
    signs: list[ca.SX] = field(default_factory=list)
    quantities: list[ca.SX] = field(default_factory=list)
    guards: list[ca.SX] = field(default_factory=list)  # positive while the sign is right
    steps: set[int] = field(default_factory=set)  # those of conditions on time and parameters alone
    _known: dict[sp.Expr, ca.SX] = field(default_factory=dict)

    def copy(self) -> "Switches":
        """Return a copy, to which switches can be added."""
        own = [*self.signs], [*self.quantities], [*self.guards]
        return Switches(self.horizon, *own, set(self.steps), dict(self._known))

    def of(self, quantity: ca.SX, key: sp.Expr, guard: Callable[[ca.SX], ca.SX] | None = None) -> ca.SX:
        """Return the sign of `quantity` as data; the same `key` gives the same switch.

        `guard` makes the guard from the sign; without it, that is sign times quantity.
        """
        if key not in self._known:
            sign = ca.SX.sym(f"sigma_{len(self.signs)}")
            self.signs.append(sign)
            self.quantities.append(quantity)
            self.guards.append(guard(sign) if guard else sign * quantity)
            self._known[key] = sign
        return self._known[key]


@dataclass
class Printer:
    """Print SymPy expressions as CasADi SX.

    Attributes
    ----------
    symbols : dict of Symbol to SX
        SX expression of every symbol.
    moving : set of Symbol
        Symbols that change along a run; kinks of anything else are evaluated, not switched.
    switches : Switches
        Collects the kinks.
    scope : str
        Distinguishes switches of equal SymPy expressions whose symbols stand for different SX.
    nodes : tuple of (Symbol, Expr, Expr, float)
        Variable and ends of the integrals around the expression, the innermost last, and the share of the way between
        the ends at which it is printed; they tell the switches of the nodes apart.
    """

    symbols: dict[sp.Symbol, ca.SX]
    moving: set[sp.Symbol]
    switches: Switches
    scope: str = ""
    nodes: tuple[tuple[sp.Symbol, sp.Expr, sp.Expr, float], ...] = ()
    _memo: dict[sp.Expr, ca.SX] = field(default_factory=dict)

    def copy(self, moving: set[sp.Symbol], switches: Switches) -> "Printer":
        """Return a copy with the same cache, to which symbols can be added."""
        return Printer(dict(self.symbols), moving, switches, self.scope, self.nodes, dict(self._memo))

    def __call__(self, expr: sp.Expr) -> ca.SX:
        """Return the SX of a scalar expression."""
        return self._print(sp.sympify(expr))

    def _print(self, e: sp.Expr) -> ca.SX:
        if e not in self._memo:
            self._memo[e] = self._convert(e)
        return self._memo[e]

    def _convert(self, e: sp.Expr) -> ca.SX:
        if isinstance(e, sp.Symbol):
            if e not in self.symbols:
                raise SceneError(f"no value for {e}; add it to Scene.values")
            return self.symbols[e]
        if e.is_Number or isinstance(e, sp.NumberSymbol):
            return ca.SX(_double(e))
        if e.is_Add:
            return _sum([self._print(a) for a in e.args])
        if e.is_Mul:
            return self._product(e)
        if e.is_Pow:
            return self._power(e)
        if e.func in _UNARY:
            return _UNARY[e.func](self._print(e.args[0]))
        if isinstance(e, sp.Abs):
            return self._absolute(e.args[0])
        if isinstance(e, sp.Max | sp.Min):
            return self._extreme(e)
        if isinstance(e, sp.Piecewise):
            return self._piecewise(e)
        if isinstance(e, ChebyshevSeries):
            return _clenshaw(*map(self._print, e.args))
        if isinstance(e, sp.Integral):
            return self._sum_of(e)
        if isinstance(e, sp.atan2):
            return ca.atan2(self._print(e.args[0]), self._print(e.args[1]))
        raise SceneError(f"{type(e).__name__} in {e} has no translation to CasADi; rewrite it with known functions")

    def _product(self, e: sp.Expr) -> ca.SX:
        factor, rest = e.as_coeff_Mul()
        if not _LITTLE < abs(factor) < _LARGE and rest.has(sp.exp):  # SymPy writes exp(900 - t/w) as a product
            factors = list(sp.Mul.make_args(rest))
            k = next((k for k, a in enumerate(factors) if isinstance(a, sp.exp)), None)
            if k is not None:
                inside = self._print(factors.pop(k).args[0]) + float(sp.log(abs(factor)))
                return self._print(sp.Mul(sp.sign(factor), *factors)) * ca.exp(inside)
        over, under = [], []
        for a in e.args:
            if a.is_Pow and a.exp.is_Number and a.exp.is_negative:
                under.append(self._print(a.base**-a.exp))
            else:
                over.append(self._print(a))
        top = _fold(over)
        return top / _fold(under) if under else top

    def _power(self, e: sp.Expr) -> ca.SX:
        base, exponent = e.args
        if base is sp.E:
            return ca.exp(self._print(exponent))
        b = self._print(base)
        if exponent.is_Integer:
            n = int(exponent)
            return _integer_power(b, n) if n > 0 else 1 / _integer_power(b, -n)
        if exponent == sp.Rational(1, 2):
            return ca.sqrt(b)
        if exponent == -sp.Rational(1, 2):
            return 1 / ca.sqrt(b)
        return b ** self._print(exponent)

    def _sum_of(self, integral: sp.Integral) -> ca.SX:
        """Return the Gauss-Legendre sum of a definite integral; parts without its variable are printed once."""
        ((variable, low, high),) = integral.limits
        start = self._print(low)
        width = self._print(high) - start
        moving = self.moving | {variable} if self._moves(low) or self._moves(high) else self.moving
        fixed = {e: self._print(e) for e in _without(variable, integral.function)}
        terms = []
        for node, weight in zip(*gauss_legendre(), strict=True):
            symbols = {**self.symbols, variable: start + width * float(node)}
            nodes = (*self.nodes, (variable, low, high, float(node)))
            show = Printer(symbols, moving, self.switches, self.scope, nodes, dict(fixed))
            terms.append(binary(ca.OP_MUL, weight, show(integral.function)))
        return width * _sum(terms)

    def _switch(self, quantity: ca.SX, *parts: sp.Expr, guard: Callable[[ca.SX], ca.SX] | None = None) -> ca.SX:
        for variable, low, high, node in reversed(self.nodes):
            parts = tuple(e.xreplace({variable: low + (high - low) * node}) for e in parts)
        return self.switches.of(quantity, (self.scope, *parts), guard)

    def _moves(self, e: sp.Expr) -> bool:
        return bool(e.free_symbols & self.moving)

    def _absolute(self, a: ca.SX) -> ca.SX:
        x = self._print(a)
        return self._switch(x, a) * x if self._moves(a) else ca.fabs(x)

    def _extreme(self, e: sp.Expr) -> ca.SX:
        larger = isinstance(e, sp.Max)
        result, so_far = self._print(e.args[0]), e.args[0]
        for a in e.args[1:]:
            x = self._print(a)
            if not self._moves(e):
                result = ca.fmax(result, x) if larger else ca.fmin(result, x)
                continue
            sign = self._switch(result - x, so_far, a)
            first = sign > 0 if larger else sign < 0
            result = ca.if_else(first, result, x)
            so_far = e.func(so_far, a)
        return result

    def _piecewise(self, e: sp.Expr) -> ca.SX:
        if e.args[-1].cond != sp.true:
            raise SceneError(f"the Piecewise {e} has no last branch with the condition True")
        table = table_of(e) if len(e.args) > LEAST else None
        if table is not None and self._moves(table.argument) and not self._jumps_in_place(table):
            return self._looked_up(table)
        result = self._print(e.args[-1].expr)
        for piece in reversed(e.args[:-1]):
            result = ca.if_else(self._condition(piece.cond), self._print(piece.expr), result)
        return result

    def _looked_up(self, table: Table) -> ca.SX:
        """Return a table as a lookup; linear pieces are one line with value and slope from the table."""
        breaks, symbols = [_double(b) for b in table.breaks], table.argument.free_symbols
        timed = symbols & self.moving == {TIME}

        def switch(quantity: ca.SX, level: int) -> ca.SX:
            sign = self._switch(quantity, table.argument, *table.breaks, sp.Integer(level))
            if timed:
                self._mark_step(sign)
            return sign

        chosen = looked_up(self._print(table.argument), breaks, switch)
        lines = table.lines
        if lines is None:
            return chosen([self._print(piece) for piece in table.pieces])
        value, slope = (chosen([self._print(e) for e in column]) for column in zip(*lines, strict=True))
        return value + slope * self._print(table.argument)

    def _jumps_in_place(self, table: Table) -> bool:
        """Whether a table is one of constants that jump with the state, as on the cells of a floor.

        The edges of cells are looked at one by one, see `symfric.lower.cell_edges`.
        """
        still = not any(self._moves(piece) for piece in table.pieces)
        return still and table.argument.free_symbols & self.moving != {TIME}

    def _mark_step(self, sign: ca.SX) -> None:
        self.switches.steps.add(next(k for k, s in enumerate(self.switches.signs) if s is sign))

    def _condition(self, c: sp.Basic) -> ca.SX:
        if c in (sp.true, sp.false):
            return ca.SX(1 if c == sp.true else 0)
        if isinstance(c, sp.And | sp.Or):
            combine = ca.logic_and if isinstance(c, sp.And) else ca.logic_or
            result = self._condition(c.args[0])
            for a in c.args[1:]:
                result = combine(result, self._condition(a))
            return result
        if isinstance(c, sp.Not):
            return ca.logic_not(self._condition(c.args[0]))
        if not isinstance(c, Relational) or type(c) not in _RELATIONS:
            raise SceneError(f"the condition {c} is not one of <, <=, >, >=, and, or, not")
        if not self._moves(c):
            return _RELATIONS[type(c)](self._print(c.lhs), self._print(c.rhs))
        gap = c.gts - c.lts
        if gap.free_symbols & self.moving == {TIME}:
            return self._sign_in_time(gap) > 0
        return self._switch(self._print(gap), gap) > 0

    def _sign_in_time(self, e: sp.Expr) -> ca.SX:
        """Return the sign of a function of time and parameters alone."""
        known = alternations_of(e)
        if known is None:
            sign = self._switch(self._print(e), e)
            self._mark_step(sign)
            return sign
        factor, alternations = known
        return ca.if_else(self._print(factor) < 0, -1, 1) * _fold([self._alternating(a) for a in alternations])

    def _alternating(self, a: Alternation) -> ca.SX:
        """Return the sign of ``sin(pi (rate t + offset))``, held between its zeros, which are known.

        Between the zeros t_0 and t_1 around the instant at which a step begins, the guard is, with s = t - t_0 and
        d = t_1 - t_0, the cubic ``s (s + e d) (d - s)``: a polynomial has its roots to rounding, where a series of the
        sine has them to the tolerance only. Its slope at t_0 is e/(1 + e) of that at t_1. By so much falls the rounding
        of one instant in the next, since a guard that begins at zero is divided by s. `floor` does not change along a
        step, see `symfric.solve.taylor.recurrences`.
        """
        t, rate, offset = self._print(TIME), self._print(a.rate), self._print(a.offset)
        way = ca.if_else(rate < 0, -1, 1)
        rate, offset = ca.fmax(way * rate, _SLOWEST), way * offset
        phase = rate * t + offset
        # at least 4 times the time within which instants are the same; `fabs` has no series
        soon = 4 * JUST_AFTER * rate * (1.5 * self.switches.horizon + t * t / (2 * self.switches.horizon))

        def guard(sign: ca.SX) -> ca.SX:
            odd = (1 - sign) / 2
            before = 2 * ca.floor((phase + soon - odd) / 2) + odd
            since, left = t - (before - offset) / rate, (before + 1 - offset) / rate - t
            return since * (since * rate + _LEAN) * left * (rate / (1 + _LEAN))

        whole = ca.floor(phase)
        sign = self._switch(1 - 2 * (whole - 2 * ca.floor(whole / 2)), a.wave, guard=guard)
        self._mark_step(sign)
        return way * sign


def _clenshaw(x: ca.SX, *coefficients: ca.SX) -> ca.SX:
    """Sum a Chebyshev series."""
    later = latest = ca.SX(0)
    for c in reversed(coefficients[1:]):
        later, latest = c + 2 * x * later - latest, later
    return coefficients[0] + x * later - latest


@lru_cache(maxsize=256)
def _without(variable: sp.Symbol, e: sp.Basic) -> tuple[sp.Expr, ...]:
    """Return the largest parts of an expression that do not contain a symbol."""
    if isinstance(e, sp.Expr) and variable not in e.free_symbols:
        return () if isinstance(e, sp.Symbol) else (e,)
    return tuple(part for a in e.args for part in _without(variable, a))


def _sum(terms: Sequence[ca.SX]) -> ca.SX:
    result = terms[0]
    for term in terms[1:]:
        result = binary(ca.OP_ADD, result, term)
    return result


def _fold(factors: Sequence[ca.SX]) -> ca.SX:
    result = ca.SX(1)
    for factor in factors:
        result = binary(ca.OP_MUL, result, factor)
    return result


def _integer_power(base: ca.SX, n: int) -> ca.SX:
    """Multiply out by squaring, so that a zero base has all its derivatives."""
    if n == 0:
        return ca.SX(1)
    while not n & 1:
        base, n = base * base, n >> 1
    result = base
    while n := n >> 1:
        base = base * base
        if n & 1:
            result = result * base
    return result
