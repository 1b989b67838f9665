"""What decides whether a residual is zero, and what a mutation must change."""

import pytest
import sympy as sp

from derivations.ledger import Ledger, evaluate, fails, mutants, vanishes

x, y = sp.symbols("x y", real=True)
n = sp.Symbol("n", integer=True)
F, G = sp.symbols("F G", cls=sp.Function)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "zero",
    [
        sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1,
        sp.sqrt(x**2) - sp.Abs(x),
        sp.sin(sp.pi * n),
        (F(x) + G(x)) ** 2 - F(x) ** 2 - 2 * F(x) * G(x) - G(x) ** 2,
        (F(x) * x).diff(x) - x * F(x).diff(x) - F(x),
        F(x).diff(x).subs(x, 2 * y) - sp.Subs(F(x).diff(x), x, 2 * y),
        F(x, y).diff(x, y) - F(x, y).diff(y, x),
        sp.Integral(F(x), (x, 0, 1)) - sp.Integral(2 * F(2 * x), (x, 0, sp.Rational(1, 2))),
    ],
    ids=str,
)
def test_identities_vanish(zero):
    assert vanishes(zero)


@pytest.mark.parametrize(
    "expr",
    [
        sp.Integer(1),
        sp.oo,
        x - y,
        sp.sqrt(x**2) - x,  # zero for positive x
        sp.sin(sp.pi * n / 2),
        F(x) - G(x),
        F(x) - F(y),
        F(x) - F(-x),
        F(x).diff(x),
        F(x).diff(x, 4),
        sp.Integral(F(x), (x, 0, 1)) - F(sp.Rational(1, 2)),
    ],
    ids=str,
)
def test_what_is_no_identity_does_not(expr):
    assert not vanishes(expr)


@pytest.mark.parametrize("nothing", [sp.nan, sp.zoo * x - sp.zoo * x, sp.Function("f", nargs=0)() * sp.nan], ids=str)
def test_what_has_no_value_is_named(nothing):
    with pytest.raises(ValueError, match="no value at any point"):
        vanishes(nothing)


@pytest.mark.parametrize("claim", [0, 1, x, -x, x**2, 1 / x, x - y, sp.sqrt(x) + 1, F(x), sp.Max(0, x)], ids=str)
def test_every_mutant_is_another_claim(claim):
    changed = [mutant for _, mutant in mutants((claim,))]
    assert changed
    assert (claim,) not in changed


def test_a_mutation_without_effect_is_refused():
    with pytest.raises(ValueError, match="another factor leaves oo as it is"):
        list(mutants((sp.oo,)))


LEDGER = Ledger("test", "A ledger whose entries are right, or wrong in one way each")


@LEDGER.verified("right", "a sum, of any function", 2 * F(x))
def _(claim):
    return F(x) + F(x) - claim


@LEDGER.verified("wrong", "a sum", 3 * F(x))
def _(claim):
    return F(x) + F(x) - claim


@LEDGER.corrected("not wrong", "a sum", right=2 * x, printed=x + x, note="the same")
def _(claim):
    return x + x - claim


@LEDGER.verified("blind", "a square", x)
def _(claim):
    return claim**2 - x**2


def test_rows_say_what_is_wrong():
    right, wrong, same, blind = map(evaluate, LEDGER.entries)
    assert (right.residual, right.sound) == ("0", True)
    assert (wrong.residual, wrong.sound) == ("-F(x)", False)
    assert (same.residual, same.sound) == ("0", False)
    assert blind.sound


def test_a_check_that_cannot_fail_is_found():
    right, *_, blind = LEDGER.entries
    assert all(fails(right, claim) for _, claim in mutants(right.right))
    assert [name for name, claim in mutants(blind.right) if not fails(blind, claim)] == ["sign of claim 1"]
