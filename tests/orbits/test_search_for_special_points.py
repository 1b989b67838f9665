"""How special points are sought: slopes of test functions, searches that are given up early, what follows a jump."""

from contextlib import contextmanager
from unittest import mock

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.errors import NotFound
from symfric.orbits.continuation.bifurcations import slip_ends
from symfric.orbits.flow_map import flow_of
from symfric.orbits.passages import DirectedRuns
from symfric.orbits.shooting import ShootingSystem, solve
from symfric.structures import RowContact
from symfric.structures.makers import chain
from symfric_evidence.bench import larger

W, N, F, V = sp.symbols("W N F v_b", positive=True)
STEPS = 2.0 ** -np.arange(10, 16)


def forced_floor():
    """A forced mass on the ground, which turns round in slip."""
    x, u = sp.symbols("x u", real=True)
    system = sf.System([x], [u], [[1]], [-x - u / 10 + F * sp.cos(W * sf.TIME)])
    contact = sf.Contact("floor", slip=u, normal=1, law=sf.laws.stribeck(0.4, 0.3, 0.2))
    return sf.Scene(system, [contact], {F: 1.1, W: 0.9}, {x: 0.5, u: 0.0}, 200.0), "W", [0.9, 0.3]


def moving_load():
    """A mass whose friction depends on its place, on a belt."""
    x, u = sp.symbols("x u", real=True)
    system = sf.System([x], [u], [[1 + x**2 / 5]], [-x - u / 10])
    contact = sf.Contact("belt", slip=u - V, normal=1 + x / 4, law=sf.laws.cubic(0.4, 0.25, 0.5), profile=1 + x**2 / 9)
    return sf.Scene(system, [contact], {V: 0.2}, {x: 0.0, u: 0.0}, 100.0), "v_b", [0.9, -0.1]


def two_joints():
    """Three masses, two of them with joints to the ground."""
    structure, law = chain(3, damping=0.02), sf.laws.coulomb(0.5, 0.4)
    joints = [RowContact(f"on {name}", {name: 1.0}, N, law) for name in ("x2", "x3")]
    scene = structure.scene(joints, force={"x1": sp.cos(W * sf.TIME)}, values={W: 0.7, N: 0.2}, horizon=60.0)
    return scene, "N", [0.7, 0.2, -0.4, 0.6, 0.1, -0.3]


@pytest.mark.long(beside="test_beyond_a_jump_the_branch_goes_on_with_a_stable_cycle_where_one_is_found")
@pytest.mark.parametrize("made", [forced_floor, moving_load, two_joints])
def test_slopes_of_what_static_friction_can_bear_where_slips_end(made):
    scene, name, start = made()
    flow, values = flow_of(scene, (name,)), {s.name: v for s, v in scene.parameter_values().items()}
    start, rng, span = np.array(start), np.random.default_rng(5), 18.0
    n = start.size
    checked = 0
    for contact in range(len(flow.lines)):
        for which, (time, way) in enumerate(slip_ends(flow.run(start, values, span), contact)):

            def left(change, contact=contact, which=which):
                y, moved = start + change[:n], {**values, name: values[name] + change[n]}
                end, side = slip_ends(flow.run(y, moved, span), contact)[which]
                return flow.guard(y, moved, end, contact, side, sticks=True).left

            by_start, by_value = flow.reserve_slopes(start, values, time, contact, way)
            along = rng.standard_normal(n + 1)
            exact = float(np.append(by_start, by_value) @ along)
            errors = [abs(left(h * along) - left(-h * along) - 2 * h * exact) / (2 * h) for h in STEPS]
            assert errors[-1] < 1e-5 * (1 + abs(exact))
            assert errors[-1] < 0.3 * errors[0] or errors[-1] < 1e-7 * (1 + abs(exact))  # they fall with the step
            checked += 1
    assert checked > 1


@contextmanager
def counted(kind, name):
    """Count the calls of a method."""
    with mock.patch.object(kind, name, autospec=True, side_effect=getattr(kind, name)) as calls:
        yield calls


@pytest.fixture(scope="module")
def followed():
    """The branch of two masses on a belt, and its number of runs."""
    with counted(DirectedRuns, "follow") as runs:
        return sf.continue_cycle(larger.chain(2), "v_b", (0.05, 0.4)), runs.call_count


def test_a_branch_takes_few_runs_for_each_orbit_and_special_point(followed):
    branch, runs = followed
    assert len(branch.special) > 4
    assert runs < 5 * len(branch.orbits) + 80 * len(branch.special)  # 29 for each orbit when every failure was sought


def test_special_points_of_the_smooth_and_of_the_peaked_kind_solve_their_equations(followed):
    branch, _ = followed
    flips = [s for s in branch.special if s.kind == "flip"]
    assert flips
    for special in flips:
        assert np.min(np.abs(special.orbit.multipliers + 1)) < 1e-8
    fold = next(s for s in branch.special if s.kind == "fold")
    assert np.sort(np.abs(fold.orbit.multipliers - 1))[1] < 1e-4  # besides that of a shift of time
    assert 0 <= fold.value - np.max(branch.values) < 1e-5  # the walk passes near it


def test_beyond_a_jump_the_branch_goes_on_with_a_stable_cycle_where_one_is_found(followed):
    branch, _ = followed
    jump = next(s for s in branch.special if s.jump)
    each = list(zip(branch.values, branch.orbits, strict=True))
    last = int(np.argmin([abs(v - jump.value) + abs(o.period - jump.orbit.period) for v, o in each]))
    assert next(o for v, o in each[last:] if v < jump.value).stable


@pytest.mark.parametrize("limits", [{"slow": 1}, {"reach": np.full(4, 1e-2)}, {"slow": 2, "reach": np.full(4, 1.0)}])
def test_a_search_that_leads_nowhere_ends_early(limits):
    belt = sf.scenes.mass_on_belt(v_b=0.2)
    flow, values = flow_of(belt, ("v_b",)), {s.name: v for s, v in belt.parameter_values().items()}
    system, alone = ShootingSystem(flow, values), np.array([0.0, 0.0, 0.0, 1.0])
    orbit = sf.limit_cycle(belt)
    near = system.pack(np.array(orbit.start) * (1 + 1e-6), orbit.period, values)
    assert solve(system, near, alone, **limits).rest == pytest.approx(0, abs=1e-11)
    nowhere = np.append(near[:-1], 0.6)  # a speed at which the belt has no cycle

    def trials(**limits):
        """The number of runs until the search fails."""
        with counted(ShootingSystem, "at") as runs, pytest.raises(NotFound):
            solve(system, nowhere, alone, **limits)
        return runs.call_count

    assert trials(**limits) < 0.5 * trials()
