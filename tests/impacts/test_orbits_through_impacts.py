"""Multipliers of random impact orbits, and what stands on many runs: maps, exponents, sections, basins."""

import math
from functools import cache

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

import symfric as sf
from tests.longer import longer

X, U, Y, V = sp.symbols("x u y v", real=True)
Z, R, W, MU, C, P = sp.symbols("z r w mu c p", positive=True)


def oscillator():
    """Return an oscillator under ``cos(w t + c)`` whose stop is its place of rest; an impact may be at time zero."""
    system = sf.System([X], [U], [[1]], [-2 * Z * U - X + sp.cos(W * sf.TIME + C)])
    stop = sf.Contact("stop", None, sf.Unilateral(-X, restitution=R))
    return sf.Scene(system, [stop], {Z: 0.05, R: 0.7, W: 2.2, C: 0.0}, {X: -0.3, U: 0.0}, 200.0)


def closed_orbit(z, r, w):
    """Return phase and velocity before the impact of the orbit with one impact a period, and its monodromy matrix.

    With the flow ``y(T) = Phi (y(0) - K n) + K n`` of a period, n = (cos, sin) of the phase at its start, the orbit has
    ``(0, -v/r) = Phi (0, v) + (I - Phi) K n``: linear in n/v, whose length gives v.
    """
    period = 2 * math.pi / w
    A = np.array([[0.0, 1.0], [-1.0, -2 * z]])
    flow = expm(A * period)
    gain = 1 / complex(1 - w * w, 2 * z * w)  # x = Re(gain exp(i (w t + phase)))
    K = np.array([[gain.real, -gain.imag], [-w * gain.imag, -w * gain.real]])
    direction = np.linalg.solve((np.eye(2) - flow) @ K, np.array([0.0, -1 / r]) - flow @ [0.0, 1.0])
    after = -1 / np.hypot(*direction)  # away from the stop
    cosine, sine = after * direction
    before = -after / r
    push = cosine  # the force at the impact; the spring has none there
    jump = (push - 2 * z * after + r * (push - 2 * z * before)) / before
    return math.atan2(sine, cosine), before, np.array([[-r, 0.0], [jump, -r]]) @ flow


def stays_below(z, r, w, phase, before):
    """Whether that motion does not reach the stop within the period."""
    gain = 1 / complex(1 - w * w, 2 * z * w)
    t = np.linspace(0, 2 * math.pi / w, 400)[1:-1]
    driven = gain * np.exp(1j * (w * t + phase))
    start = gain * np.exp(1j * phase)
    y = np.array([-start.real, -r * before - (1j * w * start).real])
    free = np.array([expm(np.array([[0.0, 1.0], [-1.0, -2 * z]]) * s) @ y for s in t[::20]])[:, 0]
    return bool(np.all(driven.real[::20] + free < -1e-3))


@pytest.mark.parametrize("seed", longer(range(7, 13), range(8, 13)))
def test_multipliers_of_random_orbits_are_those_of_the_closed_form(seed):
    rng, scene, found = np.random.default_rng(seed), oscillator(), 0
    while found < 4:
        z, r, w = rng.uniform(0.01, 0.2), rng.uniform(0.3, 0.9), rng.uniform(1.6, 3.0)
        phase, before, matrix = closed_orbit(z, r, w)
        grows = np.max(np.abs(np.linalg.eigvals(matrix)))
        if grows > 0.95 or not stays_below(z, r, w, phase, before):
            continue  # a motion does not come to it
        shift = phase + 0.4 * math.pi  # the start lies between two impacts
        gain = 1 / complex(1 - w * w, 2 * z * w)
        start = gain * np.exp(1j * phase)
        time = (shift - phase) / w
        y = expm(np.array([[0.0, 1.0], [-1.0, -2 * z]]) * time) @ [-start.real, -r * before - (1j * w * start).real]
        there = gain * np.exp(1j * shift)
        y = y + np.array([there.real, (1j * w * there).real])
        moved = scene.where({Z: z, R: r, W: w, C: shift}).starting({X: y[0] + 1e-3, U: y[1]})
        orbit = sf.limit_cycle(moved)
        assert [e.kind for e in orbit.events] == ["impact"]
        at = orbit.events[0].t
        assert math.remainder(w * at + shift - phase, 2 * math.pi) == pytest.approx(0.0, abs=1e-10)
        assert np.sum(orbit.multipliers).real == pytest.approx(np.trace(matrix), abs=1e-9)
        assert np.prod(orbit.multipliers).real == pytest.approx(r**2 * math.exp(-4 * math.pi * z / w), abs=1e-10)
        assert orbit.stable
        found += 1


def two_masses():
    """Return two masses with play between them; the second rubs on the ground."""
    system = sf.System([X, Y], [U, V], sp.diag(1, P), [-X - U / 10 + 2 * sp.cos(W * sf.TIME), -Y - V / 20])
    contacts = [
        sf.Contact("play", None, sf.Unilateral(sp.Rational(1, 2) + Y - X, restitution=R)),
        sf.Contact("ground", V, 1, sf.laws.coulomb(MU)),
    ]
    return sf.Scene(system, contacts, {P: 1.0, R: 0.5, W: 1.3, MU: 0.05}, {X: 0.0, Y: 0.0, U: 0.0, V: 0.0}, 150.0)


