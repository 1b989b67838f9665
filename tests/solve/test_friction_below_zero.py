"""Coefficients of friction and profiles that become negative end a run by every route, at the same time and place."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u, a = sp.symbols("x u a", real=True)
mu_s, mu_k, p = sp.symbols("mu_s mu_k p", real=True)
DT = 0.05


def shaken():
    t = DT * np.arange(200)
    return sf.Signal(2.0 * np.sin(1.7 * t) + 1.1 * np.sin(4.1 * t + 1), DT)


def recorded(profile, start=(0.0, 0.0), values=(), law=None, side=1):
    """A mass on a floor, under a record; `side` -1 gives its mirror image."""
    law = sf.laws.coulomb(0.3) if law is None else law
    profile = profile.subs(x, side * x)
    system = sf.System([x], [u], [[1]], [-0.8 * x - 0.1 * u - side * a])
    floor = sf.Contact("floor", u, 2, law, profile=profile)
    initial = {x: side * start[0], u: side * start[1]}
    return sf.Scene(system, [floor], dict(values), initial, 10.0, inputs={a: shaken()})


def oscillator(values):
    system = sf.System([x], [u], [[1]], [-x])
    return sf.Scene(system, [sf.Contact("floor", u, 1, sf.laws.coulomb(mu_s, mu_k))], values, {x: 1.0, u: 1.0}, 20.0)


@pytest.mark.parametrize(
    ("values", "which"), [({mu_s: 0.3, mu_k: -0.1}, "kinetic"), ({mu_s: -0.3, mu_k: 0.1}, "static")]
)
def test_numbers_are_refused(values, which):
    with pytest.raises(sf.SceneError, match=f"the {which} coefficient at rest is -0.*; it must not be negative"):
        oscillator(values)
    system = sf.System([x], [u], [[1]], [-x])
    with pytest.raises(sf.SceneError, match="negative"):
        sf.Scene(system, [sf.Contact("floor", u, 1, sf.laws.coulomb(*values.values()))], {}, {x: 1.0, u: 1.0}, 20.0)


@pytest.mark.parametrize("route", ["exact", "taylor", "integrators"])
@pytest.mark.parametrize("values", [{"mu_k": -0.05}, {"mu_k": 0.2}, {"mu_s": -0.1, "mu_k": -0.1}], ids=str)
def test_values_of_a_run_are_refused(route, values):
    program = sf.prepare(oscillator({mu_s: 0.1, mu_k: 0.05}), route=route)
    if route == "integrators":  # which looks at every value
        with pytest.raises(sf.SceneError, match=r"negative|smaller than the kinetic one"):
            program.run(values)
    else:
        assert program.run(values).status == sf.Status.UNDECIDED
    assert program.run({"mu_s": 0.05, "mu_k": 0.0}).status == sf.Status.OK
    assert program.run({"mu_s": 0.0, "mu_k": 0.0}).status == sf.Status.OK


def test_cases_of_a_sweep_are_refused_by_their_status():
    scene = oscillator({mu_s: 0.1, mu_k: 0.05}).wanting({"largest": sf.Max(x)})
    table = sf.sweep(scene, {"mu_k": np.array([-0.05, 0.0, 0.05, 0.2])})
    assert [sf.Status(s) for s in table["status"].values] == [sf.Status.UNDECIDED, 0, 0, sf.Status.UNDECIDED]


@pytest.mark.parametrize("values", [{"mu_k": -0.05}, {"mu_k": 0.5}], ids=str)
def test_coefficients_under_a_record(values):
    scene = recorded(sp.Integer(1), values={mu_s: 0.3, mu_k: 0.2}, law=sf.laws.coulomb(mu_s, mu_k))
    for route in ("exact", "taylor"):
        program = sf.prepare(scene, route=route)
        assert program.run(values).status == sf.Status.UNDECIDED
        assert program.run().status == sf.Status.OK


PROFILES = {
    "falls": 1 - 2 * p * x,
    "rises": 1 + 3 * p * x,
    "negative beyond an edge": sp.Piecewise((1, x < 0.4 * p), (-0.5, True)),
    "negative patch": sp.Piecewise((1, x < 0.3 * p), (-0.1, x < 0.35 * p), (0.5, True)),
    "falls in a cell and rises in the next": sp.Piecewise(
        (1, x < 0.1), (1.4 - 4 * p * x, x < 0.4), (-1.8 + 4 * p * x, True)
    ),
    "dent": sp.Abs(x - 0.3 * p) - 0.1,
}


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("name", PROFILES)
def test_a_profile_ends_a_run_where_it_becomes_negative(name, side):
    runs = [sf.simulate(recorded(PROFILES[name], values={p: 1.0}, side=side), 1e-11, r) for r in ("exact", "taylor")]
    assert [run.status for run in runs] == [sf.Status.LOST_CONTACT] * 2
    assert runs[0].t_final == pytest.approx(runs[1].t_final, abs=1e-8)
    assert runs[0].final == pytest.approx(runs[1].final, abs=1e-8)
    assert 0 < runs[0].t_final < 10


@pytest.mark.parametrize(("place", "speed"), [(0.5, 0.0), (0.5, 0.3), (0.6, 0.0), (0.45, -0.2)])
def test_a_start_where_it_is_negative(place, speed):
    scene = recorded(sp.Piecewise((1, x < 0.4), (1 - p, x < 0.7), (1, True)), (place, speed), {p: 0.0})
    for route in ("exact", "taylor"):
        run = sf.prepare(scene, route=route).run({"p": 1.5})
        assert (run.status, run.t_final) == (sf.Status.LOST_CONTACT, 0.0)
        assert run.final == pytest.approx([place, speed])


@pytest.mark.parametrize("profile", [sp.Abs(x - p / 10), 0.7 * sp.Abs(x - 0.3 * p), sp.Max(0, p - 2 * x)], ids=str)
def test_a_profile_that_touches_zero_goes_on(profile):
    runs = [sf.simulate(recorded(profile, values={p: 1.0}), 1e-11, r).checked() for r in ("exact", "taylor")]
    assert runs[0].final == pytest.approx(runs[1].final, abs=1e-8)


@pytest.mark.parametrize("steps", [1, 20, 111])
def test_a_run_under_a_record_that_ends_early_says_where(steps):
    scene = recorded(sp.Integer(1), (0.5, 1.0))
    run = sf.simulate(scene, route=sf.Exact(max_steps=steps))
    assert run.status == sf.Status.STEP_BUDGET
    assert 0 < run.t_final < 10
    assert run.final == pytest.approx(sf.simulate(scene)(run.t_final), abs=1e-12)
