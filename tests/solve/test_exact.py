"""The route `exact` against closed forms, the route `taylor`, and its own limits."""

import math
import pickle
import time

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import symfric as sf
from symfric.solve.loop.stepping import linear_series
from symfric_evidence.bench import larger
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
derandomized = settings(derandomize=True, deadline=None, max_examples=60, database=None)


def free(k, c, x0=1.0, u0=0.0, force=0.0, horizon=8.0):
    system = sf.System([X], [U], [[1]], [force - k * X - c * U])
    return sf.Scene(system, initial={X: x0, U: u0}, horizon=horizon)


def true_motion(k, c, x0, u0, force, t):
    """x'' + c x' + k x = force with fifty digits, by the exponential of a matrix."""
    with mpmath.workdps(50):
        A = mpmath.matrix([[0, 1, 0], [-mpmath.mpf(k), -mpmath.mpf(c), mpmath.mpf(force)], [0, 0, 0]])
        y = mpmath.expm(A * mpmath.mpf(t), method="pade") * mpmath.matrix([x0, u0, 1])
        return float(y[0]), float(y[1])


@pytest.mark.one_in(9)
@pytest.mark.parametrize("force", [0.0, 0.7])
@pytest.mark.parametrize(
    ("k", "c"),
    [
        (1.0, 0.1),
        (1.0, 2.0),
        (1.0, math.nextafter(2.0, 0)),
        (1.0, math.nextafter(2.0, 3)),
        (1.0, 2.0 + 1e-7),
        (1.0, 5.0),
        (1.0, 0.0),
        (0.0, 0.0),
        (0.0, 0.3),
        (1e-14, 0.3),
        (1e-14, 0.0),
        (0.0, 50.0),
        (1.0, -0.2),
        (-1.0, 0.0),
        (-0.5, 0.4),
        (1e-6, -1e-6),
    ],
)
def test_every_damping_case_is_the_exponential_of_its_matrix(k, c, force):
    run = sf.simulate(free(k, c, 1.0, -0.4, force), route="exact").checked()
    for t in (1e-8, 0.01, 0.6, 2.3, 8.0):
        true = true_motion(k, c, 1.0, -0.4, force, t)
        assert run(t) == pytest.approx(true, rel=1e-13, abs=1e-13)
    assert run.final == pytest.approx(true, rel=1e-14, abs=2e-14)


@pytest.mark.parametrize("c", [100.0, 1e4, 1e6])
def test_long_overdamped_motions_neither_overflow_nor_take_more_steps(c):
    run = sf.simulate(free(1.0, c, horizon=3 * c).wanting({"end": sf.End(), "low": sf.Min(U)}), route="exact")
    slow = 2 / (c + math.sqrt(c * c - 4))
    left = math.exp(-3 * c * slow) / (1 - slow**2)
    assert run.final == pytest.approx([left, -slow * left], rel=1e-10)
    assert run.stats["steps"] == 1
    assert run["low"] == pytest.approx(-1 / c, rel=0.01)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("k", "c"), [(1.0, 0.1), (1.0, 2.0), (1.0, 3.0), (1.0, -0.05), (0.0, 0.5)])
def test_extremes_are_those_of_the_dense_output(k, c):
    wanted = {"path": sf.Trajectory(), "high": sf.Max(X + 2 * U), "low": sf.Min(X), "half": sf.HalfRange(U - X)}
    run = sf.simulate(free(k, c, 1.0, -0.4, 0.3, horizon=30.0).wanting(wanted), route="exact")
    x, u = run(np.linspace(0, 30, 200_001))
    assert run["high"] == pytest.approx(np.max(x + 2 * u), abs=2e-8)
    assert run["low"] == pytest.approx(np.min(x), abs=2e-8)
    assert run["half"] == pytest.approx(0.5 * np.ptp(u - x), abs=2e-8)


