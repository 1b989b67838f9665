"""Steps in time against chains of runs that are restarted at every instant."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
k, v1, v2, t1 = sp.symbols("k v1 v2 t1", positive=True)
VALUES = {"k": 1.0, "v1": 0.2, "v2": -0.3, "t1": 2.7}
LAW = sf.laws.stribeck(0.4, 0.25, 0.3)


def step(before, after):
    return sp.Piecewise((before, sf.TIME < t1), (after, True))


def on_belt(slip, load=1, law=LAW, force=-k * x - u / 20, horizon=20.0, **more):
    system = sf.System([x], [u], [[1]], [force])
    contacts = [sf.Contact("c", slip=slip, normal=load, law=law)]
    used = set().union(*(e.free_symbols for e in map(sp.sympify, (slip, load, force, *law.expressions))))
    values = {n: v for n, v in VALUES.items() if n in {s.name for s in used}}
    return sf.Scene(system, contacts, values, {x: 0.1, u: 0.0}, horizon, {"end": sf.End()}, **more)


def chained(scenes, times, start=(0.1, 0.0), tolerance=1e-13):
    """Return the state after runs of scenes one after the other, each up to its time."""
    state, now = dict(zip(("x", "u"), start, strict=True)), 0.0
    for scene, time in zip(scenes, times, strict=True):
        run = sf.simulate(scene.starting(state).until(time - now), tolerance).checked()
        state, now = dict(zip(("x", "u"), run.final.tolist(), strict=True)), time
    return np.array(list(state.values()))


CASES = {
    "belt": ((u - step(v1, v2),), (u - v1,), (u - v2,)),
    "belt that stops": ((u - step(v1, 0),), (u - v1,), (u,)),
    "belt that starts": ((u - step(0, v2),), (u,), (u - v2,)),
    "load": ((u - v1, step(2, 0.3)), (u - v1, 2), (u - v1, 0.3)),
    "load from zero": ((u - v1, step(0, 2)), (u - v1, 0), (u - v1, 2)),
    "law": (
        (u - v1, 1, sf.laws.coulomb(step(0.4, 0.1), step(0.3, 0.05))),
        (u - v1, 1, sf.laws.coulomb(0.4, 0.3)),
        (u - v1, 1, sf.laws.coulomb(0.1, 0.05)),
    ),
    "force": (
        (u - v1, 1, LAW, -k * x - u / 20 + step(0, 1)),
        (u - v1, 1, LAW, -k * x - u / 20),
        (u - v1, 1, LAW, -k * x - u / 20 + 1),
    ),
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("case", CASES)
def test_a_step_is_a_restart(case):
    whole, before, after = CASES[case]
    program = sf.prepare(on_belt(*whole), 1e-12, "taylor")
    for at in (1.1, 2.7, 6.0):  # the contact sticks at some of them, and slips at others
        run = program.run({"t1": at}).checked()
        assert np.max(np.abs(run.final - chained([on_belt(*before), on_belt(*after)], [at, 20.0]))) < 1e-10


@pytest.mark.one_in(8)
@pytest.mark.parametrize("case", CASES)
def test_derivatives_by_the_instant(case):
    scene = on_belt(*CASES[case][0])
    run = sf.simulate(scene, 1e-12, "taylor", sensitivities=("t1",))
    program, h = sf.prepare(scene, 1e-13, "taylor"), 1e-5
    far, near = (
        (program.run({"t1": 2.7 + s}).final - program.run({"t1": 2.7 - s}).final) / (2 * s) for s in (2 * h, h)
    )
    assert np.max(np.abs(run.sensitivities["t1"] - (4 * near - far) / 3)) < 1e-7


def test_forces_by_three_routes():
    scene = on_belt(*CASES["force"][0])
    ends = [sf.simulate(scene, 1e-11, route).checked().final for route in ("taylor", "integrators")]
    assert np.max(np.abs(ends[0] - ends[1])) < 1e-9


def test_exact_and_taylor_agree_on_coulomb_friction():
    law = sf.laws.coulomb(0.3, 0.2)
    scene = on_belt(u - step(v1, v2), step(1, 0.5), law, -k * x + step(0, 1))
    ends = [sf.simulate(scene, 1e-13, route).checked().final for route in ("taylor", "exact")]
    assert np.max(np.abs(ends[0] - ends[1])) < 1e-11


def test_the_instant_is_exact():
    scene = on_belt(u, 1, sf.laws.coulomb(0.3), step(0, 1)).wanting({"events": sf.Events()})
    assert [e.t for e in sf.simulate(scene, route="taylor").events] == [2.7]


def test_instants_that_coincide():
    sooner = sp.Piecewise((0, sf.TIME < 0.3), (1, True))
    later = sp.Piecewise((v1, sf.TIME < 3 * 0.1), (v2, True))  # a rounding error later
    both = sf.simulate(on_belt(u - later - sooner, 1 + sooner), 1e-12, "taylor").checked()
    parts = [on_belt(u - v1, 1), on_belt(u - v2 - 1, 2)]
    assert np.max(np.abs(both.final - chained(parts, [0.3, 20.0]))) < 1e-10


def test_a_step_at_the_start_and_at_the_end():
    program = sf.prepare(on_belt(u - step(v1, v2), step(2, 1)), 1e-12, "taylor")
    assert np.array_equal(program.run({"t1": 1e-300}).final, chained([on_belt(u - v2, 1)], [20.0], tolerance=1e-12))
    assert np.max(np.abs(program.run({"t1": 20.0}).final - chained([on_belt(u - v1, 2)], [20.0]))) < 1e-10
    zero = sf.simulate(on_belt(u - sp.Piecewise((v1, sf.TIME < 0), (v2, True))), 1e-12, "taylor").checked()
    assert np.max(np.abs(zero.final - chained([on_belt(u - v2)], [20.0]))) < 1e-10


def test_functions_that_jump_are_pieces():
    a = sp.Piecewise((0, sf.TIME < 2), (1, True))
    written = [a, sp.Heaviside(sf.TIME - 2), (1 + sp.sign(sf.TIME - 2)) / 2]
    ends = [sf.simulate(on_belt(u - v1, 1 + e), 1e-12, "taylor").checked().final for e in written]
    assert np.array_equal(ends[0], ends[1])
    assert np.max(np.abs(ends[0] - ends[2])) < 1e-13


@pytest.mark.long(beside="test_a_step_is_a_restart")
def test_pulses_repeat():
    pulse = sp.Piecewise((1, sp.Mod(sf.TIME - 0.5, 2) < sp.Rational(3, 4)), (0, True))
    low, high = (on_belt(u - v1, 1, LAW, -k * x - u / 20 + f) for f in (0, 1))
    times = [0.5]
    for n in range(10):
        times += [0.5 + 2 * n + 0.75, 0.5 + 2 * n + 2]
    parts = [low, *[high, low] * 10]
    times = [t for t in times if t < 20.0] + [20.0]
    found = sf.simulate(on_belt(u - v1, 1, LAW, -k * x - u / 20 + pulse), 1e-12, "taylor").checked()
    assert np.max(np.abs(found.final - chained(parts[: len(times)], times))) < 1e-9


def test_many_short_pulses_are_all_met():
    pulse = sp.Piecewise((1, sp.Mod(sf.TIME, sp.Rational(1, 100)) < sp.Rational(1, 400)), (0, True))
    scene = sf.Scene(sf.System([x], [u], [[1]], [pulse]), (), {}, {x: 0, u: 0}, 10.0, {"end": sf.End()})
    run = sf.simulate(scene, 1e-12, "taylor").checked()
    assert run.final[1] == pytest.approx(2.5, abs=1e-12)
    assert run.stats["kinks"] >= 1999


def test_square_waves_have_a_period():
    T = sp.Symbol("T", positive=True)
    wave = sp.Piecewise((1, sp.Mod(sf.TIME, T) < T / 2), (-1, True))
    system = sf.System([x], [u], [[1]], [-x - u / 5 + wave])
    scene = sf.Scene(system, (), {T: 3.0}, {x: 0.0, u: 0.0}, 60.0)
    orbit = sf.limit_cycle(scene)
    A = np.array([[0.0, 1.0], [-1.0, -0.2]])
    from scipy.linalg import expm

    half, rest = expm(A * 1.5), np.array([1.0, 0.0])
    start = np.linalg.solve(np.eye(2) + half, (half - np.eye(2)) @ rest)  # x(T/2) = -x(0)
    assert orbit.period == pytest.approx(3.0)
    assert np.max(np.abs(orbit.run.x[:, 0] - start)) < 1e-8
    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx(np.abs(np.linalg.eigvals(half @ half)), abs=1e-9)


def test_a_single_step_has_no_period():
    system = sf.System([x], [u], [[1]], [-x - u / 5 + step(0, 1)])
    scene = sf.Scene(system, (), {t1: 3.0}, {x: 0.0, u: 0.0}, 60.0)
    with pytest.raises(sf.SceneError, match="has no period"):
        sf.limit_cycle(scene)


def test_map_equals_runs():
    program = sf.prepare(on_belt(u - step(v1, v2), step(2, 0.5)), 1e-10, "taylor")
    times = np.linspace(0.5, 8.0, 40)
    batch = program.map({"t1": times})
    assert np.array_equal(batch.final.T, [program.run({"t1": t}).final for t in times])


def test_held_samples_are_steps():
    f = sp.Symbol("f", real=True)
    samples = [0.4, -1.0, 0.0, 2.0]
    pieces = [(s, sf.TIME < 1.5 * (n + 1)) for n, s in enumerate(samples)]
    force = -k * x - u / 20
    for slip, load, part in ((u - v1, 1, f), (u - f, 1, 0), (u - v1, 1 + f**2, 0)):
        written = sp.Piecewise(*pieces, (0, True))
        signal = sf.Signal(samples, 1.5, hold=True)
        given = sf.simulate(on_belt(slip, load, LAW, force + part, inputs={f: signal}), 1e-12, "taylor").checked()
        spelt = [sp.sympify(e).xreplace({f: written}) for e in (slip, load)]
        other = sf.simulate(on_belt(*spelt, LAW, force + sp.sympify(part).xreplace({f: written})), 1e-12).checked()
        assert np.max(np.abs(given.final - other.final)) < 1e-10


def test_energy_is_balanced_over_steps():
    scene = on_belt(u - step(v1, v2), step(2, 0.5), LAW, -k * x - u / 20 + step(0, 1))
    assert abs(sf.simulate(scene.wanting({"path": sf.Trajectory()}), 1e-11).energy_residual()) < 1e-8


def refused(match, **parts):
    with pytest.raises(sf.SceneError, match=match):
        on_belt(**{"slip": u - v1, **parts})


def test_what_is_refused():
    refused("a Piecewise must be continuous", slip=u - v1, force=-k * x + sp.Piecewise((0, x < 0), (1, True)))
    refused("a Piecewise must be continuous", force=-k * x + sp.Heaviside(sf.TIME - x))
    refused("of time and state together", force=-k * x + sp.Piecewise((0, sp.sin(x) < sp.cos(sf.TIME)), (1, True)))
    refused("an impulse", force=-k * x + sp.DiracDelta(sf.TIME - 1))
    refused("jumps for ever", force=-k * x + sp.floor(sf.TIME))
    refused("write it as sympy.Mod", force=-k * x + sp.Piecewise((0, sp.Mod(sf.TIME**2, 2) < 1), (1, True)))
    with pytest.raises(sf.SceneError, match="behind a spring"):
        sf.Contact("c", slip=u, normal=step(1, 2), law=sf.laws.coulomb(0.3), stiffness=10)
    with pytest.raises(sf.NoRoute, match="steps in time"):
        sf.prepare(on_belt(u - step(v1, v2)), route="integrators")
