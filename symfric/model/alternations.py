"""Conditions on time that alternate for ever: signs of sines, whose instants of change are known.

A square wave ``sin(w t) > 0``, a level ``cos(w t) > c`` and a train of pulses (see `symfric.model.steps`) become
products of ``sin(pi (r t + b))``. Each changes its sign where ``r t + b`` is a whole number, whatever the motion does.
"""

from dataclasses import dataclass

import sympy as sp

from symfric.model.symbols import TIME


@dataclass(frozen=True)
class Alternation:
    """The sign of ``sin(pi (rate t + offset))``.

    Attributes
    ----------
    rate, offset : Expr
        Without time.
    """

    rate: sp.Expr
    offset: sp.Expr

    @property
    def wave(self) -> sp.Expr:
        """The sine itself."""
        return sp.sin(sp.pi * (self.rate * TIME + self.offset))


def alternations_of(expr: sp.Expr) -> tuple[sp.Expr, tuple[Alternation, ...]] | None:
    """Return a factor without time and alternations whose signs multiply to that of an expression; None if not known.

    Parameters
    ----------
    expr : Expr
        A product of sines and cosines of linear functions of time, and of such ones less a number.

    Examples
    --------
    >>> import sympy as sp
    >>> factor, (first, second) = alternations_of(-2 * sp.sin(3 * sp.pi * TIME) * sp.cos(sp.pi * TIME))
    >>> factor, first.rate, second.rate, second.offset
    (-2, 1, 3, 0)
    >>> alternations_of(sp.sin(TIME) - 2)[1]
    ()
    >>> alternations_of(TIME**2 - 1) is None
    True
    """
    factor: sp.Expr = sp.S.One
    alternations: list[Alternation] = []
    for a in sp.Mul.make_args(expr):
        if TIME not in a.free_symbols:
            factor *= a
            continue
        if a.is_Pow and a.exp.is_Integer and a.exp > 0:
            if a.exp.is_even:
                continue  # at most touches zero
            a = a.base
        part = _level(a) if a.is_Add else _wave(a)
        if part is None:
            return None
        factor *= part[0]
        alternations += part[1]
    return factor, tuple(alternations)


def _wave(e: sp.Expr) -> tuple[sp.Expr, list[Alternation]] | None:
    if not isinstance(e, sp.sin | sp.cos):
        return None
    angle = e.args[0] / sp.pi
    rate = sp.expand(angle.diff(TIME))
    if TIME in rate.free_symbols:
        return None
    offset = sp.expand(angle.subs(TIME, 0)) + (sp.Rational(1, 2) if isinstance(e, sp.cos) else 0)
    return sp.S.One, [Alternation(rate, offset)]


def _level(e: sp.Expr) -> tuple[sp.Expr, list[Alternation]] | None:
    """Return the parts of ``a sin(x) - c``, as ``sin x - sin y = 2 sin((x - y)/2) cos((x + y)/2)`` with sin y = c/a."""
    rest, moving = e.as_independent(TIME, as_Add=True)
    size, wave = moving.as_independent(TIME, as_Add=False)
    found = _wave(wave)
    height = -rest / size
    if found is None or not height.is_number:
        return None
    if abs(height) >= 1:
        return rest, []  # at most touched
    (at,) = found[1]
    half, shift = at.rate / 2, sp.asin(height) / sp.pi
    below = Alternation(half, (at.offset - shift) / 2)
    above = Alternation(half, (at.offset + shift + 1) / 2)
    return size, [below, above]