def drive_slide(mu1, mu2, p_star, eps, horizon=60.0, start=0.0):
    """Guida (2), (8) in the v-scaling: w = x' falls from the drive's speed; sticks at w = -1; no jump but at rest."""
    breaks = [0.0, 1 + p_star]  # sliding speed 1 + w
    values = [5.0, 5.0 + 2 * mu1 * (1 + p_star)]
    law = sf.laws.piecewise_linear(5.0 + eps * (1 + p_star), breaks, values, 2 * mu2)
    system = sf.System([X], [U], [[1]], [-X + law.kinetic.args[1].expr.subs(sf.SPEED, 1)])
    contact = sf.Contact("bed", 1 + U, 1, law)
    return sf.Scene(system, [contact], {}, {X: start, U: -1.0}, horizon)


REFERENCES = [(-0.1, 0.5, -0.1, 6.3940747605571819), (-0.3, 0.3, -0.2, 1.8590993575312826)]
REFERENCES += [(-0.6, 0.2, -0.5, 1.8350164158298183), (-0.9, 0.5, -0.4, 7.5763089731579039)]


@pytest.mark.parametrize(("mu1", "mu2", "p_star", "threshold"), REFERENCES)
def test_a_drive_slide_cycles_just_above_its_threshold_and_decays_just_below(mu1, mu2, p_star, threshold):
    for part, cycles in ((-1e-9, False), (1e-9, True)):
        scene = drive_slide(mu1, mu2, p_star, threshold * (1 + part), horizon=400.0, start=-20.0)
        run = sf.simulate(scene.wanting({"events": sf.Events()}))
        assert run.route == "exact"
        assert (run.checked().stats["events"] > 10) == cycles


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("mu1", "mu2", "p_star", "eps"),
    [
        (-0.3, 0.3, -0.2, 1.9),
        (-1.0, 0.5, -0.3, 20.0),
        (-1.0, 1.0, -0.3, 3e5),
        (-0.5, 0.999, -0.2, 1e6),
        (-0.3, 0.3, -1e-12, 1.0),
        (-0.3, 0.3, -1e-4, 3.0),
        (-0.3, 0.3, -1 + 1e-9, 5e9),
        (-1.5, 2.0, -0.5, 1e3),
        (-0.2, 30.0, -0.5, 100.0),
    ],
)
def test_drive_slides_at_the_edges_of_their_parameters(mu1, mu2, p_star, eps):
    scene = drive_slide(mu1, mu2, p_star, eps)
    run, other = sf.simulate(scene), sf.simulate(scene, 1e-14, "taylor")
    assert run.route == "exact"
    scale = 1 + np.max(np.abs(other.x), axis=1)
    assert np.max(np.abs(run.final - other.final) / scale) < 1e-11
    assert run.checked().stats["events"] == other.checked().stats["events"]
    assert run.energy_residual() < 1e-12


def test_a_stick_of_fifty_thousand_time_units_ends_at_the_static_bound():
    # released at x = mu_s load / k
    law = sf.laws.coulomb(0.5, 0.3)
    scene = sf.Scene(
        sf.System([X], [U], [[1]], [-X]), [sf.Contact("belt", U - 1e-5, 1, law)], {}, {X: 0.0, U: 1e-5}, 6e4
    )
    run = sf.simulate(scene.wanting({"events": sf.Events(), "end": sf.End()})).checked()
    assert run.events[0].t == pytest.approx(0.5e5, rel=1e-14)
    assert run.events[0].after == -1


@pytest.mark.parametrize("n", [1, 2, 7, 50, 333])
@pytest.mark.parametrize("omega_n", [1.0, 0.3, 1e4])
def test_stops_exactly_at_the_static_bound(n, omega_n):
    run = sf.simulate(sf.scenes.coulomb_oscillator(1 / (2 * n + 1), omega_n=omega_n))
    assert run.route == "exact"
    assert run["stop_time"] == pytest.approx(n * math.pi / omega_n, rel=1e-14)
    assert run.stats["events"] == n
    assert run.final == pytest.approx([(-1) ** n / (2 * n + 1), 0], abs=1e-12)


