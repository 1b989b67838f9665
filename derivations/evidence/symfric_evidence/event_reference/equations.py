"""Numeric functions of a scene's expressions, with the sign of every kink as an argument."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp
from scipy import special

from symfric.model.contact_states import coefficient, rates_by_side
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME

Numbers = Callable[..., Any]  # of numbers, or of arrays of them, in the order of `Equations.arguments`


class select(sp.Function):  # noqa: N801  (a SymPy function is named as it is called)
    """The second argument where the first is positive, the third elsewhere."""

    nargs = 3

    def _eval_derivative(self, s: sp.Symbol) -> sp.Expr:
        return select(self.args[0], self.args[1].diff(s), self.args[2].diff(s))


def _guarded(function: Callable[..., float]) -> Callable[..., float]:
    def call(*x: float) -> float:
        try:
            return function(*x)
        except (ValueError, ArithmeticError):
            return math.nan

    return call


# Roots and inverse functions in two forms. Trial steps evaluate a mode beyond its end, where the argument of a root may
# be negative: the first form goes on with the value at the edge of its domain, the second is not a number there.
EXTENDED: dict[str, Callable[..., float]] = {
    "power": lambda x, p: max(x, 0.0) ** p,
    "asin": lambda x: math.asin(min(max(x, -1.0), 1.0)),
    "acos": lambda x: math.acos(min(max(x, -1.0), 1.0)),
}
STRICT: dict[str, Callable[..., float]] = {"power": math.pow, "asin": math.asin, "acos": math.acos}


def _exp(x: float) -> float:
    return math.exp(x) if x < 709.0 else math.inf


def _pick(side: Any, above: Any, below: Any) -> Any:
    return above if side > 0 else below


SCALAR: dict[str, Callable[..., Any]] = {
    **{name: _guarded(getattr(math, name)) for name in ("sqrt", "log", "asin", "acos", "sin", "cos", "tan")},
    "exp": _exp,
    "cosh": lambda x: math.cosh(x) if abs(x) < 709.0 else math.inf,
    "sinh": lambda x: math.sinh(x) if abs(x) < 709.0 else math.copysign(math.inf, x),
    "falling": lambda x: 2 / (_exp(abs(x)) + math.exp(-abs(x))),
    "erf": math.erf,
    "select": _pick,
    **{f"extended_{name}": _guarded(f) for name, f in EXTENDED.items()},
}
INSIDE = {**SCALAR, **{f"extended_{name}": _guarded(f) for name, f in STRICT.items()}}
ARRAY = {
    "erf": special.erf,
    "select": _pick,
    "falling": lambda x: 2 * np.exp(-np.abs(x)) / (1 + np.exp(-2 * np.abs(x))),
    **{f"extended_{name}": np.vectorize(_guarded(f), otypes=[float]) for name, f in EXTENDED.items()},
}


class KinkRegister:
    """Replaces Abs, Max, Min and Piecewise by `select` over signs; collects the expressions whose signs they are."""

    def __init__(self) -> None:
        self.guards: list[sp.Expr] = []
        self.signs: list[sp.Symbol] = []

    def side(self, guard: sp.Expr) -> sp.Expr:
        """Return the symbol of the sign of `guard`, or its negative if the opposite is known."""
        for known, sign in zip(self.guards, self.signs, strict=True):
            if guard == known:
                return sign
            if guard == -known:
                return -sign
        self.guards.append(guard)
        self.signs.append(sp.Symbol(f"kink_{len(self.signs)}", real=True))
        return self.signs[-1]

    def pieces(self, expr: sp.Expr) -> sp.Expr:
        """Return `expr` as a function that is smooth for fixed signs."""
        if not expr.args or not expr.has(sp.Abs, sp.Max, sp.Min, sp.Piecewise):
            return expr
        if isinstance(expr, sp.Piecewise):
            result = self.pieces(expr.args[-1].expr)
            for value, condition in reversed(expr.args[:-1]):
                result = self._where(condition, self.pieces(value), result)
            return result
        args = [self.pieces(a) for a in expr.args]
        if isinstance(expr, sp.Abs):
            return select(self.side(args[0]), args[0], -args[0])
        if isinstance(expr, sp.Max | sp.Min):
            way, result = (1 if isinstance(expr, sp.Max) else -1), args[0]
            for other in args[1:]:
                result = select(way * self.side(result - other), result, other)
            return result
        return expr.func(*args)

    def _where(self, condition: sp.Basic, yes: sp.Expr, no: sp.Expr) -> sp.Expr:
        if condition == sp.true:
            return yes
        if isinstance(condition, sp.And):
            for part in condition.args:
                yes = self._where(part, yes, no)
            return yes
        if isinstance(condition, sp.Or):
            for part in condition.args:
                no = self._where(part, yes, no)
            return no
        if isinstance(condition, sp.Not):
            return self._where(condition.args[0], no, yes)
        above = isinstance(condition, sp.StrictGreaterThan | sp.GreaterThan)
        left, right = (self.pieces(e) for e in (condition.lhs, condition.rhs))
        return select(self.side(left - right if above else right - left), yes, no)


class Equations:
    """Forces, slips, bounds and kinks of a scene as functions of numbers.

    Every function takes ``(t, *states, *parameters, *signals, *slopes, *modes, *signs)``: the parameters in the order
    of `parameters`, value and slope of every sampled input, the mode of every contact and the sign of every kink.
    """

    def __init__(self, scene: Scene):
        system, contacts = scene.system, scene.contacts
        self.scene = scene
        self.n, self.n_z, self.n_c = len(system.q), len(system.z), len(contacts)
        self.parameters = tuple(sorted(scene.parameters, key=str))
        self.remembers = tuple(c.law.memory is not None for c in contacts)  # contacts that never stick
        signals = tuple(scene.inputs)
        slopes = tuple(sp.Symbol(f"{s.name}_slope", real=True) for s in signals)
        modes = sp.symbols(f"mode_:{self.n_c}", real=True) if self.n_c else ()
        kinks = KinkRegister()
        everything = [*system.expressions, *(e for c in contacts for e in (c.slip, c.normal, c.profile, c.law.kinetic))]
        symbols = {TIME, *system.states, *signals}.union(*(e.free_symbols for e in everything))
        real = {s: sp.Symbol(s.name, real=True) for s in symbols if s.is_extended_real is None}
        time = real.get(TIME, TIME)
        q, u, states, signals = (
            tuple(real.get(s, s) for s in group) for group in (system.q, system.u, system.states, signals)
        )

        def smooth(e: sp.Expr) -> sp.Expr:
            return kinks.pieces(e.xreplace(real))

        slips = [smooth(c.slip) for c in contacts]
        speeds = [m * w for m, w in zip(modes, slips, strict=True)]
        load = [smooth(c.normal * c.profile) for c in contacts]
        kinetic = [
            smooth(m * coefficient(c, m) if c.law.memory else c.law.kinetic.subs(SPEED, v))
            for c, v, m in zip(contacts, speeds, modes, strict=True)
        ]
        force = [smooth(e) for e in system.force]
        rates = [smooth(e) for e in rates_by_side(system, contacts, modes)]
        mass = [smooth(e) for e in system.mass]
        rows = [w.diff(v) for w in slips for v in u]
        q_dot = dict(zip(q, u, strict=True))
        drift = [
            w.diff(time)
            + sum(w.diff(a) * b for a, b in q_dot.items())
            + sum(w.diff(s) * r for s, r in zip(signals, slopes, strict=True))
            for w in slips
        ]
        friction = [-m * n * mu for m, n, mu in zip(modes, load, kinetic, strict=True)]
        bounds = [n * smooth(c.law.stick) for n, c in zip(load, contacts, strict=True)]
        self._inputs = tuple(zip(signals, slopes, strict=True))
        parameters = (real.get(s, s) for s in self.parameters)
        self._time, self._states = time, states
        self.arguments = (time, *states, *parameters, *signals, *slopes, *modes, *kinks.signs)
        self.guards, self.n_k = tuple(kinks.guards), len(kinks.guards)
        self._core = [*mass, *force, *rates, *rows, *drift, *friction, *bounds]
        self._watched = [*slips, *self.guards]
        self._features = features([*self._core, *self._watched])
        sizes = [self.n**2, self.n, self.n_z, self.n_c * self.n, self.n_c, self.n_c, self.n_c]
        self.cuts = tuple(int(k) for k in np.cumsum(sizes))
        self._scales = [*(_terms(f) for f in force), *(_terms(w) for w in slips), *(_terms(g) for g in self.guards)]

    def _scalar(self, expressions: Sequence[sp.Expr], functions: Mapping[str, Callable[..., Any]] = SCALAR) -> Numbers:
        made: Numbers = sp.lambdify(self.arguments, [_plain(e) for e in expressions], [functions, "math"], cse=True)
        return made

    def _array(self, expressions: Sequence[sp.Expr]) -> Numbers:
        made: Numbers = sp.lambdify(self.arguments, [_plain(e) for e in expressions], [ARRAY, "numpy"], cse=True)
        return made

    @cached_property
    def core(self) -> Numbers:
        """Mass, force, rates of z, slip rows, drifts, kinetic friction and bounds of sticking; cut at `cuts`."""
        return self._scalar(self._core)

    @cached_property
    def inside(self) -> Numbers | None:
        """The same, but not a number outside the domains of roots and inverse functions; None if there are none."""
        if not any(_plain(e).has(*_EDGED.values()) for e in self._core):
            return None
        return self._scalar(self._core, INSIDE)

    @cached_property
    def watched(self) -> Numbers:
        """Slips and guards of the kinks."""
        return self._scalar(self._watched)

    @cached_property
    def watched_array(self) -> Numbers:
        """Slips, guards of the kinks and arguments of the features, for arrays of times."""
        return self._array([*self._watched, *self._features])

    @cached_property
    def guard_slopes(self) -> Numbers:
        """Derivatives of the guards of the kinks: with respect to t, then q, u and z of every guard."""
        rows = [
            e
            for g in self.guards
            for e in (
                g.diff(self._time) + sum(g.diff(s) * r for s, r in self._inputs),
                *(g.diff(s) for s in self._states),
            )
        ]
        return self._scalar(rows)

    @cached_property
    def scales(self) -> Numbers:
        """Sums of the magnitudes of the terms of every force, slip and guard, the scales of their rounding errors."""
        return self._scalar(self._scales)


def _terms(expr: sp.Expr) -> sp.Expr:
    return sp.Add(*(sp.Abs(a) for a in sp.Add.make_args(sp.expand_mul(expr, deep=False))))


class falling(sp.Function):  # noqa: N801
    """The hyperbolic secant, which does not overflow where the cosine does."""

    nargs = 1


_EDGED = {name: sp.Function(f"extended_{name}") for name in EXTENDED}


def _has_edge(e: sp.Expr) -> bool:
    return isinstance(e, sp.Pow) and e.exp.is_integer is False and not e.base.is_positive


def _plain(expr: sp.Expr) -> sp.Expr:
    """Rewrite functions that the math module lacks or that have an edge, and hyperbolic quotients that overflow."""
    expr = expr.replace(sp.sech, lambda x: 1 / sp.cosh(x))
    expr = expr.replace(_has_edge, lambda e: _EDGED["power"](e.base, e.exp))
    expr = expr.replace(sp.asin, _EDGED["asin"]).replace(sp.acos, _EDGED["acos"])
    if expr.has(sp.cosh):
        expr = expr.replace(sp.sinh, lambda x: sp.tanh(x) * sp.cosh(x))
        secants = {
            e: falling(e.base.args[0]) ** -e.exp
            for e in expr.atoms(sp.Pow)
            if isinstance(e.base, sp.cosh) and e.exp.is_negative
        }
        expr = expr.xreplace(secants)
    return expr


def features(expressions: list[sp.Expr]) -> list[sp.Expr]:
    """Return the arguments whose change over a step must stay small, so that no narrow feature is skipped.

    The function of an argument does nothing sudden while the argument changes by less than one, or by less than half of
    itself; where a power of a term is the argument, that term counts. A reciprocal counts by its logarithm.
    """
    arguments: dict[sp.Expr, None] = {}
    for expr in expressions:
        for e in sp.preorder_traversal(expr):
            if isinstance(e, sp.Function) and not isinstance(e, select):
                arguments[_unpowered(e.args[0])] = None
            elif isinstance(e, sp.Pow) and not e.exp.is_number:
                arguments[_unpowered(e.exp)] = None
            elif isinstance(e, sp.Pow) and e.exp.is_negative and isinstance(e.base, sp.Add) and e.base.is_positive:
                arguments[sp.log(e.base)] = None
    return [e for e in arguments if e.free_symbols]


def _unpowered(argument: sp.Expr) -> sp.Expr:
    """Return g for an argument c g**n: that what is looked at changes its sign where the feature is."""
    c, rest = argument.as_independent(*argument.free_symbols, as_Add=False)
    factors = sp.Mul.make_args(rest)
    if any(isinstance(a, sp.Pow) and a.exp.is_even and a.exp.is_positive for a in factors):
        powers = [a.args for a in factors if isinstance(a, sp.Pow)]
        n = min((p for _, p in powers if p.is_even and p.is_positive), default=2)
        root = sp.Mul(*(base ** (p / n) for base, p in (a.as_base_exp() for a in factors)))
        return sp.Abs(c) ** (sp.Integer(1) / n) * root
    return argument
