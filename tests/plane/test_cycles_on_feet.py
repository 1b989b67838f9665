"""Limit cycles and branches of bodies on feet: against differences of runs, long runs and one contact along a line."""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer

q = x, y, theta = sp.symbols("x y theta", real=True)
u = v_x, v_y, omega = sp.symbols("v_x v_y omega", real=True)
W, A, MU = sp.symbols("W A mu", positive=True)
t = sf.TIME
pytestmark = pytest.mark.filterwarnings("ignore:redundant contacts")
FEET = {
    2: ([(0.7, 0.1), (-0.7, -0.1)], (1, 1.5)),
    3: (
        [(math.cos(0.3 + 2 * math.pi * k / 3), math.sin(0.3 + 2 * math.pi * k / 3)) for k in range(3)],
        (1, 1.25, 0.75),
    ),
    4: ([(1, 0.2), (-0.8, 0.6), (-0.4, -0.9), (0.5, -0.7)], (0.6, 0.5, 0.8, 0.7)),
}
STRIBECK, DROP = sf.laws.stribeck(MU, 0.5 * MU, 0.3), sf.laws.coulomb(MU, 0.7 * MU)


def body(n, *, force=(0, 0, 0), table=(0, 0), spin=0, laws=None, values=None, springs=(1.0, 1.3, 0.7), damping=0.02):
    """Return a body on n feet, held by springs, on a table that moves and spins; turns of the body are small."""
    laws = laws or [sf.laws.coulomb(MU)] * n
    contacts = []
    for k, ((a, b), N, law) in enumerate(zip(*FEET[n], laws, strict=True)):
        slip = (v_x - b * omega - table[0] + spin * (y + b), v_y + a * omega - table[1] - spin * (x + a))
        contacts.append(sf.Contact(f"foot {k}", slip, N, law))
    forces = [sp.sympify(f) - k * e - damping * v for f, k, e, v in zip(force, springs, q, u, strict=True)]
    known = {MU: 0.12, W: 1.3} | (values or {})
    used = set().union(*(f.free_symbols for f in forces), *(c.free_symbols for c in contacts))
    initial = dict(zip((*q, *u), (0.1, 0, 0.05, 0, 0.1, 0), strict=True))
    system = sf.System(q, u, sp.diag(1, 1, 0.4), forces)
    return sf.Scene(system, contacts, {s: v for s, v in known.items() if s in used}, initial, 40.0)


WAVE = (A * sp.sin(W * t), A * sp.cos(W * t), 0.5 * A * sp.sin(W * t + 0.4))
TWO_WAYS = (A * sp.sin(W * t), 0.7 * A * sp.cos(W * t), 0)
PUSHED = body(2, force=WAVE, laws=[DROP] * 2, values={A: 0.5})
CYCLES = {
    "three feet on a belt": lambda: body(3, table=(0.1, 0.05), laws=[STRIBECK] * 3),
    "three feet on a turntable": lambda: body(3, spin=0.15, laws=[STRIBECK] * 3),
    "three feet, pushed": lambda: body(3, force=WAVE, values={A: 0.5}),
    "four feet, pushed": lambda: body(4, force=WAVE, values={A: 0.45}),
    "two feet, a drop of friction": lambda: PUSHED,
    "a table shaken in two directions": lambda: body(3, table=TWO_WAYS[:2], values={A: 1.2}),
}


def slopes(orbit, size=1e-6):
    """Return the derivatives of the state after a period by the start, by central differences."""
    program = sf.prepare(orbit.scene, 1e-12)

    def end(start):
        return program.run(initial=dict(zip(orbit.names, start, strict=True))).checked().final

    return np.column_stack([(end(orbit.start + h) - end(orbit.start - h)) / (2 * size) for h in size * np.eye(6)])


@pytest.mark.parametrize("which", longer(CYCLES, [name for name in CYCLES if name != "two feet, a drop of friction"]))
def test_multipliers_are_those_of_differences(which):
    scene = CYCLES[which]()
    orbit = sf.limit_cycle(scene, tolerance=1e-12)
    assert orbit.differentiable
    found = np.linalg.eigvals(slopes(orbit))
    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx(np.sort(np.abs(found)), abs=3e-6)