def test_a_touch_without_a_crossing_is_no_event_and_a_shallow_one_is():
    # u = v sin t from x = v: touches the belt's speed in one point; a little more crosses it
    law = sf.laws.coulomb(0.01)
    for more, events in ((-1e-12, 0), (1e-9, 2)):
        scene = sf.scenes.mass_on_belt(law, v_b=0.2, beta=0.0, horizon=20.0).starting({"x": 0.01 - 0.2 - more})
        run = sf.simulate(scene)
        assert run.route == "exact"
        assert run.checked().stats["events"] == events


@pytest.mark.parametrize("gamma2", [0.0, 1e-12])
def test_without_a_load_the_motion_is_free(gamma2):
    run = sf.simulate(
        sf.scenes.mass_on_belt(sf.laws.coulomb(0.4), v_b=0.2, gamma2=gamma2, beta=0.0, horizon=10.0).starting({"x": 1})
    )
    assert run.route == "exact"
    assert run.checked().final == pytest.approx([math.cos(10), -math.sin(10)], abs=1e-11)


def test_a_regularised_law_passes_through_zero_without_sticking():
    scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.04).regularised(1e-4)
    run, other = sf.simulate(scene), sf.simulate(scene, 1e-13, "taylor")
    assert run.route == "exact"
    assert run.checked().final == pytest.approx(other.checked().final, abs=1e-11)
    assert [(e.before, e.after) for e in run.events] == [(e.before, e.after) for e in other.events]
    assert run.stats["events"] > 10
    assert run.energy_residual() < 1e-12


def number(low, high):
    return st.floats(low, high).map(lambda z: round(z, 6))


CHAINS = {}


def chain(n, contacts):
    """Return masses in a row with symbols for all numbers, prepared for both routes."""
    if (n, contacts) in CHAINS:
        return CHAINS[n, contacts]
    q, u = (sp.symbols(f"{a}0:{n}", real=True) for a in "qu")
    k, c, v, N = (sp.symbols(f"{a}0:4", real=True) for a in ("k", "c", "v", "N"))
    stretch = [q[i] - (q[i - 1] if i else 0) for i in range(n)]
    rate = [u[i] - (u[i - 1] if i else 0) for i in range(n)]
    pull = [k[i] * stretch[i] + c[i] * rate[i] for i in range(n)]
    force = [(pull[i + 1] if i + 1 < n else 0) - pull[i] for i in range(n)]
    laws = [
        sf.laws.piecewise_linear(0.5, [0, 0.3], [0.4, 0.3], 0.1),
        sf.laws.coulomb(0.4, 0.3),
        sf.laws.piecewise_linear(0.4, [0], [0.35], -0.05),
    ]
    slips = [u[0] - v[0], u[-1] - v[1], (u[1] - u[0] if n > 1 else 2 * u[0]) - v[2]]
    dry = [sf.Contact(f"c{i}", slips[i], N[i], laws[i]) for i in range(contacts)]
    symbols = [*k[:n], *c[:n], *v[:contacts], *N[:contacts]]
    scene = sf.Scene(
        sf.System(q, u, sp.eye(n) + sp.diag(*range(n)) / 2, force),
        dry,
        dict.fromkeys(symbols, 1.0),
        dict.fromkeys([*q, *u], 0.0),
        15.0,
        {"path": sf.Trajectory(), "high": sf.Max(q[-1] + u[0]), "area": sf.Integral(q[0])},
    )
    CHAINS[n, contacts] = sf.prepare(scene, route="exact"), sf.prepare(scene, 1e-13, sf.Taylor(order=14))
    return CHAINS[n, contacts]


