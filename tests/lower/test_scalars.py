"""Scalars make the expressions that CasADi's own operators make, bit for bit."""

import itertools
import operator

import casadi as ca
import pytest

from symfric import scalars
from symfric.scalars import scalar

A, B, C = (ca.SX.sym(name) for name in "abc")
ENTRIES = [A, B, A * B, A < B, -A, ca.SX(1, 1), *map(ca.SX, (0.0, -0.0, 1.0, -1.0, 2.5, 1e300, ca.inf, float("nan")))]
NUMBERS = [0, 1, -0.0, 0.0, 0.5, 2, True]
BINARY = [getattr(operator, name) for name in ("add", "sub", "mul", "truediv", "lt", "le", "gt", "ge")]


def written(e):
    return ca.Function("f", [A, B, C], [e]).serialize()


@pytest.mark.parametrize("operation", BINARY)
def test_operators(operation):
    for a, b in itertools.product(ENTRIES, ENTRIES + NUMBERS):
        assert written(operation(scalar(a), b)) == written(operation(a, b))
        assert written(operation(b, scalar(a))) == written(operation(b, a))


@pytest.mark.parametrize("exponent", [0.5, 1, 2, 3, -1, -2, 1.5])
def test_powers(exponent):
    for a in ENTRIES:
        assert written(scalar(a) ** exponent) == written(a**exponent)


@pytest.mark.parametrize("name", ["fmax", "logic_and", "logic_or"])
def test_functions_of_two(name):
    for a, b in itertools.product(ENTRIES, ENTRIES + NUMBERS):
        assert written(getattr(scalars, name)(a, b)) == written(getattr(ca, name)(a, b))


def test_functions_of_one_and_choices():
    for a in ENTRIES:
        assert written(-scalar(a)) == written(-a)
        assert written(scalars.fabs(a)) == written(ca.fabs(a))
        assert written(scalars.logic_not(a)) == written(ca.logic_not(a))
        for b, c in itertools.product(ENTRIES, [C, *NUMBERS]):
            assert written(scalars.if_else(a, b, c)) == written(ca.if_else(a, b, c))
            assert written(scalars.if_else(a, c, b)) == written(ca.if_else(a, c, b))


def test_what_is_made_stays_a_scalar():
    a = scalar(A)
    for e in (a + B, B + a, 2 - a, a / 3, a**2, -a, a < 1, scalars.if_else(a, B, 0)):
        assert type(e) is scalars.Scalar
