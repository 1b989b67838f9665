"""The figures of drawn slides: their numbers against the theory and the solver, and pictures without collisions."""

import sys

import numpy as np
import pytest

from symfric.theory import drive
from symfric_evidence.sources.guida import slide_figures, slides
from symfric_evidence.sources.registry import Inputs

FEWER = {  # points, where the default takes seconds
    "guida-4": lambda _: slides.threshold_surfaces(11),
    "guida-readings": lambda _: slides.readings(7),
    "guida-stability": lambda _: slides.stability_gap(17),
}


@pytest.fixture(scope="module")
def data():
    return {name: FEWER.get(name, entry.compute)(Inputs()) for name, entry in slide_figures.FIGURES.items()}


@pytest.mark.long(beside="test_motions_of_the_source_s_figures")
def test_the_maps_have_the_source_s_panels_and_curves(data):
    maps = data["guida-5"]
    assert [m.p_star for m in maps] == [-0.1, -0.2, -0.3, -0.4, -0.5, -0.6, -0.7, -0.8]
    for found in maps:
        assert list(found.curves) == [-0.1, -0.3, -0.6, -0.9]
        for mu1, (mu2, epsilon) in found.curves.items():
            assert mu2.shape == epsilon.shape == (60,)
            assert np.all(np.diff(epsilon) > 0)
            assert mu2[0] == pytest.approx(0.05, rel=1e-5) or epsilon[0] < 0.1  # begins at an edge of the picture
            assert epsilon[-1] > 100
            assert epsilon[30] == drive.threshold(mu1, mu2[30], found.p_star)
        steeper = [np.interp(20.0, epsilon, mu2) for mu2, epsilon in found.curves.values()]
        assert np.all(np.diff(steeper) > 0)


@pytest.mark.parametrize("p_star", [-0.1, -0.6])
def test_the_edge_of_the_maps_is_where_the_threshold_begins(p_star):
    edge = slides.zero_edge(-0.6, p_star)
    assert drive.threshold(-0.6, edge * (1 - 1e-8), p_star) == 0 < drive.threshold(-0.6, edge * (1 + 1e-8), p_star)


def test_errors_of_type_a_do_not_depend_on_the_second_slope(data):
    for name, slopes in slides.ERROR_SLOPES.items():
        diagrams = data[name]
        assert tuple(d.mu1 for d in diagrams) == slopes
        for found in diagrams:
            curves = np.array(list(found.error.values()))
            a = found.lam <= found.limit
            assert np.all(np.ptp(curves[:, a], axis=0) == 0)
            assert np.all(np.diff(curves[:, ~a], axis=0) < 0)
    assert data["guida-10"][2].error[0.5][39] == drive.positioning_error(-0.5, 0.5, 4.0).value - 4.0


def test_motions_of_the_source_s_figures(data):
    still, cycling, damped = (data[f"guida-{k}"] for k in (14, 15, 16))
    late = still.t > 60
    assert not still.sticking[late].any()
    assert still.eta1[late] == pytest.approx(-1.0, abs=0.05)
    assert still.eta2[late] == pytest.approx(2.0, abs=0.05)  # steady sliding
    known = drive.two_slides_cycle(**slides.PAIR, fs1=7.8)
    assert (np.ptp(cycling.eta1), np.ptp(cycling.eta2)) == pytest.approx(known.ranges, abs=1e-4)
    assert (cycling.t[0], cycling.t[-1]) == (60, 140)
    relative = cycling.u1 - cycling.u2
    assert relative[cycling.sticking] == pytest.approx(-1, abs=1e-12)
    assert np.mean(damped.sticking) > 0.3


def test_only_one_reading_of_s2_fits_the_figures(data):
    found = data["guida-readings"]
    assert found.fitting == ("omega1",)
    assert found.threshold["omega1"] == pytest.approx(7.742901728076077, rel=1e-12)
    assert found.threshold["omega2"] == pytest.approx(4.365104609277730, rel=1e-12)
    assert found.statement().endswith("The source's figures fit d2 = s2, as (24) is printed.")
    assert found.fs1["omega2"] == pytest.approx(
        drive.two_slides_thresholds("s2", found.s2 / 2, r=0.5, zeta=2, s1=0.2), rel=1e-12
    )


def test_definiteness_is_exact_only_where_the_frequencies_agree(data):
    gap = data["guida-stability"]
    room = gap.exact - gap.definite
    middle = int(np.argmin(np.abs(gap.zeta - 1)))
    assert room[middle] == pytest.approx(0, abs=1e-12)
    assert np.all(np.delete(room, middle) > 0)
    assert np.interp(2.0, gap.zeta, gap.exact) == pytest.approx(0.17993804875, abs=1e-5)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["guida-5", "guida-15", "guida-readings", "guida-stability"])
def test_nothing_in_a_picture_collides(name, data):
    figure = np.atleast_1d(slide_figures.FIGURES[name].draw(data[name])).flat[0].figure
    for _ in range(2):  # the layout makes room for a legend above the axes in a second pass
        figure.draw_without_rendering()
    flat = [ax for ax in figure.axes if ax.name == "rectilinear"]
    words = [t for ax in flat for t in (ax.xaxis.label, ax.yaxis.label, ax.title) if t.get_text()]
    above = [e for ax in flat if (e := ax.get_legend())] + list(figure.legends)
    boxes = [e.get_window_extent() for e in (*words, *above)]
    assert words
    for k, box in enumerate(boxes):
        assert figure.bbox.x0 - 1 <= box.x0
        assert box.x1 <= figure.bbox.x1 + 1
        assert box.y1 <= figure.bbox.y1 + 1
        assert not any(box.overlaps(other) for other in boxes[:k])


def test_what_the_source_says_is_judged(data):
    verdicts = {n: [f.holds for f in e.findings(data[n])] for n, e in slide_figures.FIGURES.items()}
    assert verdicts["guida-14"] == verdicts["guida-15"] == verdicts["guida-16"] == [True]
    assert verdicts["guida-10"] == verdicts["guida-11"] == [False, True, False]
    assert verdicts["guida-readings"] == verdicts["guida-stability"] == [False]


def test_axes_may_be_given_and_no_global_state_is_left(data):
    found, pyplot = data["guida-stability"], sys.modules.get("matplotlib.pyplot")
    before = pyplot.get_fignums() if pyplot else []
    given = slide_figures.new_axes()
    assert slide_figures.plot_stability_gap(found, given) is given
    panels = slide_figures.panels(2, 2, (6.0, 6.0))
    assert slide_figures.plot_errors(data["guida-10"], panels) is panels
    if "matplotlib.pyplot" in sys.modules:
        assert sys.modules["matplotlib.pyplot"].get_fignums() == before