def test_loops_over_the_entries_of_the_matrices_agree_with_straight_lines(monkeypatch):
    scene = larger.chain(3)
    scene = scene.wanting({"high": sf.Max(scene.system.q[2]), "area": sf.Integral(scene.system.q[0])})
    flat = sf.prepare(scene, route="exact").run().checked()
    monkeypatch.setattr(linear_series, "MOST", 0)
    looped = sf.prepare(scene, route="exact").run().checked()
    assert flat.stats == looped.stats
    assert flat.stats["events"] == 18
    assert looped.final == pytest.approx(flat.final, abs=1e-13)
    assert [looped["high"], looped["area"]] == pytest.approx([flat["high"], flat["area"]], abs=1e-13)


@pytest.mark.parametrize("shape", longer([(1, 2), (2, 3), (3, 1), (4, 2)], [(1, 2), (3, 1), (4, 2)]), ids=str)
@settings(derandomized, max_examples=25)
@given(
    k=st.lists(number(0.0, 4.0), min_size=4, max_size=4),
    c=st.lists(number(0.0, 1.0), min_size=4, max_size=4),
    v=st.lists(number(-0.5, 0.5), min_size=3, max_size=3),
    N=st.lists(number(0.1, 1.5), min_size=3, max_size=3),
    start=st.lists(number(-1.0, 1.0), min_size=8, max_size=8),
)
def test_random_scenes_agree_with_taylor(shape, k, c, v, N, start):
    exact, taylor = chain(*shape)
    numbers = {f"{a}{i}": z for a, row in zip("kcvN", (k, c, v, N), strict=True) for i, z in enumerate(row)}
    names = {s.name for s in exact.scene.values}
    values = {a: z for a, z in numbers.items() if a in names}
    initial = dict(zip(exact.scene.initial, start, strict=False))
    run, other = exact.run(values, initial).checked(), taylor.run(values, initial).checked()
    scale = 1 + np.max(np.abs(other.x))
    assert np.max(np.abs(run.final - other.final)) < 1e-11 * scale
    t = np.linspace(0, 15, 60)
    assert np.max(np.abs(run(t) - other(t))) < 1e-11 * scale
    assert abs(run["high"] - other["high"]) < 1e-11 * scale
    assert abs(run["area"] - other["area"]) < 1e-10 * scale
    assert run.energy_residual() < 1e-12


@derandomized
@given(
    values=st.fixed_dictionaries(
        {
            "k": st.sampled_from([0.0, 1.0, -0.05, 3.0, 1e-9]),
            "c": st.sampled_from([0.0, 0.1, 2.0, 2 * math.sqrt(3), -0.05, 10.0]),
            "F": number(-1, 1),
            "v": st.sampled_from([0.0, 0.2, -0.3, 0.01]),
            "N": number(0.05, 1.5),
            "slope": number(-0.3, 0.3),
        }
    ),
    x=number(-2, 2),
    u=number(-1, 1),
)
def test_random_oscillators_in_closed_form_agree_with_taylor(values, x, u):
    if not CHAINS.get("one"):
        k, c, F, v, N, slope = sp.symbols("k c F v N slope", real=True)
        law = sf.laws.piecewise_linear(0.45, [0, 0.2, 0.5], [0.4, 0.25, 0.3], slope)
        wanted = {"path": sf.Trajectory(), "high": sf.Max(X - U), "low": sf.Min(2 * X - sf.friction_force("belt"))}
        scene = sf.Scene(
            sf.System([X], [U], [[2]], [F - k * X - c * U]),
            [sf.Contact("belt", 2 * U - v, N, law)],
            dict.fromkeys([k, c, F, v, N, slope], 1.0),
            {X: 0.0, U: 0.0},
            20.0,
            wanted,
        )
        CHAINS["one"] = sf.prepare(scene, route="exact"), sf.prepare(scene, 1e-14, "taylor")
    run, other = (p.run(values, {X: x, U: u}).checked() for p in CHAINS["one"])
    scale, t = 1 + np.max(np.abs(other.x)), np.linspace(0, 20, 99)
    assert np.max(np.abs(run.final - other.final)) < 1e-11 * scale
    assert np.max(np.abs(run(t) - other(t))) < 1e-11 * scale
    assert abs(run["high"] - other["high"]) + abs(run["low"] - other["low"]) < 1e-11 * scale