@pytest.mark.long(beside="test_multipliers_are_those_of_differences")
@pytest.mark.parametrize("which", CYCLES)
def test_motions_end_on_the_cycle(which):
    scene = CYCLES[which]()
    orbit = sf.limit_cycle(scene, tolerance=1e-12)
    late = sf.simulate(scene.starting(dict.fromkeys(q, 0.02)).until(400.0), tolerance=1e-12).checked()
    last = late.t_final - orbit.period * np.linspace(0, 1, 4001)
    assert 0.5 * np.ptp(late(last), axis=1) == pytest.approx(orbit.half_range, rel=1e-4, abs=1e-5)


RESTS = {
    "pushed a little": lambda: PUSHED.where({A: 0.05, MU: 0.3}),
    "a table that shakes slowly about an axis": lambda: body(3, spin=A * sp.sin(W * t), values={A: 0.3, MU: 0.3}),
}


@pytest.mark.parametrize("which", longer(RESTS, ["a table that shakes slowly about an axis"]))
def test_feet_at_rest_for_good_are_an_orbit(which):
    """It may rest at any place: three multipliers are 1, others 0."""
    orbit = sf.limit_cycle(RESTS[which](), tolerance=1e-12)
    assert orbit.stick_fraction == 1.0
    assert orbit.stable
    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx([0, 0, 0, 1, 1, 1], abs=1e-9)


def turntable(n, v_b):
    """Return a body on n equal feet whose table turns under it; springs hold it as they hold the mass on a belt."""
    V, law = sp.Symbol("v_b", positive=True), sf.laws.cubic(0.4, 0.25, 0.5)
    feet = []
    for k in range(n):
        a, b = math.cos(0.2 + 2 * math.pi * k / n), math.sin(0.2 + 2 * math.pi * k / n)
        feet.append(sf.Contact(f"foot {k}", (v_x - b * (omega - V), v_y + a * (omega - V)), sp.Rational(1, n), law))
    forces = [-e - sp.Rational(1, 10) * v for e, v in zip(q, u, strict=True)]
    system = sf.System(q, u, sp.eye(3), forces)
    return sf.Scene(system, feet, {V: v_b}, dict.fromkeys((*q, *u), 0.0), 200.0)


def test_a_turntable_under_feet_moves_them_as_a_belt_moves_a_mass():
    one = sf.limit_cycle(sf.scenes.mass_on_belt(v_b=0.2), tolerance=1e-11)
    scene = turntable(2, 0.2).starting({theta: one.start[0], omega: one.start[1]}).until(one.period)
    run = sf.simulate(scene, tolerance=1e-11).checked()
    assert run.final[[2, 5]] == pytest.approx(one.start, abs=1e-9)
    assert 0.5 * np.ptp(run(np.linspace(0, one.period, 4001))[2]) == pytest.approx(one.half_range[0], rel=1e-5)
    assert len(run.events) == 2 * len(one.events)


@pytest.mark.long(beside="test_a_turntable_under_feet_moves_them_as_a_belt_moves_a_mass")
@pytest.mark.parametrize("n", [2, 3])
def test_a_turntable_under_feet_is_a_belt_under_a_mass(n):
    several, one = (
        sf.limit_cycle(scene, tolerance=1e-11) for scene in (turntable(n, 0.2), sf.scenes.mass_on_belt(v_b=0.2))
    )
    assert several.period == pytest.approx(one.period, rel=1e-9)
    assert several.half_range[[2, 5]] == pytest.approx(one.half_range, rel=1e-9)
    assert several.stick_fraction == pytest.approx(one.stick_fraction, abs=1e-8)
    assert sorted({e.contact for e in several.events}) == [f"foot {k}" for k in range(n)]
    assert len(several.events) == n * len(one.events)


