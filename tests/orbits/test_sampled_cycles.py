"""Hunting of sampled controllers: cycles against arcs of circles, the ends of their branches, and motions beside these."""

import functools
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq, fsolve

import symfric as sf
from symfric.orbits.flow_map import FlowMap

x, u = sp.symbols("x u", real=True)
D, T, tau, L, C, k = sp.symbols("D T tau L C k", positive=True)
VALUES = {"D": 16.0, "T": 0.2, "tau": 0.03, "L": 1.0, "C": 0.2, "k": 1.0}


@functools.cache
def made(delayed):
    """Return a sprung mass with sampled damping, whose force is limited: with a slow clock it shakes the mass."""
    command = sf.Held("cmd", sp.Max(-L, sp.Min(L, -D * u)), every=T, delay=tau if delayed else 0)
    values = {s: VALUES[s.name] for s in (D, T, L, C, k, *([tau] if delayed else []))}
    system = sf.System([x], [u], [[1]], [-k * x + command.symbol])
    rail = sf.Contact("rail", u, 1, sf.laws.coulomb(C))
    return sf.Scene(system, [rail], values, {x: 0.0, u: 0.1}, 100.0, held=[command])


def arc(state, force, length, k):
    """Return position and velocity of x'' = force - k x after a time."""
    w, centre = np.sqrt(k), force / k
    c, s = np.cos(w * length), np.sin(w * length)
    return np.array([centre + (state[0] - centre) * c + state[1] / w * s, (centre - state[0]) * w * s + state[1] * c])


def shaken(T, tau=0.0, L=1.0, C=0.2, k=1.0):
    """Return position and speed at the samples of the symmetric cycle at the limits of the command, of the period 2 T.

    The third number is the position at the stop between them.
    """

    def gaps(unknown):
        place, speed, stop = unknown
        turned = arc(arc((place, speed), L - C, tau, k), -L - C, stop - tau, k)
        end = arc(turned, -L + C, T - stop, k)
        return turned[1], end[0] + place, end[1] + speed

    start = 0.0, (L**2 - C**2) * T / (2 * L), T / 2
    found, _, _, words = fsolve(gaps, start, xtol=1e-13, full_output=True)
    assert np.max(np.abs(gaps(found))) < 1e-13, words
    place, speed, stop = found
    return place, speed, arc(arc((place, speed), L - C, tau, k), -L - C, stop - tau, k)[0]


def cycle(delayed=False, **values):
    return sf.limit_cycle(made(delayed).where(values))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", range(6))
def test_a_cycle_at_the_limits_is_two_arcs_a_half_period(seed):
    rng = np.random.default_rng(seed)
    delayed = seed % 2 == 1
    values = {"T": rng.uniform(0.15, 0.4), "L": rng.uniform(0.8, 2), "k": rng.uniform(0.2, 2), "D": 40.0}
    values["C"] = rng.uniform(0.1, 0.3) * values["L"]
    values |= {"tau": 0.2 * values["T"]} if delayed else {}
    expected = shaken(**{n: v for n, v in values.items() if n != "D"})
    scene = made(delayed).where(values).starting({"x": expected[0], "u": expected[1]})
    scene = scene.starting({"cmd": values["L"]})
    orbit = sf.limit_cycle(scene)
    assert orbit.stable
    assert orbit.period == pytest.approx(2 * values["T"], rel=1e-14)
    assert np.abs(orbit.start[:2]) == pytest.approx(np.abs(expected[:2]), abs=1e-11)


def border(name, T=0.2, tau=0.0):
    """Return where a command at its limits would leave them: D |u| = L at the samples, at fixed other values."""
    if name == "D":
        return 1 / shaken(T, tau)[1]
    if name == "T":
        return brentq(lambda t: VALUES["D"] * shaken(t, tau)[1] - 1, 0.1, 0.4, xtol=1e-14)
    return brentq(lambda late: VALUES["D"] * shaken(T, late)[1] - 1, 0.0, 0.1, xtol=1e-14)


BRANCHES = [("D", (5, 30), False), ("D", (5, 30), True), ("T", (0.05, 0.5), False), ("T", (0.05, 0.5), True)]


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("name", "span", "delayed"), [*BRANCHES, ("tau", (0.002, 0.15), True)])
def test_branches_end_or_turn_where_hunting_ends(name, span, delayed):
    branch = sf.continue_cycle(made(delayed), name, span, start=cycle(delayed))
    expected = border(name, tau=VALUES["tau"] if delayed and name != "tau" else 0.0)
    reached = max(branch.values) if name == "tau" else min(branch.values)
    assert reached == pytest.approx(expected, rel=3e-6)
    assert max(span) in branch.values or name == "tau"
    folds = [s.value for s in branch.special if s.kind == "fold"]
    if folds:  # it turns back, to a cycle that is unstable
        assert folds == [pytest.approx(expected, rel=1e-11)]
        assert {bool(o.stable) for o in branch.orbits} == {True, False}


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("name", "delayed"), [("D", False), ("D", True), ("T", False), ("T", True), ("tau", True)])
def test_motions_hunt_on_one_side_of_the_border_only(name, delayed):
    edge = border(name, tau=VALUES["tau"] if delayed and name != "tau" else 0.0)
    program = sf.prepare(made(delayed).wanting({"rest": sf.StopTime()}), 1e-9)
    speeds = np.linspace(0.01, 0.4, 40)
    for share, hunts in ((0.99, name == "tau"), (1.01, name != "tau")):
        batch = program.map({name: share * edge}, {"u": speeds, "cmd": 1.0})
        assert np.all(batch.status == 0)
        assert np.any(np.isnan(batch.outputs["rest"])) == hunts


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", range(4))
def test_multipliers_of_cycles_at_the_limits(seed):
    """Between stops areas of the phase plane stay; at a stop they change by the ratio of the accelerations."""
    rng = np.random.default_rng(seed)
    values = {"T": rng.uniform(0.15, 0.4), "C": rng.uniform(0.1, 0.3), "tau": rng.uniform(0.01, 0.04)}
    place, speed, stop = shaken(**values)
    start = {"x": place, "u": speed, "cmd": 1.0}
    orbit = sf.limit_cycle(made(True).where({**values, "D": 40.0}).starting(start))
    ratio = (1 - values["C"] + stop) / (1 + values["C"] + stop)
    assert np.prod(orbit.multipliers[:2]) == pytest.approx(ratio**2, rel=1e-9)
    assert np.all(orbit.multipliers[2:] == 0)