def test_a_chain_of_ten_masses_with_ten_contacts():
    q, u = (sp.symbols(f"{a}0:10", real=True) for a in "qu")
    pull = [q[i] + u[i] / 50 - (q[i - 1] + u[i - 1] / 50 if i else 0) for i in range(10)]
    force = [(pull[i + 1] if i < 9 else 0) - pull[i] for i in range(10)]
    law = sf.laws.piecewise_linear(0.4, [0, 0.3], [0.35, 0.2], 0.05)
    dry = [sf.Contact(f"c{i}", u[i] - 0.2, 0.5 + 0.1 * i, law) for i in range(10)]
    initial = {**dict.fromkeys(q, 0.0), **{a: 0.1 * (i % 3) for i, a in enumerate(u)}}
    run = sf.simulate(sf.Scene(sf.System(q, u, sp.eye(10), force), dry, {}, initial, 100.0))
    assert run.route == "exact"
    assert run.checked().stats["events"] > 100
    assert run.energy_residual() < 1e-12


def test_harmonics_powers_of_time_samples_and_kinks_are_linear_between_events():
    t, a_g = sf.TIME, sp.Symbol("a_g", real=True)
    force = -X - U / 10 + sp.sin(2 * t + 0.3) * 0.4 + t**2 / 100 - (t - 1) * t / 10 + sp.Abs(X) / 3 - a_g
    signal = sf.Signal(np.random.default_rng(0).normal(size=100), 0.1)
    scene = sf.Scene(
        sf.System([X], [U], [[1]], [force]),
        [sf.Contact("floor", U, 1 + sp.cos(3 * t) / 5, sf.laws.coulomb(0.3))],
        {},
        {X: 1.0, U: 0.0},
        20.0,
        {"high": sf.Max(X + sp.sin(2 * t)), "path": sf.Trajectory()},
        {a_g: signal},
    )
    run, other = sf.simulate(scene, route="exact").checked(), sf.simulate(scene, 1e-13, "taylor").checked()
    assert run.names == ("x", "u")
    assert run.x.shape[0] == run.final.size == 2
    assert run.final == pytest.approx(other.final, abs=1e-11)
    assert run["high"] == pytest.approx(other["high"], abs=1e-11)
    assert run.stats["events"] == other.stats["events"] > 4


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"force": [-sp.sin(X)]}, "not linear"),
        ({"force": [-(X**3)]}, "not linear"),
        ({"mass": [[1 + X**2]]}, "not linear"),
        ({"law": sf.laws.cubic(0.4, 0.25, 0.5)}, "not made of straight lines"),
        ({"law": sf.laws.coulomb(0.3).averaged(0.2)}, "straight lines"),
        ({"slip": U - sp.sin(sf.TIME)}, "slip of contact 'floor' depends on time"),
        ({"normal": 1 + X**2}, "not linear"),
        ({"force": [-X * sp.sin(sf.TIME)]}, "not linear"),
        ({"force": [sp.sin(sf.TIME**2)]}, "no harmonic"),
        ({"outputs": {"work": sf.Integral(X * U)}}, "wanted output is not linear"),
    ],
)
def test_what_is_not_linear_is_declined_with_the_reason(change, reason):
    parts = {"mass": [[1]], "force": [-X], "law": sf.laws.coulomb(0.3), "slip": U, "normal": 1} | change
    scene = sf.Scene(
        sf.System([X], [U], parts["mass"], parts["force"]),
        [sf.Contact("floor", parts["slip"], parts["normal"], parts["law"])],
        {},
        {X: 1.0, U: 0.0},
        5.0,
        parts.get("outputs"),
    )
    with pytest.raises(sf.NoRoute, match=f"'exact' declines.*{reason}"):
        sf.simulate(scene, route="exact")
    told = sf.explain(scene)
    assert told.route == sf.simulate(scene, 1e-6).route == "taylor"
    assert reason in told.answers["exact"]


