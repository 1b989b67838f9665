"""Derivatives of motions of many states along one recorded run, against variational equations run with the motion."""

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

import symfric as sf
from symfric.errors import NoRoute
from symfric.orbits.flow_map import flow_of
from symfric.orbits.gauss_steps import NODES, Coupling, advance, gauss, motion_of
from symfric.orbits.passages import DirectedRuns, RecordedRun

st = sf.structures
V, W = sp.symbols("v_b W", positive=True)


def rubbed(kind, n=13):
    """A driven chain on a belt: two contacts, their load, and perhaps a joint that gives."""
    s = st.chain(n, damping=0.2, ends="fixed-free")
    law = sf.laws.coulomb(0.4) if kind == "joint" else sf.laws.stribeck(0.5, 0.3, 0.2)
    pads = []
    for i in range(2):
        load = st.RowLoad(1.0, {f"x{3 + i}": 0.1}, push={f"x{3 + i}": -1.0}) if kind == "load" else 1.0
        pads.append(st.RowContact(f"c{i}", {f"x{n - i}": 1.0}, load, law, speed=V))
    if kind == "joint":
        pads.append(st.RowContact("j", {"x2": 1.0}, 0.3, sf.laws.coulomb(0.1), stiffness=0.7))
    return s.scene(pads, {"x1": 0.3 * sp.cos(W * sf.TIME)}, {V: 0.05, W: 0.2}, horizon=50.0)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", ["load", "joint"])
def test_the_same_derivatives_as_with_the_motion(kind):
    scene = rubbed(kind)
    flow, values = flow_of(scene, ("v_b",)), {"v_b": 0.05, "W": 0.2}
    assert isinstance(flow._runs, RecordedRun)
    start = 0.1 * np.random.default_rng(0).standard_normal(len(flow.states))
    start[26:] = 0.0
    found = flow.run(start, values, 25.0)
    flow._runs, kept = DirectedRuns(flow.scene, flow._automaton, ("v_b",), flow.tolerance), flow._runs
    exact = flow.run(start, values, 25.0)
    flow._runs = kept
    assert {e[1] for e in found.changes} >= ({2} if kind == "joint" else {0})
    assert found.doubtful == exact.doubtful is False
    for name in ("end", "by_start", "by_value", "low", "high", "rate"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), abs=1e-10), name
    met = (np.abs(exact.gaps) < 1e20) & (np.abs(found.gaps) < 1e20)  # where a guard is flat, a minimum is rounding
    assert np.any(met)
    for name in ("gaps", "gaps_by_start", "gaps_by_value"):
        assert getattr(found, name)[met] == pytest.approx(getattr(exact, name)[met], abs=1e-10), name


def test_steps_of_linear_equations_have_the_order_that_was_said():
    rng = np.random.default_rng(3)
    A = rng.standard_normal((6, 6)) - 2 * np.eye(6)
    B, R, D = rng.standard_normal((6, 2)), rng.standard_normal((3, 6)), rng.standard_normal((2, 3))
    motion = motion_of(A)
    assert motion.X @ motion.after(0.7, motion.inverse) == pytest.approx(expm(0.7 * A), abs=1e-12)
    exact, errors = expm(A + B @ D @ R), []
    for count in (1, 2, 4):
        slopes = np.broadcast_to(D, (count, NODES, 2, 3))
        coupling = Coupling(R @ motion.X, motion.inverse @ B, slopes, None)
        found = motion.X @ advance(motion, 1 / count, coupling, motion.inverse)
        errors.append(np.max(np.abs(found - exact)) / np.max(np.abs(exact)))
    assert errors[2] < 1e-12
    assert errors[1] < 1e-3 * errors[0]
    c, b, a = gauss()
    assert a @ c ** (NODES - 1) == pytest.approx(c**NODES / NODES, abs=1e-15)
    assert b @ c ** (2 * NODES - 1) == pytest.approx(1 / (2 * NODES), abs=1e-15)


