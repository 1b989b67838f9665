"""Intervals with the terms that cancel: they hold all values, and small differences of large terms are narrow."""

import casadi as ca
import numpy as np
import pytest

from symfric.solve.loop.stepping.operation_bounds import Range, operation
from symfric.solve.loop.stepping.trend_bounds import Trend, narrowed, trend_of

ONE = ca.OP_NEG, ca.OP_TWICE, ca.OP_SIN, ca.OP_COS, ca.OP_EXP  # arguments; the last has no rule of its own
TWO = ca.OP_ADD, ca.OP_SUB, ca.OP_MUL
OPERATIONS = [*((op, 1) for op in ONE), *((op, 2) for op in TWO)]


def computed(op, values):
    return float(ca.SX.unary(op, *values) if len(values) == 1 else ca.SX.binary(op, *values))


@pytest.mark.long(beside="test_what_cancels_leaves_a_narrow_interval")
@pytest.mark.parametrize(("op", "count"), OPERATIONS)
def test_all_values_lie_in_the_trend(op, count):
    rng = np.random.default_rng(op)
    for _ in range(60):
        middle = rng.normal(size=count)
        slope, rest = rng.normal(size=count) * 10.0 ** rng.uniform(-4, 0.3), np.abs(rng.normal(size=count)) * 0.1
        ranges = [Range(ca.SX(m), ca.SX(abs(a) + b)) for m, a, b in zip(middle, slope, rest, strict=True)]
        own = operation(op, ranges)
        trend = trend_of(op, ranges, [Trend(ca.SX(a), ca.SX(b)) for a, b in zip(slope, rest, strict=True)], own)
        kept = narrowed(own, trend)
        for _ in range(40):
            s, r = rng.uniform(-1, 1), rng.uniform(-1, 1, size=count)
            away = computed(op, (middle + slope * s + rest * r).tolist()) - float(own.middle)
            assert abs(away - float(trend.slope) * s) <= float(trend.rest) * (1 + 1e-12) + 1e-14
            assert abs(away) <= float(kept.spread) * (1 + 1e-12) + 1e-14


def test_what_cancels_leaves_a_narrow_interval():
    large = Range(ca.SX(1.0), ca.SX(0.5)), Trend(ca.SX(0.5), ca.SX(1e-6))
    close = Range(ca.SX(0.999), ca.SX(0.4995)), Trend(ca.SX(0.4995), ca.SX(1e-6))
    own = operation(ca.OP_SUB, [large[0], close[0]])
    trend = trend_of(ca.OP_SUB, [large[0], close[0]], [large[1], close[1]], own)
    assert float(own.spread) == pytest.approx(0.9995)
    assert float(narrowed(own, trend).spread) == pytest.approx(0.0005 + 2e-6)
