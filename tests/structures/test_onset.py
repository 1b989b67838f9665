"""Onset of vibration of structures beside its amplitude: the Hopf coefficient against limit cycles."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

st = sf.structures
V, MU = sp.symbols("v_b mu", positive=True)


def test_small_cycles_of_a_chain_are_those_of_its_hopf_coefficient():
    s = st.chain(3, damping=0.05, ends="fixed-free")
    pad = st.RowContact("pad", {"x3": 1.0}, 1.0, sf.laws.cubic(0.4, 0.25, 0.5), speed=V)
    scene = s.scene([pad], values={V: 0.3})
    found = sf.hopf(scene, "v_b", bracket=(0.05, 0.7))
    assert found.kind == "supercritical"
    errors = []
    for below in (1e-3, 2.5e-4):
        here = scene.where({V: found.value - below})
        rest, around = sf.equilibrium(here).x, sf.stability(here)
        k = int(np.argmax(around.eigenvalues.real))
        size = np.sqrt(around.eigenvalues[k].real / -found.first_lyapunov)
        M, B, K = (np.array(e, dtype=float) for e in (around.M, around.B, around.K))
        rows = np.linalg.solve(M, np.hstack([K, B]))
        values, vectors = np.linalg.eig(np.vstack([np.eye(3, 6, 3), -rows]))
        swing = vectors[:, int(np.argmax(values.real))]
        start = np.array(rest) + size * (swing / swing[0]).real
        orbit = sf.limit_cycle(here, (start, 2 * np.pi / found.omega))
        assert orbit.stable
        errors.append(orbit.half_range[0] / size - 1)
    assert abs(errors[0]) < 1e-3
    assert errors[1] == pytest.approx(errors[0] / 4, rel=0.05)  # the next order of the normal form


def test_mode_coupling_under_coulomb_friction_has_no_cubic_coefficient():
    """The equations of sliding are linear: the amplitude is decided by lift-off and sticking, not near the onset."""
    s = st.Structure(np.eye(2), [[1.05, 0.2], [0.2, 0.0]], 0.02 * np.eye(2), names=["x", "y"])
    load = st.RowLoad(1.0, {"y": 1.0}, push={"y": -1.0})
    belt = st.RowContact("belt", {"x": 1.0}, load, sf.laws.coulomb(MU), speed=1.0)
    scene = s.scene([belt], values={MU: 0.3}, horizon=300.0)
    found = sf.hopf(scene, "mu", bracket=(0.1, 0.4))
    assert found.value == pytest.approx(0.205175, abs=1e-6)
    assert found.kind == "degenerate"


@pytest.mark.long(beside="test_small_cycles_of_a_chain_are_those_of_its_hopf_coefficient")
def test_from_the_onset_along_limit_cycles_to_lift_off():
    s = st.Structure(np.eye(2), [[1.05, 0.2], [0.2, 0.0]], 0.02 * np.eye(2), names=["x", "y"])
    load = st.RowLoad(1.0, {"y": 1.0}, push={"y": -1.0})
    belt = st.RowContact("belt", {"x": 1.0}, load, sf.laws.custom(MU * (1 - 0.2 * sp.exp(-sf.SPEED)), MU), speed=1.0)
    scene = s.scene([belt], values={MU: 0.3}, horizon=300.0)
    found = st.onset(scene, "mu", (0.1, 0.4), span=(0.21, 0.224))
    (first,) = found.lift_off
    assert first.contact == "belt"
    assert first.orbit.x_min[first.orbit.names.index("y")] == pytest.approx(-1.0, abs=1e-5)  # N = 1 + y
    assert found.hopf.value < first.value < 0.224
    smaller = sf.limit_cycle(scene.where({MU: 0.5 * (found.hopf.value + first.value)}), first.orbit)
    assert smaller.x_min[1] > -1.0
    constant = st.RowContact("belt", {"x": 1.0}, load, sf.laws.coulomb(MU), speed=1.0)
    linear = s.scene([constant], values={MU: 0.3})
    with pytest.raises(sf.NotFound, match="decided near the onset but by lift-off and sticking"):
        st.onset(linear, "mu", (0.1, 0.4))
