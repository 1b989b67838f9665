"""Pictures: what is drawn is what was computed, with labels, units and no global state."""

import base64
import sys
import xml.dom.minidom

import numpy as np
import pytest

from symfric.orbits.steady_state import Vibration
from symfric.report.study.drawing.axes import new_axes, to_svg
from symfric.report.study.measurement import SampledMotion
from symfric.report.study.sections.friction import FrictionCurve, plot_friction
from symfric.report.study.sections.motion import plot_phase_portrait, plot_time_history
from symfric.report.study.sections.prediction import PredictionCurve
from symfric.report.study.sections.quench import plot_before_after
from symfric.report.study.sections.stability import plot_eigenvalues
from symfric.report.study.sections.sweep import SweepResult, plot_amplitudes

UNITS = {"x": "m", "u": "m/s", "t": "s", "v_b": "m/s"}


@pytest.fixture
def motion():
    t = np.linspace(0, 10, 500)
    x = np.vstack([np.sin(t), np.cos(t)])
    return SampledMotion(t, x, ("x", "u"), {"belt": ((1.0, 2.0), (7.0, 8.0))}, {}, "taylor", "OK", "", 4, 1e-12)


@pytest.fixture
def sweep():
    values = np.linspace(0.1, 0.5, 5)
    computed = tuple(Vibration(v, -v) for v in values)
    return SweepResult("v_b", "x", values, computed, {"onset of vibration": 0.44})


def drawn(sweep, ax=None):
    """Draw a sweep with a prediction, and with a designed excitation."""
    curve = PredictionCurve("averaging", "first order", sweep.values, 1.1 * sweep.values)
    return plot_amplitudes(sweep, UNITS, (curve,), quenched=0.1 * sweep.values, ax=ax)


@pytest.fixture
def friction():
    v = np.linspace(0, 1, 50)
    return FrictionCurve("belt", v, 0.4 - 0.1 * v, 0.4, (("designed", 0.3 * v),), 0.2)


EIGENVALUES = np.array([0.1 + 1j, 0.1 - 1j, -0.2 + 0j])


def texts(ax) -> str:
    legend = ax.get_legend()
    words = [t.get_text() for t in legend.get_texts()] if legend else []
    return " ".join([ax.get_xlabel(), ax.get_ylabel(), *words])


def test_time_history_draws_the_motion_and_shades_sticking(motion):
    ax = plot_time_history(motion, ["x"], UNITS)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), motion.x[0])
    assert len(ax.patches) == 2
    assert "sticking" in texts(ax)
    assert "[s]" in ax.get_xlabel()
    assert "[m]" in ax.get_ylabel()


def test_several_coordinates_share_an_axis_and_its_unit(motion):
    ax = plot_time_history(motion, ["x", "u"], {"x": "m", "u": "m"})
    assert ax.get_ylabel() == "displacement [m]"
    assert plot_time_history(motion, ["x", "u"], UNITS).get_ylabel() == "displacement"


def test_phase_portrait_marks_sticking_where_it_happens(motion):
    ax = plot_phase_portrait(motion, "x", "u", ["belt"], UNITS, drive=0.2)
    stuck = next(line for line in ax.lines if line.get_label() == "sticking")
    drawn = np.isfinite(stuck.get_ydata())
    inside = ((motion.t >= 1) & (motion.t <= 2)) | ((motion.t >= 7) & (motion.t <= 8))
    np.testing.assert_array_equal(drawn, inside)


def test_amplitudes_show_points_and_curves(sweep):
    ax = drawn(sweep)
    points = next(line for line in ax.lines if line.get_label() == "computed")
    np.testing.assert_array_equal(points.get_ydata(), sweep.values)
    assert "averaging" in texts(ax)
    assert "onset of vibration" in texts(ax)
    assert "[m/s]" in ax.get_xlabel()


def test_friction_shows_law_and_effective_law(friction):
    ax = plot_friction(friction, "m/s")
    assert {"friction law", "designed", "steady sliding"} <= {line.get_label() for line in ax.lines}
    assert "[m/s]" in ax.get_xlabel()


def test_eigenvalues_are_split_at_the_axis():
    ax = plot_eigenvalues(EIGENVALUES, UNITS)
    growing = next(line for line in ax.lines if line.get_label() == "growing")
    assert growing.get_xdata().size == 2


def test_before_and_after(motion):
    ax = plot_before_after(motion, motion, "x", UNITS)
    assert len(ax.lines) == 2


def drawings(motion, sweep, friction):
    return {
        "time": lambda ax: plot_time_history(motion, ["x"], UNITS, ax=ax),
        "phase": lambda ax: plot_phase_portrait(motion, "x", "u", ["belt"], UNITS, ax=ax),
        "friction": lambda ax: plot_friction(friction, ax=ax),
        "amplitudes": lambda ax: drawn(sweep, ax),
        "eigenvalues": lambda ax: plot_eigenvalues(EIGENVALUES, UNITS, ax=ax),
        "before": lambda ax: plot_before_after(motion, motion, "x", UNITS, ax=ax),
    }


@pytest.mark.one_in(4)
@pytest.mark.parametrize("plot", ["time", "phase", "friction", "amplitudes", "eigenvalues", "before"])
def test_every_picture_takes_an_ax_and_becomes_a_valid_svg(plot, motion, sweep, friction):
    draw, given = drawings(motion, sweep, friction)[plot], new_axes()
    assert draw(given) is given
    uri = to_svg(given)
    svg = base64.b64decode(uri.removeprefix("data:image/svg+xml;base64,")).decode()
    assert xml.dom.minidom.parseString(svg).documentElement.tagName == "svg"
    assert to_svg(draw(None)) == uri, "the same picture must give the same file"


def test_no_text_overlaps_another(motion, sweep, friction):
    axes = [
        plot_time_history(motion, ["x"], UNITS),
        plot_phase_portrait(motion, "x", "u", ["belt"], UNITS, drive=0.2),
        plot_friction(friction, "m/s"),
        drawn(sweep),
    ]
    for ax in axes:
        to_svg(ax)
        legend, title = ax.get_legend().get_window_extent(), ax.get_xaxis().label.get_window_extent()
        assert not legend.overlaps(title)
        assert ax.figure.bbox.x0 <= legend.x0
        assert legend.x1 <= ax.figure.bbox.x1
        assert legend.y1 <= ax.figure.bbox.y1


def test_drawing_leaves_no_global_state(motion):
    pyplot = sys.modules.get("matplotlib.pyplot")
    before = pyplot.get_fignums() if pyplot else []
    to_svg(plot_time_history(motion, ["x"], UNITS))
    if "matplotlib.pyplot" in sys.modules:
        assert sys.modules["matplotlib.pyplot"].get_fignums() == before