@pytest.mark.parametrize("seed", longer(range(3, 9), range(4, 9)))
def test_multipliers_of_orbits_with_friction_are_those_of_differences(seed):
    rng, scene, found = np.random.default_rng(seed), two_masses(), 0
    for _ in range(2):
        values = {P: rng.uniform(0.5, 2), R: rng.uniform(0.2, 0.8), W: rng.uniform(0.7, 2), MU: rng.uniform(0.0, 0.1)}
        try:
            orbit = sf.limit_cycle(scene.where(values), tolerance=1e-12)
        except sf.NotFound:
            continue
        if not any(e.kind == "impact" for e in orbit.events):
            continue
        period, start = orbit.period, orbit.run.x[:, 0]
        program = sf.prepare(scene.where(values).until(period, {"end": sf.End()}), tolerance=1e-13)
        matrix = np.empty((4, 4))
        for k in range(4):
            h = 1e-6 * np.eye(4)[k]
            sides = [program.run(initial=dict(zip("xyuv", start + s * h, strict=True))).checked() for s in (1, -1)]
            matrix[:, k] = (sides[0].final - sides[1].final) / 2e-6
        right, got = np.linalg.eigvals(matrix), orbit.multipliers
        assert np.poly(got) == pytest.approx(np.poly(right), abs=1e-6)
        found += 1
    assert found >= 1


@cache
def shaken():
    """Return a ball on a shaken table, with friction, and its program."""
    g = 9.81
    a, w, e, mu = sp.symbols("a w e mu", positive=True)
    contact = sf.Contact("table", U - a * w * sp.cos(w * sf.TIME), sf.Unilateral(Y - a * sp.sin(w * sf.TIME), e),
                         sf.laws.coulomb(mu))  # fmt: skip
    scene = sf.Scene(
        sf.System([X, Y], [U, V], sp.eye(2), [0, -g]), [contact], {a: 0.01, w: 30.0, e: 0.4, mu: 0.3},
        {X: 0.0, Y: 0.05, U: 0.0, V: 0.0}, 2.0, outputs={"end": sf.End(), "peak": sf.Max(Y)},
    )  # fmt: skip
    return scene, sf.prepare(scene)


def test_a_map_has_the_bits_of_runs():
    _, program = shaken()
    rng = np.random.default_rng(2)
    values = {"a": rng.uniform(0.005, 0.02, 24), "e": rng.uniform(0, 0.9, 24), "mu": rng.uniform(0, 1, 24)}
    starts = {"y": rng.uniform(0.021, 0.2, 24), "v": rng.uniform(-1, 1, 24)}
    batch = program.map(values=values, initial=starts)
    threaded = program.map(values=values, initial=starts, threads=2)
    for k in range(24):
        one = program.run(
            values={n: float(a[k]) for n, a in values.items()}, initial={n: float(a[k]) for n, a in starts.items()}
        )
        assert batch.status[k] == one.status == threaded.status[k]
        assert batch.final[:, k].tolist() == one.final.tolist() == threaded.final[:, k].tolist()
        assert batch.outputs["peak"][k] == one["peak"]


def test_one_bad_case_of_a_map_is_its_own():
    _, program = shaken()
    batch = program.map(values={"e": np.array([0.4, 0.4, 0.4])}, initial={"y": np.array([0.05, -0.05, 0.06])})
    assert np.isnan(batch.final[:, 1]).all()
    assert batch.status[1] == sf.Status.NOT_FINITE
    assert batch.status[[0, 2]].tolist() == [0, 0]
    assert batch.final[:, 0].tolist() == program.run(initial={"y": 0.05}).final.tolist()


@pytest.mark.parametrize("bad", [{"e": 1.5}, {"e": -0.1}, {"e": math.nan}])
def test_a_run_refuses_wrong_restitutions(bad):
    with pytest.raises(sf.SceneError):
        shaken()[1].run(values=bad)


def test_a_run_refuses_a_start_within_the_floor():
    with pytest.raises(sf.SceneError, match="must not be negative"):
        shaken()[1].run(initial={"y": -0.01})


def test_exponents_add_up_to_what_damping_and_impacts_take():
    """Volume shrinks by ``exp(-2 z t)`` in flight and by ``r^2`` in an impact, also on an irregular motion."""
    scene = oscillator().where({Z: 0.02, R: 0.8, W: 2.6})
    period = 2 * math.pi / 2.6
    found = sf.lyapunov(scene, 300 * period, transient=20 * period)
    run = sf.simulate(scene.until((20 + 300) * period), tolerance=1e-10)
    hits = sum(e.kind == "impact" and e.t > 20 * period for e in run.events)
    expected = -2 * 0.02 + 2 * math.log(0.8) * hits / (300 * period)
    assert np.sum(found.exponents) == pytest.approx(expected, abs=3 * abs(math.log(0.8)) / (300 * period))


def test_exponents_of_an_orbit_are_those_of_its_multipliers():
    scene, period = oscillator(), 2 * math.pi / 2.2
    found = sf.lyapunov(scene, 200 * period, transient=60 * period)
    orbit = sf.limit_cycle(scene)
    rate = math.log(abs(orbit.multipliers[0])) / period
    assert found.exponents == pytest.approx([rate, rate], abs=0.02)
    assert not found.chaotic


def test_sections_see_the_motion_at_its_phase():
    scene, period = oscillator().until(60 * 2 * math.pi / 2.2), 2 * math.pi / 2.2
    section = sf.poincare(scene, after=40 * period)
    run = sf.simulate(scene)
    assert section.states == pytest.approx(run(section.times), abs=1e-7)
    assert np.diff(section.times) == pytest.approx(period)
    at_stop = sf.poincare(run, "u", after=40 * period, direction=0)
    turns = [e.t for e in run.events if e.t > 40 * period]
    assert len(at_stop.times) >= len(turns)


def test_all_starts_end_on_the_orbit():
    scene = oscillator().until(60 * 2 * math.pi / 2.2)
    found = sf.basins(scene, {"x": [-2.0, -0.1], "u": [-1.0, 1.0]})
    assert [a.kind for a in found.attractors] == ["cycle"]
    assert np.all(found.label == 0)