def test_free_structures_and_defective_matrices():
    free = st.chain(30, damping=0.1, ends="free")
    A = np.block([[np.zeros((30, 30)), np.eye(30)], [-free.K.toarray(), -free.C.toarray()]])
    motion = motion_of(A)
    assert motion.X @ motion.after(50.0, motion.inverse) == pytest.approx(expm(50 * A), abs=1e-11)
    with pytest.raises(NoRoute, match="nearly dependent"):
        motion_of(np.array([[0.0, 1.0], [0.0, 0.0]]))


@pytest.mark.long(beside="test_the_same_derivatives_as_with_the_motion")
def test_a_cycle_of_two_hundred_states_costs_little_more_than_its_motion():
    """One flow map with all derivatives against the run alone, both of the same scene; their ratio is bounded."""
    import time

    n = 100
    full = st.chain(n, ends="fixed-free").diagonal()
    s = st.Structure(np.eye(n), full.K, 0.15 * np.eye(n))
    rows = [full.basis[n - 1 - 5 * i] for i in range(10)]
    joints = [st.RowContact(f"c{i}", r, 0.05, sf.laws.coulomb(0.4), stiffness=1.0) for i, r in enumerate(rows)]
    scene = s.scene(joints, [(full.basis[49], 0.5 * sp.cos(0.3 * sf.TIME))], {}, horizon=200.0)
    orbit = sf.limit_cycle(scene)
    assert orbit.multipliers.size == 210
    assert orbit.stable
    flow, period = flow_of(scene), orbit.period
    begin = time.process_time()
    flow.run(orbit.start, {}, period)
    whole = time.process_time() - begin
    program = sf.prepare(scene.until(period).starting(dict(zip(flow.states, orbit.start, strict=True))), 1e-13)
    begin = time.process_time()
    program.run()
    alone = time.process_time() - begin
    assert whole < 200 * alone


@pytest.mark.one_in(2)
def test_a_structure_that_is_free_to_move_has_derivatives_too():
    """Its eigenvectors are dependent: the motion at constant speed has two equal eigenvalues and one eigenvector."""
    s = st.chain(13, damping=0.2, ends="free")
    scene = s.scene([st.RowContact("c", {"x13": 1.0}, 1.0, sf.laws.coulomb(0.4), speed=V)], {}, {V: 0.05}, horizon=5.0)
    flow, values = flow_of(scene, ("v_b",)), {"v_b": 0.05}
    assert isinstance(flow._runs, RecordedRun)
    start = 0.1 * np.random.default_rng(0).standard_normal(26)
    found = flow.run(start, values, 3.0)
    way, step = np.random.default_rng(1).standard_normal(26), 1e-5
    for derivative, sides in (
        (found.by_start @ way, [flow.run(start + e * step * way, values, 3.0).end for e in (1, -1)]),
        (found.by_value[:, 0], [flow.run(start, {"v_b": 0.05 + e * step}, 3.0).end for e in (1, -1)]),
    ):
        assert derivative == pytest.approx((sides[0] - sides[1]) / (2 * step), abs=1e-6)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("above", [1e-12, 1e-2])
def test_a_slip_that_hardly_passes_zero_has_no_derivatives(above):
    """The speed of the pad only just reaches that of its belt, or clearly passes it."""
    pad = st.RowContact("pad", {"x13": 1.0}, 0.05, sf.laws.coulomb(0.4), speed=V)
    scene = st.chain(13, damping=0.2, ends="fixed-free").scene([pad], {"x13": 0.3}, {V: 9.0}, horizon=3.0)
    top = float(sf.simulate(scene.wanting({"top": sf.Max(scene.system.u[12])}), 1e-13)["top"])
    flow, values = flow_of(scene, ("v_b",), 1e-9), {"v_b": top * (1 - above)}
    assert isinstance(flow._runs, RecordedRun)
    found = flow.run(np.zeros(26), values, 3.0)
    assert [e[1] for e in found.events][:1] == [0]
    assert found.doubtful == (above < 1e-6)
