"""Orbits of structures: forced responses, derivatives with many states, the brake from matrices to squeal."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.orbits.flow_map import flow_of

st = sf.structures
W, N, V = sp.symbols("W N v_b", positive=True)


def test_peak_of_a_linear_response_in_closed_form():
    D = 0.08
    force = {"x1": sp.cos(W * sf.TIME)}
    scene = st.Structure([[1.0]], [[1.0]], [[2 * D]], names=["x1"]).scene([], force, {W: 0.95}, horizon=80.0)
    peak = sf.frequency_response(scene, "W", (0.9, 1.1)).peak
    assert peak.value == pytest.approx(np.sqrt(1 - 2 * D**2), rel=1e-6)
    assert peak.half_range == pytest.approx(1 / (2 * D * np.sqrt(1 - D**2)), rel=1e-9)


@pytest.mark.long(beside="test_responses_of_a_joint_from_sliding_to_sticking_for_good")
def test_response_of_a_damped_joint_falls_and_sticks_with_the_load():
    s = st.chain(2, damping=0.1, ends="fixed-free")
    joint = st.RowContact("joint", {"x2": 1.0}, N, sf.laws.coulomb(0.5))
    scene = s.scene([joint], {"x1": sp.cos(W * sf.TIME)}, {W: 0.6, N: 0.5}, horizon=60.0)
    low, high = (sf.frequency_response(scene.where({N: n}), W, (0.5, 0.7), tolerance=1e-10).peak for n in (0.1, 0.5))
    assert low.half_range > 1.3 * high.half_range
    again = sf.limit_cycle(scene.where({N: 0.5, W: high.value}))
    assert again.half_range[0] == pytest.approx(high.half_range, rel=1e-7)
    for d in (-1e-3, 1e-3):
        beside = sf.limit_cycle(scene.where({N: 0.5, W: high.value + d}), again)
        assert beside.half_range[0] < high.half_range


def test_a_response_needs_an_excitation():
    with pytest.raises(sf.SceneError, match="no force of the scene depends on time"):
        sf.frequency_response(sf.scenes.mass_on_belt(v_b=0.2), "v_b", (0.1, 0.3))


def test_derivatives_by_many_states_are_those_of_the_motion():
    n = 13
    s = st.chain(n, damping=0.2, ends="fixed-free")
    pads = [st.RowContact(f"c{i}", {f"x{n - i}": 1.0}, 1.0, sf.laws.stribeck(0.5, 0.3, 0.2), speed=V) for i in range(2)]
    scene = s.scene(pads, values={V: 0.05}, horizon=50.0)
    flow, values = flow_of(scene), {"v_b": 0.05}
    rng = np.random.default_rng(0)
    y, d = 0.1 * rng.standard_normal(2 * n), rng.standard_normal(2 * n)
    passage = flow.run(y, values, 6.0)
    assert passage.events
    assert passage.by_start.shape == (2 * n, 2 * n)
    ahead, behind = (flow.run(y + e * d, values, 6.0).end for e in (1e-6, -1e-6))
    assert passage.by_start @ d == pytest.approx((ahead - behind) / 2e-6, abs=1e-7)


def test_a_brake_from_matrices_to_squeal():
    brake = st.disc_and_pad(24, damping=0.3)
    (point, *_) = st.flutter(brake.structure, mu=(0.0, 1.0), count=4, grid=6).critical
    contacts = brake.contacts(0.01, sf.laws.coulomb(point.mu), 0.02)
    small = brake.apart.reduced(contacts, modes=30)
    found = sf.stability(small.scene(contacts)).eigenvalues
    near = found[np.argmin(np.abs(found - 1j * point.omega))]
    assert near.imag == pytest.approx(point.omega, rel=1e-2)
    assert abs(near.real) < 2e-3 * point.omega  # neutral, but for the reduction
    loads = brake.loads.sum(axis=0)
    assert loads @ np.where(np.arange(brake.structure.n) % 2, 1.0, 0.0) == pytest.approx(0)  # moved together: no change


def test_joints_of_a_structure_that_give_before_they_slip():
    """A known response from matrices, and the same motion in other coordinates."""
    joint = st.RowContact("joint", {"x1": 1.0}, 1.0, sf.laws.coulomb(0.3), stiffness=0.5)
    force = {"x1": sp.cos(W * sf.TIME)}
    s = st.Structure([[1.0]], [[1.0]], [[0.1]], names=["x1"])
    orbit = sf.limit_cycle(s.scene([joint], force, {W: 1.1}, horizon=60.0))
    assert orbit.x_max[0] == pytest.approx(3.9838389616, abs=1e-9)
    pads = [st.RowContact(f"c{i}", {f"x{i + 4}": 1.0}, 0.3, sf.laws.coulomb(0.4), stiffness=2.0) for i in range(3)]
    full = st.chain(12, damping=0.02, ends="fixed-free")
    runs = []
    for s in (full, full.reduced([*pads, "x12"], modes=8)):
        scene = s.scene(pads, {"x12": 0.2 * sp.cos(0.13 * sf.TIME)}, {}, {"c1.z": 0.01}, horizon=80.0)
        runs.append(sf.simulate(scene, 1e-10).checked())
    assert runs[0]["c2.z"][-1] == pytest.approx(runs[1]["c2.z"][-1], abs=1e-9)
    assert len(runs[0].events) == len(runs[1].events) > 2


def test_responses_of_a_joint_from_sliding_to_sticking_for_good():
    """The peak over the load falls, then rises to that of the linear oscillator with the joint's spring."""
    joint = st.RowContact("joint", {"x1": 1.0}, N, sf.laws.coulomb(0.3), stiffness=0.5)
    s = st.Structure([[1.0]], [[1.0]], [[0.04]], names=["x1"])
    scene = s.scene([joint], {"x1": sp.cos(W * sf.TIME)}, {W: 1.05, N: 1.0}, horizon=150.0)
    peaks = {}
    for load in (0.5, 5.0, 60.0):
        found = sf.frequency_response(scene.where({N: load}), W, (0.9, 1.4), tolerance=1e-10)
        assert found.ends == ("span", "span")
        # the stuck oscillator has the amplitude 3 there: (1.5 - W^2)^2 + (0.04 W)^2 = 1/9
        onsets = np.sqrt(np.sort(np.roots([1.0, 0.04**2 - 3.0, 2.25 - 1 / 9]))) if load == 5.0 else []
        assert [s.value for s in found.special] == pytest.approx(list(onsets), rel=1e-8)
        peaks[load] = found.peak.half_range
    assert peaks[60.0] == pytest.approx(1 / (0.04 * np.sqrt(1.5 - 0.04**2 / 4)), rel=1e-8)
    assert peaks[5.0] < 0.3 * min(peaks[0.5], peaks[60.0])
    stuck = sf.limit_cycle(scene.where({N: 60.0, W: 1.1}))
    assert stuck.stick_fraction == pytest.approx(1.0)
    k = stuck.names.index("joint.z")
    assert stuck.x_max[k] == pytest.approx(-stuck.x_min[k], rel=1e-9)  # nothing determines the mean: it is zero