@pytest.mark.long(beside="test_branches_end_or_turn_where_hunting_ends")
def test_hunting_of_a_sampled_pid_has_no_cycle_and_nears_that_of_a_continuous_one():
    expected = sf.theory.hunting(k_p=4.0, k_i=1.0, k_d=1.0, F_s=1.5, F_c=1.0)
    off = []
    for period in (0.08, 0.04, 0.02):
        held = sf.control.pid(x, 0, kp=4.0, ki=1.0, kd=1.0, every=period, rate=u)
        guide = sf.Contact("guide", u, 1, sf.laws.coulomb(1.5, 1.0))
        system = sf.System([x], [u], [[1]], [held[-1].symbol])
        scene = sf.Scene(system, [guide], {}, {x: 0.5, u: 0.0}, 1500.0, held=held)
        run = sf.simulate(scene, 1e-9).checked()
        stops = np.array([e.t for e in run.events if e.after == 0 and e.t > 300])
        places = np.abs(run(stops)[0])
        turns = np.diff([e.t for e in run.events if e.before == 0 and e.t > 300])
        off.append((np.mean(places) / expected.offset - 1, 2 * np.mean(turns) / expected.period - 1))
        if period == 0.08:
            with pytest.raises(sf.NotFound, match="waits and moves on"):
                sf.limit_cycle(scene)
    off = np.abs(off)
    assert np.all(off[-1] < 0.02)
    assert np.all(off[1:] < 0.7 * off[:-1])


def hunting(every, horizon):
    held = sf.control.pid(x, 0.5, kp=20.0, ki=60.0, kd=6.0, every=every)
    system = sf.System([x], [u], [[1]], [held[-1].symbol - 0.2 * u])
    way = sf.Contact("way", u, 1, sf.laws.stribeck(1.0, 0.5, 0.05))
    return sf.Scene(system, [way], {}, {x: 0.0, u: 0.0}, horizon, held=held)


@pytest.mark.parametrize(("every", "horizon"), [(0.01, 30.0), pytest.param(0.001, 60.0, marks=pytest.mark.long)])
def test_a_stage_that_hunts_about_a_place_is_said_to_wait(every, horizon):
    """The second, sampled so often that longer waits end at the budget of steps, whose status says less."""
    with pytest.raises(sf.NotFound, match="waits and moves on"):
        sf.limit_cycle(hunting(every, horizon))


def test_a_wait_that_ends_at_the_budget_is_said_at_once(monkeypatch):
    scene, runs, motion = hunting(0.01, 150.0), [], FlowMap.motion

    def cut(flow, scene, horizon):
        runs.append(replace(motion(flow, scene, horizon), status=sf.Status.STEP_BUDGET))
        return runs[-1]

    monkeypatch.setattr(FlowMap, "motion", cut)
    with pytest.raises(sf.NotFound, match="waits and moves on"):
        sf.limit_cycle(scene)
    assert len(runs) == 1


@pytest.mark.long(beside="test_branches_end_or_turn_where_hunting_ends")
def test_a_stick_that_begins_at_a_sample_ends_a_branch_with_a_jump():
    """The velocity is largest at a sample, where the acceleration jumps; without a drop of friction the branch goes on."""
    amplitude, omega = sp.symbols("a omega", positive=True)
    command = sf.Held("command", update=-0.3 * u, every=sp.pi / (2 * omega))
    values = {}
    for law in (sf.laws.coulomb(0.1), sf.laws.coulomb(0.2, 0.1)):
        scene = sf.Scene(
            sf.System([x], [u], [[1]], [-x - 0.1 * u + amplitude * sp.sin(omega * sf.TIME) + command.symbol]),
            [sf.Contact("belt", slip=u - 0.5, normal=1, law=law)],
            {amplitude: 0.14, omega: 1.1},
            {x: 0.2, u: 0},
            100.0,
            held=[command],
        )
        branch = sf.continue_cycle(scene, "a", (0.13, 0.15), start=sf.limit_cycle(scene))
        assert branch.ends == ("span", "span")
        (onset,) = branch.special
        assert onset.kind == "stick-onset"
        assert onset.jump == (law.stick != law.at_rest)
        values[onset.jump] = onset.value
    assert values[True] == pytest.approx(values[False], abs=1e-8)
