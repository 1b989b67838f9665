"""Expressions that are evaluated at an instant, where a jump is no more than a value: updates and resets.

Time in what decides a jump, a condition or a rounded number, is taken as just after the instant. A step at t = 29 then
is seen by the sample at 100 periods of .29, which is 28.999999999999996 in double precision.
"""

from collections.abc import Mapping

import casadi as ca
import sympy as sp
from sympy.core.relational import Relational

from symfric.lower.printer import Printer, Switches
from symfric.model.symbols import TIME

_LATER = sp.Symbol("just after t", real=True)


def evaluated(e: sp.Expr, symbols: Mapping[sp.Symbol, ca.SX], later: ca.SX) -> ca.SX:
    """Return the graph of an expression at an instant.

    Parameters
    ----------
    e : Expr
        It may contain signs, ``Heaviside``, ``floor``, ``ceiling``, ``frac`` and ``Mod``, also of states.
    symbols : mapping of Symbol to SX
    later : SX
        A time just after the instant.

    Examples
    --------
    >>> import casadi as ca
    >>> import sympy as sp
    >>> x = sp.Symbol("x", real=True)
    >>> evaluated(sp.floor(x) + sp.Mod(x, sp.Rational(1, 2)), {x: ca.SX(2.75)}, ca.SX(0))
    SX(2.25)
    """
    return _Instant(symbols, later).show(e)


class _Instant:
    """Prints expressions at one instant."""

    def __init__(self, symbols: Mapping[sp.Symbol, ca.SX], later: ca.SX):
        self._known = {**symbols, _LATER: later}
        self._print = Printer(self._known, set(), Switches())
        self._memo: dict[sp.Basic, sp.Basic] = {}

    def show(self, e: sp.Basic) -> ca.SX:
        """Return the graph of an expression."""
        return self._print(self._plain(e))

    def _plain(self, e: sp.Basic) -> sp.Basic:
        """Return an expression whose jumps are conditions, or symbols for what is rounded."""
        if e not in self._memo:
            self._memo[e] = self._rewritten(e, [self._plain(a) for a in e.args])
        return self._memo[e]

    def _rewritten(self, e: sp.Basic, args: list[sp.Basic]) -> sp.Basic:
        if isinstance(e, Relational):
            return e.func(*(_after(a) for a in args))
        if isinstance(e, sp.sign):
            a = _after(args[0])
            return sp.Piecewise((-1, a < 0), (1, a > 0), (0, True))
        if isinstance(e, sp.Heaviside):
            return sp.Piecewise((0, _after(args[0]) < 0), (1, True))
        if isinstance(e, sp.floor | sp.frac):
            whole = self._floor(args[0])
            return whole if isinstance(e, sp.floor) else args[0] - whole
        if isinstance(e, sp.ceiling):
            return -self._floor(-args[0])
        if isinstance(e, sp.Mod):
            return args[0] - args[1] * self._floor(args[0] / args[1])
        return e.func(*args) if tuple(args) != e.args else e

    def _floor(self, a: sp.Basic) -> sp.Symbol:
        """Return a symbol for the largest whole number that does not exceed an expression."""
        whole = sp.Dummy("whole", real=True)
        self._print.symbols[whole] = ca.floor(self._print(_after(a)))
        return whole


def _after(e: sp.Basic) -> sp.Basic:
    return e.xreplace({TIME: _LATER})
