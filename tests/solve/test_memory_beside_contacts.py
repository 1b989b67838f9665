"""Laws with memory beside every other contact: what is explained is what runs, and its numbers are right."""

import itertools

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import symfric as sf
from symfric.solve.status import ADVICE
from tests.solve.memory_pairs import LAWS, OTHERS, SLIPS, SPEED, scene_of

FAMILY = list(itertools.product(LAWS, SLIPS, OTHERS))
STICKING = ("coulomb", "cubic", "spring", "maxwell slip")


@pytest.mark.one_in(600)
@pytest.mark.parametrize(("law", "slip", "other"), FAMILY)
def test_what_is_explained_runs(law, slip, other):
    scene = scene_of(law, slip, other)
    explained, run = sf.explain(scene), sf.simulate(scene)
    assert explained.route == run.route
    assert run.status == sf.Status.OK or ADVICE[run.status]
    assert run.status != sf.Status.OK or (run.t_final == scene.horizon and np.all(np.isfinite(run.final)))


@pytest.mark.one_in(28)
@pytest.mark.parametrize(("slip", "other"), list(itertools.product(SLIPS, STICKING)))
def test_the_implicit_integrator_and_the_series_agree_where_both_can_run(slip, other):
    outputs = {"x": sf.Samples(sp.Symbol("x", real=True), np.linspace(0.1, 2.0, 20)), "top": sf.Max(sf.slip("b"))}
    outputs |= {"least": sf.Min(sf.friction_force("a")), "heat": sf.Integral(sf.dissipated_power("a"))}
    scene = scene_of("aging, soft", slip, other, events=sf.Events(), **outputs)
    run, series = sf.simulate(scene), sf.simulate(scene, 1e-11, "taylor").checked()
    assert (run.route, run.status) == ("integrators", sf.Status.OK)
    assert run.final == pytest.approx(series.final, abs=2e-7)
    for name in outputs:
        assert run[name] == pytest.approx(series[name], abs=1e-6)
    own, theirs = ([e for e in r.events if e.contact == "b"] for r in (run, series))
    assert [e.kind for e in own] == [e.kind for e in theirs]
    assert [e.t for e in own] == pytest.approx([e.t for e in theirs], abs=1e-6)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("other", ["spring", "maxwell slip"])
def test_sliders_beside_creep_yield_and_return_either_way(other):
    scene = scene_of("aging, soft", "bodies", other, horizon=6.0, events=sf.Events()).starting({"w": 1.0})
    run, series = sf.simulate(scene), sf.simulate(scene, 1e-11, "taylor")
    assert (run.route, run.status, series.status) == ("integrators", sf.Status.OK, sf.Status.OK)
    own, theirs = ([e for e in r.events if e.contact == "b"] for r in (run, series))
    assert {1, -1} <= {e.after for e in theirs}
    assert [(e.before, e.after) for e in own] == [(e.before, e.after) for e in theirs]
    assert [e.t for e in own] == pytest.approx([e.t for e in theirs], abs=1e-5)


def creeping(times, mu_b=0.2):
    """The states x, y at times of a body on a rate-and-state contact, and of one on dry ground; by Radau and events."""
    mu0, a, b, D_c, V0, least = 0.6, 0.01, 0.015, 0.05, 0.1, 1e-18

    def rates(t, Y, mode):
        x, y, s, v, z = Y
        w = least * np.sinh(s)
        turns, u = -2 * SPEED * np.sin(2 * t), w + SPEED * np.cos(2 * t)
        F = a * np.arcsinh(w / (2 * V0) * np.exp((mu0 + b * z) / a))
        pull = x - 2 * y + np.sin(2 * t) / 3
        held = 0.0 if mode == 0 else pull - mode * mu_b
        faster = -2 * x + y - u / 10 - F - turns
        return [u, v, faster / np.hypot(w, least), held, (V0 * np.exp(-z) - abs(w)) / D_c], pull

    t, Y, mode = 0.0, np.array([0.5, 0.4, np.arcsinh((0.1 - SPEED) / least), 0.0, 0.0]), 0
    if abs(rates(t, Y, 0)[1]) > mu_b:
        mode = int(np.sign(rates(t, Y, 0)[1]))
    found = np.zeros((2, times.size))
    while t < times[-1]:
        gap = (
            (lambda t, Y, m=mode: mu_b - abs(rates(t, Y, m)[1]))
            if mode == 0
            else (lambda t, Y, m=mode: m * Y[3] + 1e-14)
        )
        gap.terminal, gap.direction = True, -1
        sizes = np.array([1e-11, 1e-11, 1e-9, 1e-11, 1e-10])
        part = solve_ivp(
            lambda t, Y, m=mode: rates(t, Y, m)[0], (t, times[-1]), Y, "Radau", dense_output=True, first_step=min(1e-10, times[-1] - t), rtol=1e-10,
            atol=sizes, events=gap,
        )  # fmt: skip
        inside = (t <= times) & (times <= part.t[-1])
        found[:, inside] = part.sol(times[inside])[:2]
        t, Y = part.t[-1], part.y[:, -1].copy()
        if part.status < 0:  # the slip turns within a rounding of time, and creeps as the forces are in balance
            Y[2] = brentq(lambda s, t=t, Y=Y, m=mode: rates(t, [*Y[:2], s, *Y[3:]], m)[0][2], -25.0, 25.0, xtol=1e-14)
        if part.status == 1 and mode:
            Y[3] = 0.0
            pull = rates(t, Y, 0)[1]
            mode = 0 if abs(pull) <= mu_b else int(np.sign(pull))
        elif part.status == 1:
            mode = int(np.sign(rates(t, Y, 0)[1]))
    return found


