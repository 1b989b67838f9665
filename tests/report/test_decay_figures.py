"""Reproduction of the contact-damper source: data against closed forms, claims against known numbers, pictures as drawn."""

import json

import numpy as np
import pytest

import symfric as sf
from symfric.report.study.drawing.axes import to_svg
from symfric.theory import transient
from symfric_evidence.sources.panels import plot_figure, plot_panel
from symfric_evidence.sources.reproduction import reproductions
from symfric_evidence.sources.younes_ashour import claims, claims_table
from symfric_evidence.sources.younes_ashour.decay_figures import FIGURES
from symfric_evidence.sources.younes_ashour.decays import FALLING, LAWS, PRINTED, decay, run_of, start_of


@pytest.fixture(scope="module")
def data():
    return {name: make() for name, make in FIGURES.items()}


@pytest.fixture(scope="module")
def verdicts():
    return {(c.where, c.words): c for c in claims()}


def curves(figure, law):
    (panel,) = (p for p in figure.panels if p.title == law and p.y_label == "decay time [s]")
    return panel.curves


# --- Decays by the hundred are those of the scene ---------------------------------------------------------------


@pytest.mark.one_in(4)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("start", [{"x0": 0.01}, {"x0": 0.0, "v0": 0.3}])
def test_a_decay_is_that_of_the_scene(law, start):
    scene = sf.scenes.contact_damper(f_n=5.3, mu_m=0.19, zeta=0.009, literal=law == PRINTED, **start)
    run = sf.simulate(scene, 1e-12)
    found = decay(law, f_n=5.3, mu_m=0.19, zeta=0.009, **start)
    assert found.time == pytest.approx(run["stop_time"], rel=1e-9)
    assert found.rest == pytest.approx(run.final[0], rel=1e-9)
    assert found.half_cycles == len(run.events)
    assert found.ratio == pytest.approx(transient.energy_balance(run).ratio, rel=1e-9)
    assert found.closest == pytest.approx(transient.decisions(run).closest, rel=1e-8)


def test_starts_have_the_energy():
    x0, v0 = (start_of(0.05, f_n=7.0, m=0.5, impulse=i) for i in (False, True))
    for start in ({"x0": x0, "v0": 0.0}, {"x0": 0.0, "v0": v0}):
        run = run_of(FALLING, f_n=7.0, mu_m=0.1, **start)
        balance = transient.energy_balance(run)
        assert balance.input == pytest.approx(0.05, rel=1e-12)
        assert abs(balance.gap) < 1e-11


# --- Figures -----------------------------------------------------------------------------------------------------


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", FIGURES)
def test_figures_are_data(data, name):
    figure = data[name]
    plain = figure.to_dict()
    json.dumps(plain, allow_nan=False)
    assert plain["figure"] == name
    assert {c.label for p in figure.panels for c in p.curves if p.title == LAWS[1]} or name[7:] in "3489"
    for panel in figure.panels:
        for curve in panel.curves:
            assert curve.x.shape == curve.y.shape
            assert np.all(np.isfinite(curve.y))


@pytest.mark.parametrize("name", ["younes-3", "younes-4"])
def test_transients_come_to_rest_within_the_picture(data, name):
    for panel in data[name].panels:
        assert [c.label for c in panel.curves] == list(LAWS)
        for curve in panel.curves:
            assert curve.y[0] == pytest.approx(10.0)
            assert curve.y[-1] == curve.y[-50] != 0


@pytest.mark.parametrize("name", ["younes-5", "younes-10"])
def test_decays_stay_within_half_of_a_half_cycle_of_the_averaged_law(data, name):
    found = curves(data[name], FALLING)
    averaged = {c.group: c for c in found if c.dash == "dotted"}
    half = {0: 3.5, 1: 5.0, 2: 10.0, 3: 20.0} if name == "younes-5" else dict.fromkeys(range(2), 5.3)
    for curve in (c for c in found if c.dash != "dotted"):
        assert np.all(np.abs(curve.y - averaged[curve.group].y) < 0.26 / half[curve.group] + 0.02 * curve.y)


@pytest.mark.parametrize("law", LAWS)
def test_decay_time_jumps_where_a_decision_was_close(data, law):
    curve = curves(data["younes-5"], law)[0]
    half, margin = 0.5 / 3.5, np.abs(curve.closest)
    jumps = np.flatnonzero(np.abs(np.diff(curve.y)) > 0.5 * half)
    beside = np.minimum(margin[jumps], margin[jumps + 1])
    assert jumps.size >= 5
    assert np.median(beside) < 0.3 * np.median(margin)


def test_at_equal_energy_the_frequency_hardly_matters(data):
    for law in LAWS:
        times = np.array([c.y for c in curves(data["younes-6"], law)])
        assert np.max(np.ptp(times, axis=0)) < 1 / 3.5


