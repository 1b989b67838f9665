"""In a notebook: a result is one short line or one small table, a scene its equations, a plot takes an Axes."""

import xml.dom.minidom

import pytest
from matplotlib.figure import Figure

import symfric as sf


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
        cells = [c.firstChild.data for c in page.getElementsByTagName("td")]
        assert 1 < len(cells) < 25, name
        assert all(len(c) < 400 for c in cells), name
        assert page.getElementsByTagName("caption")[0].firstChild.data
        assert len(repr(result)) < 250, name
        assert "\n" not in repr(result)


def test_numbers_are_those_of_the_result(results):
    assert "<td>0.440959</td>" in results["hopf"]._repr_html_()
    assert "<td>6.28739</td>" in results["error"]._repr_html_()
    assert "values: Omega</th>" in results["design"]._repr_html_()


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
