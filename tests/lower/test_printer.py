"""The bridge from SymPy to CasADi: values against lambdify, kinks as switches, refusals by name."""

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower.printer import Printer, Switches

X, Y, K = sp.symbols("x y k", real=True)
T = sf.TIME
FUNCTIONS = {
    "constant": sp.Rational(2, 7) + sp.pi * sp.E,
    "sum": X + 2 * Y - K + 3,
    "product": -X * Y * K / 3,
    "quotient": X / (Y * (1 + K**2)),
    "integer powers": X**2 + Y**3 + X**7 - Y**-2 + K**-3,
    "negative base": (X - 2) ** 3 + (X - 2) ** -1,
    "square root": sp.sqrt(X) + 1 / sp.sqrt(Y),
    "fractional powers": X ** sp.Rational(3, 2) + Y ** sp.Rational(-5, 3) + X**2.5,
    "power of a symbol": X**K,
    "power of a number": 2**X,
    "exp": sp.exp(-X) + sp.exp(Y * K),
    "log": sp.log(X * Y),
    "trigonometric": sp.sin(X) * sp.cos(Y) + sp.tan(X * K),
    "inverse": sp.asin(X / 3) + sp.acos(Y / 3) + sp.atan(K),
    "hyperbolic": sp.sinh(X) - sp.cosh(Y) + sp.tanh(K),
    "inverse hyperbolic": sp.asinh(X) + sp.acosh(1 + Y) + sp.atanh(K / 4),
    "erf": sp.erf(X - Y),
    "atan2": sp.atan2(X - 1, Y - 2) + sp.atan2(-1, X - Y),
    "time": sp.sin(3 * T) * X,
    "cot": 1 / sp.tan(X),
    "nested": sp.exp(sp.sin(sp.sqrt(1 + X**2)) / sp.log(3 + Y)),
    "abs": sp.Abs(X - Y),
    "max": sp.Max(X, Y, K),
    "min": sp.Min(X, Y, K, X * Y),
    "max of abs": sp.Max(sp.Abs(X - Y) - sp.Rational(1, 2), sp.Abs(K - X)),
    "piecewise": sp.Piecewise((X, X < Y), (2 * X - Y, X < 2 * Y), (X + Y, True)),
    "piecewise in piecewise": sp.Piecewise((sp.Piecewise((X, Y > 1), (Y * X, True)), X > K), (K * sp.Abs(Y - 1), True)),
    "and, or, not": sp.Piecewise((X, sp.And(X > Y, X > K)), (Y, sp.Or(Y > K, X * Y > 1)), (K, True)),
    "negation": sp.Piecewise((X, sp.Not(sp.And(X > Y, Y >= K))), (Y, True)),
    "parameter kinks": sp.Abs(K - 1) * X + sp.Max(K, 2) + sp.Piecewise((1, K > 1), (X, True)),
}
SMOOTH = {"abs", "max", "min", "max of abs", "piecewise", "piecewise in piecewise", "and, or, not", "negation"}


def printed(expr):
    """Return the expression's value as a function of numbers, with its switches set by its guards, and their number."""
    x, y, k, t = (ca.SX.sym(n) for n in "xykt")
    switches = Switches()
    value = Printer({X: x, Y: y, K: k, T: t}, {X, Y, T}, switches)(expr)
    signs = ca.vertcat(*switches.signs) if switches.signs else ca.SX(0, 1)
    guards = ca.vertcat(*switches.guards) if switches.guards else ca.SX(0, 1)
    f = ca.Function("f", [ca.vertcat(x, y, k, t), signs], [value, guards])

    def evaluate(*numbers):
        sign = np.ones(len(switches.signs))
        for j in range(sign.size):  # a switch may depend on those before it
            if np.array(f(numbers, sign)[1]).ravel()[j] < 0:
                sign[j] = -1
        value, guard = f(numbers, sign)
        assert np.all(np.array(guard) >= 0)
        return float(value)

    return evaluate, len(switches.signs)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_values_are_those_of_sympy(name):
    expr = FUNCTIONS[name]
    mine, _ = printed(expr)
    theirs = sp.lambdify((X, Y, K, T), expr, ["scipy", "numpy"])
    rng = np.random.default_rng(11)
    for point in rng.uniform(0.1, 2.5, (40, 4)):
        assert mine(*point) == pytest.approx(float(theirs(*point)), rel=1e-12, abs=1e-13)


