"""The linearised scene in python-control: poles, damping, frequency response, and the root locus of a damper."""

import json

import control
import numpy as np
import pytest

import symfric as sf
from symfric.theory import damper_loop, root_locus, stability

SLIDES = sf.scenes.two_slides(r=0.5, zeta=2.0, s1=0.2, s2=0.3, fc1=1.0, fs1=7.8)
BELT = sf.scenes.mass_on_belt(v_b=0.3, beta=0.2)


def sorted_poles(values):
    return np.sort_complex(np.round(np.asarray(values, dtype=complex), 12))


@pytest.mark.parametrize("scene", [SLIDES, BELT])
def test_poles_and_damping_are_those_of_the_eigenvalues(scene):
    found = stability(scene)
    plant = found.statespace
    assert sorted_poles(plant.poles()) == pytest.approx(sorted_poles(found.eigenvalues), abs=1e-12)
    frequency, ratio, poles = control.damp(plant, doprint=False)
    assert sorted_poles(poles) == pytest.approx(sorted_poles(found.eigenvalues), abs=1e-12)
    assert frequency == pytest.approx(np.abs(poles), rel=1e-12)
    assert ratio == pytest.approx(-poles.real / np.abs(poles), rel=1e-12)
    assert plant.state_labels == list(found.names)


def test_damping_ratios_of_the_slides_are_s1_and_zeta_s2():
    _, ratio, _ = control.damp(stability(SLIDES).statespace, doprint=False)
    assert np.sort(ratio) == pytest.approx([0.2, 0.2, 0.6, 0.6], rel=1e-12)


def test_frequency_response_by_name_is_the_matrix_formula():
    found = stability(SLIDES)
    plant = found.statespace
    assert plant.input_labels == ["force_eta1", "force_eta2"]
    assert plant.output_labels == ["eta1", "eta2"]
    omega = np.geomspace(0.05, 20, 40)
    response = plant(1j * omega)
    for k, w in enumerate(omega):
        exact = np.linalg.inv(-(w**2) * found.M + 1j * w * found.B + found.K)
        assert response[:, :, k] == pytest.approx(exact, rel=1e-10, abs=1e-14)


@pytest.mark.parametrize(("scene", "damper"), [(SLIDES, "s1"), (SLIDES, "s2"), (BELT, "beta")])
def test_root_locus_against_a_damper_by_three_ways(scene, damper):
    values = np.array([0.0, 0.05, 0.21, 0.37, 0.77, 1.3, 2.2])
    locus = root_locus(scene, damper, values)
    loop = damper_loop(scene, damper)
    response = control.root_locus_map(loop, gains=values)
    for k, value in enumerate(values):
        single = stability(scene.where({damper: value}))
        expected = sorted_poles(single.eigenvalues)
        assert sorted_poles(locus.poles[:, k]) == pytest.approx(expected, abs=1e-11)
        assert sorted_poles(response.loci[k]) == pytest.approx(expected, abs=1e-11)
        assert locus.stable[k] == single.stable or single.margin == pytest.approx(0, abs=1e-12)
    assert loop.output_labels == [f"speed_of_{damper}"]


def test_the_loop_does_not_depend_on_the_damper_it_leaves_out():
    loops = [damper_loop(SLIDES.where({"s2": s2}), "s2") for s2 in (0.0, 0.3, 4.0)]
    for loop in loops[1:]:
        assert loop.A == pytest.approx(loops[0].A, abs=1e-14)
        assert loop.B @ loop.C == pytest.approx(loops[0].B @ loops[0].C, abs=1e-14)


def test_the_gain_where_the_belt_stops_vibrating_is_the_margin_of_the_loop():
    # 2 beta + mu'(v_b) = 0 at v_b = 0.3
    loop = damper_loop(BELT, "beta")
    critical = -float(stability(BELT.where({"beta": 0.0})).B[0, 0]) / 2
    assert np.min(control.margin(loop)[0]) == pytest.approx(critical, rel=1e-6)
    assert root_locus(BELT, "beta", [0.99 * critical, 1.01 * critical]).stable.tolist() == [False, True]


def test_a_row_of_the_locus_is_one_eigenvalue():
    locus = root_locus(SLIDES, "s1", np.linspace(0.0, 0.9, 200))
    steps = np.max(np.abs(np.diff(locus.poles, axis=1)), axis=1)
    assert np.all(steps < 0.02)
    assert json.loads(json.dumps(locus.to_dict()))["parameter"] == "s1"
    assert locus.to_xarray().poles.sel(s1=0.9).values == pytest.approx(locus.poles[:, -1])
    assert repr(locus) == "RootLocus(s1 0 to 0.9: 4 poles, stable at 199 values)"


def test_a_parameter_that_is_no_damper_is_refused():
    for scene, name in ((SLIDES, "zeta"), (BELT, "v_b"), (SLIDES, "fc1")):
        with pytest.raises(sf.SceneError, match=f"{name} is no damper"):
            damper_loop(scene, name)
    with pytest.raises(sf.SceneError, match="did you mean"):
        root_locus(SLIDES, "s11", [1.0])


def test_plot_returns_axes():
    import matplotlib as mpl

    mpl.use("Agg")
    axes = root_locus(SLIDES, "s2", np.linspace(0, 1, 20)).plot()
    assert axes.get_xlabel() == "real part"