def test_it_is_chosen_where_it_is_cheapest_and_says_so():
    told = sf.explain(sf.scenes.coulomb_oscillator(0.1))
    assert told.route == "exact"
    assert "closed form" in told.answers["exact"]
    assert sf.simulate(sf.scenes.coulomb_oscillator(0.1)).route == "exact"
    excited = sf.scenes.mass_on_belt(sf.laws.coulomb(0.3), v_b=0.2, a=0.01, Omega=9.0)
    assert sf.explain(excited).route == sf.simulate(excited).route == "taylor"


def test_a_program_goes_on_where_other_numbers_leave_the_closed_form():
    k3 = sp.Symbol("k3", real=True)
    scene = sf.Scene(
        sf.System([X], [U], [[1]], [-X - k3 * X**3]),
        [sf.Contact("floor", U, 1, sf.laws.coulomb(0.1))],
        {k3: 0.0},
        {X: 1.0, U: 0.0},
        5.0,
    )
    program = sf.prepare(scene, 1e-12)
    assert program.run().route == "exact"
    run = program.run({"k3": 0.5})
    assert run.route == "taylor"
    assert run.final == pytest.approx(sf.simulate(scene.where({"k3": 0.5}), 1e-12).final, abs=1e-11)
    belt = sf.prepare(sf.scenes.mass_on_belt(sf.laws.coulomb(0.3), v_b=0.2, horizon=9.0))
    driven = {"a": 0.01, "Omega": 9.0}
    true = sf.simulate(sf.scenes.mass_on_belt(sf.laws.coulomb(0.3), v_b=0.2, horizon=9.0, **driven), 1e-13)
    assert belt.run(driven).final == pytest.approx(true.final, abs=1e-11)


@pytest.mark.parametrize("budget", [1, 5, 100])
def test_budgets_room_and_pickling(budget):
    scene = sf.scenes.coulomb_oscillator(0.0005)
    run = sf.simulate(scene, route=sf.Exact(max_events=budget))
    assert run.status == sf.Status.EVENT_BUDGET
    assert run(run.t_final) == pytest.approx(run.final, abs=1e-12)
    steps = sf.simulate(scene, route=sf.Exact(max_steps=budget))
    assert steps.status == sf.Status.STEP_BUDGET
    assert steps.stats["steps"] == budget
    program = sf.prepare(scene)
    whole = program.run().checked()
    assert whole.stats["events"] == 1000
    assert np.array_equal(pickle.loads(pickle.dumps(program)).run().x, whole.x)
    for kind in ("max_steps", "max_events"):
        with pytest.raises(sf.SceneError, match=f"{kind} is 0; give a whole number"):
            sf.Exact(**{kind: 0})


def test_a_motion_that_explodes_ends_with_a_status():
    run = sf.simulate(free(1.0, -3.0, horizon=1e4).wanting({"end": sf.End()}), route="exact")
    assert run.status == sf.Status.NOT_FINITE


def busy(call, n):
    begin = time.process_time()
    for _ in range(n):
        call()
    return time.process_time() - begin


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "scene", [sf.scenes.coulomb_oscillator(0.03), drive_slide(-0.3, 0.3, -0.2, 1.9)], ids=["P1", "drive slide"]
)
def test_it_is_faster_than_taylor(scene):
    scene = scene.wanting({"end": sf.End()})
    routes = [sf.prepare(scene, 1e-9, name) for name in ("exact", "taylor")]
    times = np.array([[busy(program.run, 300) for program in routes] for _ in range(15)])
    assert np.median(times[:, 1] / times[:, 0]) > 1
