"""Scaled rolling isolation: numbers of records, and what similarity demands of models."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.theory.scaling import factors
from symfric_evidence.sources.rolling.study import MASS, Model, frictions, models, rolling_study
from tests.fixed_step import fixed_step

RECORDS = Path(__file__).parents[3] / "shared" / "ground_motions"
EL_CENTRO, CORRALITOS = "ElCentro1940_IELC180.AT2", "LomaPrieta1989_RSN753_CLS000.AT2"
KNOWN = [  # peak acceleration, velocity and displacement, residual
    (EL_CENTRO, 0.005, (0.15801857157, 0.32690571470, 0.095746041001, 0.015756205577)),
    (EL_CENTRO, (0.005, 0.05), (0.16624756243, 0.32606624035, 0.091129507525, -0.0030693230561)),
    (CORRALITOS, 0.005, (0.24581536844, 0.59029610531, 0.15518068088, 0.13416152937)),
]


def record(name):
    if not RECORDS.exists():
        pytest.skip("the records are not here")
    return sf.motions.read_at2(RECORDS / name)


def isolator(motion, profile=0.005, **changes):
    return sf.scenes.rolling_isolator(motion=motion, profile=profile, **{"C": 1e5, "m": MASS, **changes})


@pytest.mark.parametrize(("name", "profile", "known"), KNOWN)
def test_peaks_under_records(name, profile, known):
    run = sf.simulate(isolator(record(name), profile))
    assert run.route == "exact"
    names = ("peak_acceleration", "peak_velocity", "peak_displacement", "residual")
    assert [run[n] for n in names] == pytest.approx(known, rel=2e-10)


def test_the_series_give_the_same_peaks():
    motion = record(EL_CENTRO)
    short = sf.motions.Motion(motion.samples[:700], motion.dt)
    exact, series = (sf.simulate(isolator(short), 1e-12, route=route) for route in ("exact", "taylor"))
    assert exact.outputs == pytest.approx(series.outputs, rel=1e-9)


@pytest.fixture(scope="module")
def motions():
    return [sf.motions.synthetic(seed=k, duration=8.0, dt=0.01) for k in (1, 2)]


@pytest.fixture(scope="module")
def study(motions):
    return rolling_study(motions, intensities=(0.1, 0.5), scaled_positions=True)


def test_every_case_has_an_answer(study):
    assert study.status.size == 2 * 8 * 25 * 2 * 2
    assert not study.status.any()


def test_with_scaled_gravity_and_positions_every_model_returns_the_prototype(study):
    scaled = study.sel(model=[m for m in study.model.values if m.endswith("scaled g")])
    for name in ("peak_acceleration", "peak_velocity", "peak_displacement"):
        assert float(abs(scaled[f"ratio_{name}"] - 1).max()) < 1e-12
    size = study["peak_displacement"].sel(model="prototype").max()
    lengths = np.array([m.factors.length for m in models() if m.name.endswith("scaled g")])
    back = scaled["residual"] / lengths[None, None, :, None, None]
    assert float(abs(back - study["residual"].sel(model="prototype")).max()) < 1e-12 * float(size)


def test_gravity_of_the_shaking_table_is_another_friction(motions):
    even = {"case 1": 0.005}
    by = factors(7.0)
    model = Model("distorted", by, scaled_gravity=False)
    distorted = rolling_study(motions, intensities=(0.3,), profiles=even, against=(models()[0], model))
    seen = {"seen": 0.005 * by.friction_distortion}
    prototype = rolling_study(motions, intensities=(0.3,), profiles=seen, against=models()[:1])
    returned = distorted["peak_displacement"].sel(model="distorted") / by.length
    truth = prototype["peak_displacement"].sel(model="prototype")
    assert returned.values == pytest.approx(truth.values, rel=1e-12)


def test_unscaled_positions_make_an_uneven_floor_another_one(motions):
    uneven = {k: v for k, v in frictions().items() if k == "case 3"}
    fixed = rolling_study(motions, intensities=(0.5,), profiles=uneven, against=models()[:3])
    assert float(abs(fixed["ratio_peak_displacement"] - 1).max()) > 1e-3


def test_a_patched_floor_has_its_mean_and_deviation():
    edges, values = sf.patched_floor(4.0, 81, 0.005, 0.000815, 0.001, seed=3)
    assert values.mean() == pytest.approx(0.005, rel=1e-12)
    assert values.std() == pytest.approx(0.000815, rel=1e-12)
    for seed in range(30):
        within = np.abs(sf.patched_floor(4.0, 81, 0.005, 0.002355, 0.004, seed=seed)[1] - 0.005)
        assert within.max() <= 0.004 * (1 + 1e-9)
    with pytest.raises(sf.SceneError, match="3 cells drawn with seed 1 do not get the deviation"):
        sf.patched_floor(4.0, 3, 0.005, 0.001, 0.0011, seed=1)
    assert np.array_equal(values, sf.patched_floor(4.0, 81, 0.005, 0.000815, 0.001, seed=3)[1])
    assert edges[0] == -2.0
    assert edges[-1] == 2.0
    with pytest.raises(sf.SceneError, match="nothing within it has the deviation"):
        sf.patched_floor(4.0, 81, 0.005, 0.002, 0.001, seed=3)


def test_fixed_steps_are_of_first_order_in_the_peaks_and_erratic_in_the_residual(motions):
    motion = motions[0].scaled(3.0)
    exact = sf.simulate(isolator(motion, C=2e5))
    truth = np.array([exact["peak_velocity"], exact["residual_end_of_record"]])
    cuts, errors = 2 ** np.arange(8), []
    for n in cuts:
        times = np.arange((motion.samples.size - 1) * n + 1) / n
        fine = np.interp(times, np.arange(motion.samples.size), motion.samples)
        found = fixed_step(fine, motion.dt / n, 2e5 / MASS, 0.005 * 9.81)
        errors.append(np.abs((np.array([found[1], found[3]]) - truth) / truth))
    peak, residual = np.transpose(errors)
    assert np.polyfit(np.log(cuts), np.log(peak), 1)[0] == pytest.approx(-1.0, abs=0.2)
    assert np.any(np.diff(residual) > 0)
    assert residual[0] > 20 * peak[0]


@pytest.mark.long(beside="test_peaks_under_records")
def test_the_table_is_made_from_a_folder_of_records(tmp_path, motions):
    for k, motion in enumerate(motions):
        numbers = "\n".join(f"{a / 9.81:.7E}" for a in motion.samples[:300])
        header = f"PEER\nsynthetic {k}\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 300, DT= .01000 SEC\n"
        (tmp_path / f"{k}.AT2").write_text(header + numbers + "\n")
    arguments = ["reproduce", "rolling-table-3", "--records", str(tmp_path), "-o", str(tmp_path / "out"), "--quiet"]
    outcome = CliRunner().invoke(main, arguments)
    assert outcome.exit_code == 0, outcome.output
    assert (tmp_path / "out" / "rolling-table-3.png").read_bytes().startswith(b"\x89PNG")
    assert "case 3" in (tmp_path / "out" / "rolling-table-3.txt").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["rolling-table-4"], "no figure 'rolling-table-4'; did you mean rolling-table-3?"),
        (["rolling-table-3", "--records", "nowhere"], "nowhere is not a folder of records"),
    ],
)
def test_bad_input_is_one_line(arguments, message, tmp_path):
    outcome = CliRunner().invoke(main, ["reproduce", *arguments, "-o", str(tmp_path)])
    assert outcome.exit_code == 2
    assert message in outcome.output


@pytest.mark.parametrize(
    "values", [[0.01, 0.01, 0.02], [0.01, 0.02, 0.02], [0.02, 0.02, 0.02], [0.01, 0.01, 0.02, 0.02]]
)
def test_neighbouring_cells_may_have_the_same_friction(values, motions):
    edges, fine = [-1.0, 0.0, 0.1, 1.0], [-1.0, -0.5, 0.0, 0.05, 0.1, 0.5, 1.0]
    split = np.repeat(values, 2) if len(values) == 3 else np.interp(fine, edges, values)
    scenes = (
        sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motions[0], profile=p) for p in ((edges, values), (fine, split))
    )
    one, two = (sf.simulate(scene) for scene in scenes)
    assert one.route == two.route == "exact"
    assert one["peak_displacement"] == pytest.approx(two["peak_displacement"], rel=1e-9)
