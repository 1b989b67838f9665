"""Walks by distinct parts give what SymPy's own walks give, also where those would never end."""

import pytest
import sympy as sp

from symfric.model.tree import parts_of, replaced

x, y = sp.symbols("x y")
EXPRESSIONS = (
    x,
    sp.Integer(3),
    sp.sin(x) + sp.cos(y) * sp.sqrt(x**2 + y**2),
    sp.Piecewise((sp.Abs(x) / x, x > y), (sp.Max(x, y), sp.Mod(x, 2) < 1), (0, True)),
    sp.Integral(sp.exp(-x * y), (y, 0, x)),
    sp.Mul(x, sp.Add(x, x, evaluate=False), evaluate=False),
)


@pytest.mark.parametrize("expr", EXPRESSIONS, ids=str)
def test_parts_and_replacement_are_those_of_sympy(expr):
    for kind in (sp.Pow, sp.Function, sp.Symbol, sp.Mul):
        assert parts_of(expr, kind) == expr.atoms(kind)
    for rule in ({}, {x: y}, {x: sp.Symbol("x", real=True)}, {sp.sin(x): y, x: 2 * y}, {x: 3}):
        assert replaced(expr, rule) == expr.xreplace(rule)


def test_a_part_is_met_once():
    f, nested = sp.Function("f"), x
    for _ in range(60):  # written out it has 2**60 leaves
        nested = f(f(nested), nested)
    assert len(parts_of(nested, f)) == 120
    assert len(parts_of(replaced(nested, {x: y}), f)) == 120