@pytest.mark.long(beside="test_a_turntable_under_feet_moves_them_as_a_belt_moves_a_mass")
def test_a_branch_on_a_turntable_is_the_belts():
    scenes = turntable(3, 0.2), sf.scenes.mass_on_belt(v_b=0.2)
    several, one = (sf.continue_cycle(scene, "v_b", (0.15, 0.35), tolerance=1e-9) for scene in scenes)
    assert several.values == pytest.approx(one.values, rel=1e-6)
    assert [orbit.period for orbit in several.orbits] == pytest.approx([orbit.period for orbit in one.orbits], rel=1e-6)
    assert [orbit.stable for orbit in several.orbits] == [orbit.stable for orbit in one.orbits]
    assert several.ends == one.ends


@pytest.mark.long(beside="test_multipliers_are_those_of_differences")
def test_a_response_on_feet_is_that_of_runs():
    scene = CYCLES["two feet, a drop of friction"]()
    response = sf.frequency_response(scene, W, (1.2, 1.4), x, tolerance=1e-9)
    assert all(orbit.stable for orbit in response.orbits)
    for k in np.linspace(0, len(response.orbits) - 1, 5).astype(int):
        orbit = response.orbits[k]
        late = sf.simulate(scene.where({W: response.values[k]}).until(400.0), tolerance=1e-9).checked()
        last = late.t_final - orbit.period * np.linspace(0, 1, 4001)
        assert 0.5 * np.ptp(late(last), axis=1) == pytest.approx(orbit.half_range, rel=1e-4, abs=1e-5)


OF_SLIPS = {"x": sf.Max(x), "speed": sf.Max(sf.slip("foot 0")), "way": sf.Integral(sf.slip("foot 1"))}


@pytest.mark.long(beside="test_multipliers_are_those_of_differences")
def test_maps_and_sweeps_on_feet_have_the_bits_of_single_runs():
    scene = body(3, force=WAVE, values={A: 0.3}, damping=0.1).until(8.0).wanting(OF_SLIPS)
    assert "taylor: takes it" in str(sf.explain(scene))
    values = [0.08, 0.12, 0.2]
    single = [sf.simulate(scene.where({MU: v})).checked() for v in values]
    assert {run.route for run in single} == {"taylor"}
    program = sf.prepare(scene)
    batches = [program.map(values={MU: np.array(values)}, threads=threads) for threads in (1, 2)]
    swept = sf.sweep(scene, {"mu": np.array(values)})
    for name in OF_SLIPS:
        expected = [run[name] for run in single]
        assert [batch.outputs[name].tolist() for batch in batches] == [expected] * 2
        assert swept[name].values.tolist() == expected


@pytest.mark.long(beside="test_a_speed_of_rounding_is_rest")
@pytest.mark.parametrize("rough", longer([1e-8, 1e-10], [1e-10]))
def test_a_body_comes_to_rest_about_a_foot_that_sticks(rough):
    """The slip of that foot is an error of the run, about which the others cannot come nearer to rest."""
    laws = [sf.laws.coulomb(MU)] * 2 + [sf.laws.coulomb(4 * MU)]
    scene = body(3, table=TWO_WAYS[:2], laws=laws, values={A: 1.0})
    scene = scene.until(12.0).wanting({"events": sf.Events(), "end": sf.End()})
    runs = [sf.simulate(scene, tolerance=e).checked() for e in (rough, 1e-12)]
    assert runs[0].final == pytest.approx(runs[1].final, abs=1e-8)
    kinds = [[(e.contact, e.kind) for e in run.events] for run in runs]
    assert kinds[0] == kinds[1]
    assert max(run.stats["steps"] for run in runs) < 3000


@pytest.mark.one_in(2)
@pytest.mark.parametrize("speed", [5e-324, 1e-200, -3e-46, 1e-21])
def test_a_speed_of_rounding_is_rest(speed):
    """On still ground nothing but the forces tells how small a speed is: what they stop within the rounding of time."""
    scene = body(3, force=WAVE, values={A: 0.3}, damping=0.1).starting({x: -0.024, v_y: 0.0, omega: 0.0}).until(4.0)
    program = sf.prepare(scene.wanting({"events": sf.Events(), **OF_SLIPS}), 1e-9)
    still, moves = (program.run(initial={"v_y": v}).checked() for v in (0.0, speed))
    assert moves.final == pytest.approx(still.final, abs=1e-9)
    assert [e.kind for e in moves.events] == [e.kind for e in still.events]