@pytest.mark.long(beside="test_sliders_beside_creep_yield_and_return_either_way")
def test_creep_beside_dry_friction_against_an_independent_writing():
    times = np.linspace(0.1, 2.0, 12)
    x, y = sp.symbols("x y", real=True)
    scene = scene_of(
        "aging", "moving belt", "coulomb", x=sf.Samples(x, times), y=sf.Samples(y, times), events=sf.Events()
    )
    run = sf.simulate(scene).checked()
    assert len(run.events) > 0
    reference = creeping(times)
    assert run["x"] == pytest.approx(reference[0], abs=1e-7)
    assert run["y"] == pytest.approx(reference[1], abs=1e-7)


def test_creep_on_a_moving_body_keeps_its_slip_below_the_rounding_of_the_velocities():
    """Friction holds 0.1 of the load: w = 2 V0 sinh(mu/a) exp(-mu0/a), far below 1e-16 of the speed of the belt."""
    x, u = sp.symbols("x u", real=True)
    law = sf.laws.rate_and_state(0.6, 0.01, 0.015, 1e6, 0.1)
    contact = sf.Contact("belt", u - 1, 1, law)
    outputs = {"mu": sf.Samples(sf.friction_force("belt"), [0.5, 1.0]), "u": sf.At(u)}
    scene = sf.Scene(sf.System([x], [u], [[1]], [0.1]), [contact], {}, {x: 0, u: 1}, 1.0, outputs)
    run = sf.simulate(scene).checked()
    assert run["mu"] == pytest.approx([-0.1, -0.1], rel=1e-8)
    assert run["u"] == 1.0


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("law", "other"), [("lugre", "coulomb"), ("aging", "coulomb"), ("aging", "alone")])
def test_derivatives_run_as_explained(law, other):
    scene = scene_of(law, "belt", other)
    run = sf.simulate(scene, sensitivities=["x"])
    assert sf.explain(scene, sensitivities=["x"]).route == run.route
    up, down = (sf.simulate(scene.starting({"x": 0.5 + h})).final for h in (1e-4, -1e-4))
    assert run.sensitivities["x"] == pytest.approx((up - down) / 2e-4, abs=1e-4)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("other", ["coulomb", "maxwell slip"])
def test_many_cases_are_those_one_by_one(other):
    program = sf.prepare(scene_of("slip", "bodies", other, horizon=0.5), 1e-7)
    batch = program.map(initial={"x": [0.5, 0.2]}, threads=2)
    for k, x in enumerate((0.5, 0.2)):
        assert batch.final[:, k] == pytest.approx(program.run(initial={"x": x}).final, abs=0)
    assert list(batch.status) == [0, 0]


def test_a_route_that_is_stated_declines_in_words():
    with pytest.raises(sf.NoRoute, match="'exact' declines"):
        sf.prepare(scene_of("aging", "belt", "coulomb"), route="exact")
    with pytest.raises(sf.NoRoute, match="behind a spring"):
        sf.prepare(scene_of("lugre", "belt", "spring"), route=sf.Integrators("erk"))
