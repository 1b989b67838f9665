"""What is computed at instants may jump: with the state, and with time at the very instant, to rounding."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u, r = sp.symbols("x u r", real=True)
COUNTS = [(0.29, 100, 29.0), (0.01, 30, 3 * 0.1), (0.1, 3, 0.3), (0.7, 10, 7.0), (0.15, 2, 0.3), (1 / 3, 3, 1.0)]


def swinging(held, horizon, **more):
    system = sf.System([x], [u], [[1]], [-x + 0 * r * u + sum(0 * h.symbol for h in held)])
    return sf.Scene(system, [], {}, {x: 1.0, u: 0.0}, horizon, held=held, **more)


WRITTEN = {
    "condition": lambda at: sp.Piecewise((0, sf.TIME < at), (1, True)),
    "other side": lambda at: sp.Piecewise((1, at <= sf.TIME), (0, True)),
    "Heaviside": lambda at: sp.Heaviside(sf.TIME - at),
    "sign": lambda at: (1 + sp.sign(sf.TIME - at)) / 2,
    "floor": lambda at: sp.floor(sf.TIME / at),
    "ceiling": lambda at: sp.ceiling(sf.TIME / at) - 1 + sp.S.Zero,
    "phase": lambda at: sp.Piecewise((0, sp.Mod(sf.TIME, 2 * at) < at), (1, True)),
    "frac": lambda at: sp.Piecewise((0, sp.frac(sf.TIME / (2 * at)) < 0.5), (1, True)),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("period", "count", "at"), COUNTS)
@pytest.mark.parametrize("written", WRITTEN)
def test_a_sample_at_a_step_in_time_comes_after_it(written, period, count, at):
    held = sf.Held("c", WRITTEN[written](at), every=period)
    run = sf.simulate(swinging([held], (count + 1.5) * period)).checked()
    assert run.jumps_of("c")[run.jumps_of("c") > 0] == pytest.approx([count * period], rel=1e-12)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("route", ["taylor", "exact", "integrators"])
@pytest.mark.parametrize(("period", "count", "at"), COUNTS)
def test_a_sample_at_a_held_value_of_an_input_has_it(period, count, at, route):
    held = sf.Held("c", r, every=period)
    scene = swinging([held], (count + 1.5) * period, inputs={r: sf.Signal([0.0, 1.0, 1.0], at, hold=True)})
    tolerance = 1e-8 if route == "integrators" else 1e-12
    run = sf.simulate(scene, tolerance, route).checked()
    assert run.jumps_of("c") == pytest.approx([count * period], rel=1e-12)


def test_functions_that_jump_with_the_state_are_evaluated():
    functions = {
        "floor": (sp.floor(3 * x) / 3, lambda v: np.floor(3 * v) / 3),
        "ceiling": (sp.ceiling(3 * x) / 3, lambda v: np.ceil(3 * v) / 3),
        "frac": (sp.frac(2 * x), lambda v: 2 * v - np.floor(2 * v)),
        "mod": (sp.Mod(x, 0.3), lambda v: np.mod(v, 0.3)),
        "heaviside": (sp.Heaviside(x - 0.2), lambda v: np.heaviside(v - 0.2, 1)),
        "sign": (sp.sign(x - 0.2), lambda v: np.sign(v - 0.2)),
        "nested": (sp.floor(10 * sp.Mod(x, 0.25)) * sp.Max(x, 0), lambda v: np.floor(10 * np.mod(v, 0.25)) * max(v, 0)),
    }
    held = [sf.Held(name, e, every=0.1) for name, (e, _) in functions.items()]
    times = 0.1 * np.arange(60)
    wanted = {h.name: sf.Samples(h.symbol, times + 0.05) for h in held}
    run = sf.simulate(swinging(held, 7.0, outputs=wanted), 1e-12).checked()
    for name, (_, function) in functions.items():
        assert run[name] == pytest.approx([function(v) for v in np.cos(times)], abs=1e-9), name


def test_a_reset_may_jump_with_state_and_time():
    last = sp.Piecewise((1, sf.TIME < 0.3), (-1, True))
    reset = sf.Reset(every=0.1, offset=0.1, set={u: sp.floor(4 * u) / 4 * last})
    run = sf.simulate(
        sf.Scene(sf.System([x], [u], [[1]], [1]), [], {}, {x: 0.0, u: 0.4}, 0.35, resets=[reset])
    ).checked()
    speed = 0.4
    for k in (1, 2, 3):
        speed = np.floor(4 * (speed + 0.1)) / 4 * (1 if k < 3 else -1)
    assert run.final[1] == pytest.approx(speed + 0.05, abs=1e-9)