def test_ratio_grows_with_energy_and_damping(data):
    for panel in (p for p in data["younes-7"].panels if p.y_label.startswith("$R")):
        ratios = np.array([c.y for c in panel.curves])
        assert np.all(np.diff(ratios, axis=1) > 0)
        assert np.all(np.diff(ratios, axis=0) > 0)


def test_weak_damping_takes_what_the_closed_form_says():
    zeta, x0 = 1e-4, 2e-4
    found = decay(f_n=10.0, mu_m=0.001, zeta=zeta, x0=x0, v_c=1e9)
    expected = np.pi * zeta * (20 * np.pi) ** 2 * x0 / (3 * 0.001 * 9.81)
    assert found.ratio == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("name", ["younes-8", "younes-9"])
def test_accelerations_start_and_end_with_the_equation(data, name):
    mu_m = {"younes-8": 0.19, "younes-9": 0.3}[name]
    for panel, x0 in zip(data[name].panels, (0.01, 0.003), strict=True):
        for curve in panel.curves:
            assert curve.y[1] == pytest.approx(-((2 * np.pi * 5.3) ** 2) * x0 + 9.81 * mu_m, rel=0.01)
            assert np.all(curve.y[-20:] == 0)
    assert data["younes-9"].findings[0].holds


# --- Claims ------------------------------------------------------------------------------------------------------

VERDICTS = {
    ("figure 3, conclusion 1", "from a given displacement, no damping"): False,
    ("figure 3, conclusion 1", "from a given energy, no damping"): False,
    ("figure 3, conclusion 1", "from a given displacement, damping ratio 0.1, 10 to 20 Hz"): True,
    ("figure 4", "corrected law"): False,
    ("figure 4", "law as printed, displaced to x0 > 0"): True,
    ("figure 4", "constant friction"): True,
    ("figure 5", "3.5 to 20 Hz"): False,
    ("figure 5", "up to the frequency given"): True,
    ("figure 6", "a larger displacement"): False,
    ("figure 6", "displacement or impulse of equal energy, within half a period"): True,
    ("figure 7, conclusion 2", "halving friction costs less than half as much time as without damping"): True,
    ("abstract, conclusion 3", "corrected law"): True,
    ("abstract, conclusion 3", "law as printed"): True,
    ("conclusion 4", "measured records"): None,
}


def test_claims_hold_where_the_derivations_say_so(verdicts):
    found = {(c.where, r.words): r.holds for c in verdicts.values() for r in c.readings}
    assert {key: found[key] for key in VERDICTS} == VERDICTS


def test_every_claim_has_a_verdict_with_numbers(verdicts):
    model = {"so in the model", "not so in the model", "partly so in the model"}
    words = {"true", "true only under a stated reading", "not testable", *model}
    for claim in verdicts.values():
        assert claim.verdict in words | {"false"}
        assert (claim.verdict in model) == (claim.measured and claim.where != "conclusion 4")
        assert all(r.evidence or r.holds is None for r in claim.readings)
    rows = claims_table(tuple(verdicts.values()))
    json.dumps(rows, allow_nan=False)
    assert len(rows) == sum(len(c.readings) for c in verdicts.values())
    assert {r["verdict"] for r in rows} >= words


def test_measured_records_are_not_refuted_by_the_model(verdicts):
    (line,) = (c for c in verdicts.values() if "varies linearly" in c.words)
    assert line.verdict == "not so in the model"
    assert line.readings[0].evidence["exponent"] == pytest.approx(0.534, abs=2e-3)
    entry = reproductions()["younes-claims"]
    findings = [f for f in entry.make().findings if "figure 10" in f.claim]
    assert [f.holds for f in findings] == [True, None, None]
    assert "about measured records, not so in the model" in findings[-1].found


def test_two_seconds_are_reached_at_fourteen_hertz(verdicts):
    (claim,) = (c for c in verdicts.values() if c.where == "figure 5")
    assert claim.readings[-1].evidence["frequency of 2 s, Hz"] == pytest.approx(14, abs=0.1)


# --- Pictures ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["younes-4", "younes-5", "younes-10"])
def test_pictures_show_the_data_with_labels(data, name):
    figure = plot_figure(data[name])[0].figure
    assert len(figure.axes) == len(data[name].panels)
    for ax, panel in zip(figure.axes, data[name].panels, strict=True):
        assert ax.get_xlabel() == panel.x_label
        assert ax.get_ylabel().endswith("]")
        for line, curve in zip(ax.lines, panel.curves, strict=True):
            np.testing.assert_array_equal(line.get_ydata(), curve.y)
    shown = [t.get_text() for t in figure.legends[0].get_texts()]
    assert len(shown) == len(set(shown)) == len({c.label for p in data[name].panels for c in p.curves})


def test_a_panel_takes_an_ax(data):
    ax = plot_panel(data["younes-4"].panels[0])
    assert plot_panel(data["younes-4"].panels[1], ax) is ax
    assert to_svg(ax).startswith("data:image/svg+xml")
