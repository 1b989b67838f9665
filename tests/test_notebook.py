"""In a notebook: a result is one short line or one small table, a scene its equations, a plot takes an Axes."""

import xml.dom.minidom

import numpy as np
import pytest
import sympy as sp
from matplotlib.figure import Figure

import symfric as sf
from symfric.model.notebook import html_table


@pytest.fixture(scope="module")
def results():
    belt, damper = sf.scenes.mass_on_belt(v_b=0.2), sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.005)
    stopped = sf.simulate(damper)
    return {
        "equilibrium": sf.equilibrium(belt),
        "stability": sf.stability(belt),
        "hopf": sf.hopf(belt, "v_b", bracket=(0.3, 0.6)),
        "slow flow": sf.average(belt),
        "design": sf.design.quench(belt, speeds=(0.1, 0.4), Omega=(20, 60), a=(0, 0.02)),
        "error": sf.theory.drive.positioning_error(-0.5, 0.8, 4.0),
        "cycle": sf.theory.drive.two_slides_cycle(r=0.5, zeta=2, s1=0.2, s2=0.3, fs1=7.8),
        "energy": sf.theory.transient.energy_balance(stopped),
        "decisions": sf.theory.transient.decisions(stopped),
        "motion": sf.motions.sine_burst(1.0, 2.0),
        "run": stopped,
        "explanation": sf.explain(belt),
        "orbit": sf.limit_cycle(belt),
        "branch": sf.continue_cycle(belt, "v_b", (0.19, 0.21)),
    }


def test_a_result_is_one_small_table_and_one_short_line(results):
    for name, result in results.items():
        page = xml.dom.minidom.parseString(result._repr_html_())
        rows = [r for r in page.documentElement.firstChild.nextSibling.childNodes if r.nodeName == "tr"]
        assert 1 < len(rows) < 25, name
        cells = [c.firstChild.data for c in page.getElementsByTagName("td") if c.firstChild.nodeName == "#text"]
        assert all(len(c) < 500 for c in cells), name
        assert not any(c.startswith(("{", "[", "(")) for c in cells), name  # nothing raw
        assert page.getElementsByTagName("caption")[0].firstChild.data
        assert len(repr(result)) < 250, name
        assert "\n" not in repr(result)


def test_numbers_are_those_of_the_result(results):
    assert "<td>0.440959</td>" in results["hopf"]._repr_html_()
    assert "<td>6.28739</td>" in results["error"]._repr_html_()
    assert "values: Omega</th>" in results["design"]._repr_html_()


def cells_of(result, label: str) -> list[str]:
    """Return the texts of the cells beside a label."""
    page = xml.dom.minidom.parseString(result._repr_html_())
    (row,) = [r for r in page.getElementsByTagName("tr") if r.firstChild.firstChild.data == label]
    return [c.firstChild.data for c in row.getElementsByTagName("td") if c.firstChild.nodeName == "#text"]


def test_matrices_events_and_special_points_are_tables(results):
    assert cells_of(results["stability"], "K") == ["1"]
    assert cells_of(results["stability"], "eigenvalues")[0].count(" i") == 2
    two = sf.stability(sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=5.0, fs1=7.8))
    assert cells_of(two, "K") == ["1", "0", "0", "0.5"]
    first = results["orbit"].events[0]
    assert cells_of(results["orbit"], "events")[:4] == [f"{first.t:.6g}", "belt", "slips backward", "sticks"]
    assert cells_of(results["orbit"], "states")[:2] == ["x", f"{results['orbit'].start[0]:.6g}"]
    assert "<td><math>" in results["slow flow"]._repr_html_()
    name = sp.Symbol("<script>")
    assert "<script>" not in html_table("Kind", {"rate": name**2, "edge": sp.Piecewise((name, name < 1), (0, True))})
    special = sf.continue_cycle(sf.scenes.mass_on_belt(v_b=0.4), "v_b", (0.36, 0.42))
    assert cells_of(special, "special")[0] == special.special[0].kind
    assert cells_of(special, "values")[0].startswith(f"{special.values.size} values from 0.36 to 0.42")


def test_sticking_is_marked_on_an_orbit(results):
    orbit = results["orbit"]
    (held,) = [
        line for line in orbit.plot(Figure().add_subplot()).get_lines() if line.get_label() == "a contact sticks"
    ]
    velocity = held.get_ydata()[np.isfinite(held.get_ydata())]
    assert velocity == pytest.approx(0.2, abs=1e-9)  # the belt's
    reached = held.get_xdata()[np.isfinite(held.get_ydata())]
    assert np.ptp(reached) == pytest.approx(0.2 * orbit.stick_time, rel=1e-6)


def test_units_are_on_the_axes_of_a_run(results):
    ax = results["run"].plot(Figure().add_subplot(), units={"x": "m", "t": "s"})
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time t [s]", "x [m]")
    two = sf.simulate(sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=5.0, fs1=7.8).until(1.0))
    ax = two.plot(Figure().add_subplot(), units={"eta1": "m", "eta2": "rad"})
    assert ax.get_ylabel() == "coordinate"
    assert ax.get_legend().get_texts()[1].get_text() == "eta2 [rad]"


def test_a_scene_shows_its_values_start_and_horizon():
    shown = sf.scenes.mass_on_belt(v_b=0.2).where({"beta": 1e-9})._repr_latex_()
    for part in ("v_{b} = 0.2", r"\beta = 1.0 \cdot 10^{-9}", "x(0) = 0", r"0 \le t \le 100"):
        assert part in shown
    free = sf.scenes.contact_damper(f_n=10, mu_m=0.1)._repr_latex_()
    assert "x(0) = x_{0}" in free


def test_a_scene_shows_its_equations():
    shown = sf.scenes.mass_on_belt(v_b=0.2)._repr_latex_()
    assert shown.startswith("$")
    assert r"\operatorname{sign}" in shown or "v_{b}" in shown


@pytest.mark.parametrize("name", ["stability", "slow flow", "design", "motion"])
def test_a_plot_takes_an_axes_and_returns_it(results, name):
    ax = Figure().add_subplot()
    assert results[name].plot(ax) is ax
    assert ax.get_xlabel()
    assert ax.get_ylabel()