@pytest.mark.parametrize(
    ("expr", "count"),
    [
        (sp.Abs(X), 1),
        (sp.Abs(X) + 2 * sp.Abs(X) ** 2, 1),  # the same kink once
        (sp.Abs(X) + sp.Abs(Y), 2),
        (sp.Abs(K), 0),  # a parameter does not move
        (sp.Max(K, 2), 0),
        (sp.Max(X, Y, K), 2),
        (sp.Piecewise((0, X < K), (X - K, True)), 1),
        (sp.Piecewise((0, sp.And(X < K, Y < K)), (X, True)), 2),
        (sp.Abs(sp.Abs(X) - 1), 2),
        (sp.sin(X), 0),
    ],
)
def test_kinks_of_moving_quantities_are_switches(expr, count):
    assert printed(expr)[1] == count


def test_a_switch_holds_its_branch_beyond_the_kink():
    x = ca.SX.sym("x")
    switches = Switches()
    value = Printer({X: x}, {X}, switches)(sp.Abs(X))
    f = ca.Function("f", [x, switches.signs[0]], [value, switches.guards[0]])
    assert [float(e) for e in f(2, 1)] == [2, 2]
    assert [float(e) for e in f(-2, 1)] == [-2, -2]  # continued smoothly; the guard is what says so
    assert [float(e) for e in f(-2, -1)] == [2, 2]


def test_scopes_keep_switches_apart():
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    switches = Switches()
    for scope, what in (("a", x), ("b", y), ("a", x)):
        Printer({X: what}, {X}, switches, scope=scope)(sp.Abs(X))
    assert len(switches.signs) == 2


def test_integrals_become_sums():
    s = sp.Symbol("s")
    mine, _ = printed(sp.Integral(sp.exp(X * s) * K, (s, 0, 1)) * Y)
    assert mine(0.7, 2.0, 1.5, 0.0) == pytest.approx(1.5 * 2 * (np.exp(0.7) - 1) / 0.7, rel=1e-14)


@pytest.mark.parametrize(
    ("expr", "name"),
    [
        (sp.besselj(0, X), "besselj"),
        (sp.floor(X), "floor"),
        (sp.gamma(X), "gamma"),
        (sp.sign(X), "sign"),
        (sp.Heaviside(X), "Heaviside"),
        (sp.Function("f")(X), "f"),
        (sp.zeta(X), "zeta"),
        (sp.Derivative(sp.Function("f")(X), X), "Derivative"),
    ],
)
def test_unknown_functions_are_refused_by_name(expr, name):
    with pytest.raises(sf.SceneError, match=f"{name}.*has no translation to CasADi; rewrite it"):
        printed(X + expr)


def test_conditions_and_symbols_that_are_not_known_are_refused():
    with pytest.raises(sf.SceneError, match="no value for q"):
        printed(X + sp.Symbol("q"))
    with pytest.raises(sf.SceneError, match="no last branch with the condition True"):
        printed(sp.Piecewise((X, X > 0)))
    with pytest.raises(sf.SceneError, match="condition .* is not one of"):
        printed(sp.Piecewise((X, sp.Eq(X, Y)), (Y, True)))
    with pytest.raises(sf.SceneError, match="condition .* is not one of"):
        printed(sp.Piecewise((X, sp.Xor(X > 0, Y > 0)), (Y, True)))


@pytest.mark.parametrize("name", [n for n in FUNCTIONS if n not in SMOOTH])
def test_derivatives_of_the_printed_graph_are_those_of_sympy(name):
    expr = FUNCTIONS[name]
    x, y, k, t = (ca.SX.sym(n) for n in "xykt")
    value = Printer({X: x, Y: y, K: k, T: t}, {X, Y, T}, Switches())(expr)
    mine = ca.Function("f", [x, y, k, t], [ca.gradient(value, x)])
    theirs = sp.lambdify((X, Y, K, T), expr.diff(X), ["scipy", "numpy"])
    for point in np.random.default_rng(4).uniform(0.2, 0.9, (10, 4)):
        assert float(mine(*point)) == pytest.approx(float(theirs(*point)), rel=1e-10, abs=1e-11)
