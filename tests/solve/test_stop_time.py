"""The time of rest: only where nothing moves, also of bodies that no contact holds."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, Y, U, W, P = sp.symbols("x y u w p", real=True)
HELD = sf.Contact("a", U, 1, sf.laws.coulomb(0.5))


def two(y, coupling=0, contacts=(HELD,), start=0.1):
    force = [-X - sp.sin(X) ** 3 - coupling * (X - Y), -Y * (1 + P) - coupling * (Y - X)]
    system = sf.System([X, Y], [U, W], sp.eye(2), force)
    values, initial = {P: 0.5}, {X: start, Y: y, U: 0.0, W: 0.0}
    return sf.Scene(system, contacts, values, initial, 30.0, {"stop": sf.StopTime()})


@pytest.mark.one_in(2)
@pytest.mark.parametrize("route", ["taylor", "integrators"])
@pytest.mark.parametrize("coupling", [0, 1])
def test_a_body_that_no_contact_holds_and_is_released_at_rest(route, coupling):
    run = sf.simulate(two(0.3, coupling), route=route)
    assert np.isnan(run["stop"])


@pytest.mark.parametrize("route", ["taylor", "integrators"])
def test_a_body_that_no_contact_holds_and_nothing_moves(route):
    assert sf.simulate(two(0.0), route=route)["stop"] == 0.0


def test_rest_comes_when_the_last_body_stops():
    friction = sf.Contact("b", W, sp.Rational(1, 20), sf.laws.coulomb(0.5))
    run = sf.simulate(
        two(0.3, 0, (HELD, friction)).wanting({"stop": sf.StopTime(), "log": sf.Events()}), route="taylor"
    )
    assert run["stop"] == run.events[-1].t
    # half cycles of sqrt(3/2), each 2 (.025/1.5) shorter: .3 ends within +-.0167 after nine
    assert run["stop"] == pytest.approx(9 * np.pi / np.sqrt(1.5), abs=1e-9)


def test_many_cases_say_what_single_runs_say():
    program, p = sf.prepare(two(0.3)), np.linspace(0.1, 0.9, 1000)
    batch = program.map({"p": p})
    assert np.array_equal(batch["stop"], [program.run({"p": v})["stop"] for v in p], equal_nan=True)
    program, x = sf.prepare(two(0.0)), np.linspace(-2.0, 2.0, 1000)
    batch = program.map(initial={"x": x})
    assert np.array_equal(batch["stop"], [program.run(initial={"x": v})["stop"] for v in x], equal_nan=True)


@pytest.mark.parametrize(("horizon", "rests"), [(3.0, True), (1.0, False)])
def test_a_ball_on_a_stop_without_friction(horizon, rests):
    floor = sf.Contact("floor", slip=None, normal=sf.Unilateral(X, restitution=0.5))
    system, start = sf.System([X], [U], [[1]], [-9.81]), {X: 1.0, U: 0.0}
    run = sf.simulate(sf.Scene(system, [floor], {}, start, horizon, {"stop": sf.StopTime()}), 1e-11)
    if rests:  # bounces last sqrt(2 h/g) (1 + e)/(1 - e)
        assert run["stop"] == pytest.approx(3 * np.sqrt(2 / 9.81), abs=1e-12)
    else:
        assert np.isnan(run["stop"])
