"""Animations of runs and orbits: what their frames show, the files, and refusals; pictures that fit their figure."""

import shutil

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.layout_engine import ConstrainedLayoutEngine
from PIL import Image

import symfric as sf

BELT = sf.scenes.mass_on_belt(v_b=0.2, horizon=40.0)


def frames_of(path):
    with Image.open(path) as image:
        return image.n_frames, image.info["duration"], image.size


def test_a_run_is_saved_as_a_gif(tmp_path):
    run = sf.simulate(BELT)
    run.animate(tmp_path / "belt.gif", begin=20.0, end=34.0, seconds=1.0, frames_per_second=10)
    assert frames_of(tmp_path / "belt.gif") == (10, 100, (800, 360))


def test_frames_show_the_motion(tmp_path):
    run = sf.simulate(BELT)
    animation = run.animate(tmp_path / "belt.gif", begin=10.0, end=30.0, seconds=1.0, frames_per_second=5)
    left, right = animation._fig.axes  # the last frame has been drawn
    line, dot = left.lines
    t, x = line.get_data()
    assert (t[0], t[-1]) == pytest.approx((10.0, 30.0))
    assert x == pytest.approx(run(t)[0], abs=1e-12)
    assert dot.get_xydata()[0] == pytest.approx([30.0, run(30.0)[0]])
    held = right.lines[2].get_ydata()
    assert np.nanmax(np.abs(held - 0.2)) < 1e-12  # sticking moves with the belt
    assert left.get_xlim() == (10.0, 30.0)
    assert right.get_xlabel() == "x"


def test_an_orbit_shows_its_periods(tmp_path):
    orbit = sf.limit_cycle(BELT)
    animation = orbit.animate(tmp_path / "orbit.gif", periods=3.0, seconds=1.0, frames_per_second=4)
    assert animation._fig.axes[0].get_xlim() == pytest.approx((0.0, 3.0 * orbit.period))
    assert frames_of(tmp_path / "orbit.gif")[0] == 4


def test_a_film_needs_ffmpeg(tmp_path, monkeypatch):
    run = sf.simulate(BELT)
    if shutil.which("ffmpeg"):
        run.animate(tmp_path / "belt.mp4", seconds=0.4, frames_per_second=5)
        assert (tmp_path / "belt.mp4").stat().st_size > 1000
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(sf.SceneError, match="films need the program ffmpeg"):
        run.animate(tmp_path / "other.mp4", seconds=0.4, frames_per_second=5)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"begin": 5.0, "end": 3.0}, "from t = 5 to 3 is outside the run, 0 to 40"),
        ({"end": 41.0}, "outside the run"),
        ({"begin": -1.0}, "outside the run"),
        ({"seconds": 0.0}, "both are positive"),
        ({"frames_per_second": 0}, "both are positive"),
        ({"seconds": 1e4}, "at most 5000"),
    ],
)
def test_wrong_parts_are_refused(given, said):
    with pytest.raises(sf.SceneError, match=said):
        sf.simulate(BELT).animate(**given)


def test_the_layout_of_a_film_is_computed_once(tmp_path, monkeypatch):
    execute, calls = ConstrainedLayoutEngine.execute, []
    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", lambda self, fig: (calls.append(fig), execute(self, fig)))
    sf.simulate(BELT).animate(tmp_path / "short.gif", seconds=0.8, frames_per_second=5)
    assert len(calls) <= 2  # where the figure is made, and before its four frames


def test_runs_without_a_motion_are_refused(tmp_path):
    with pytest.raises(sf.SceneError, match="no motion was kept"):
        sf.simulate(BELT.wanting({"end": sf.End()})).animate()
    with pytest.raises(sf.SceneError, match="it must be a positive number"):
        sf.limit_cycle(BELT).animate(periods=0.0)


def test_endings_are_known_before_the_work_is_done(tmp_path):
    with pytest.raises(sf.SceneError, match=r"saved as .gif, .mp4, .webm or .mov"):
        sf.simulate(BELT).animate(tmp_path / "belt.avi")
    assert plt.get_fignums() == []


def test_pictures_fit_their_figure():
    orbit = sf.limit_cycle(BELT)
    for ax in (sf.simulate(BELT).plot(), orbit.plot(), sf.average(BELT.where({"v_b": 0.42})).plot()):
        figure = ax.figure
        figure.canvas.draw()
        renderer, (width, height) = figure.canvas.get_renderer(), figure.canvas.get_width_height()
        box = figure.get_tightbbox(renderer).transformed(figure.dpi_scale_trans)
        assert box.x0 >= -1
        assert box.y0 >= -1
        assert box.x1 <= width + 1
        assert box.y1 <= height + 1


@pytest.mark.long(beside="test_frames_show_the_motion")
def test_every_frame_of_a_gif_is_what_the_figure_shows(tmp_path):
    """Frames are drawn in parts and share a palette: beside the figure drawn as a whole, up to shades."""
    run = sf.simulate(BELT)
    animation = run.animate(tmp_path / "belt.gif", begin=10.0, end=30.0, seconds=1.0, frames_per_second=5)
    with Image.open(tmp_path / "belt.gif") as image:
        for number in range(5):
            image.seek(number)
            shown = np.asarray(image.convert("RGB"), dtype=int)
            animation._func(number)
            canvas = FigureCanvasAgg(animation._fig)
            canvas.draw()
            whole = np.asarray(canvas.buffer_rgba(), dtype=int)[..., :3]
            apart = np.max(np.abs(shown - whole), axis=2)
            assert tuple(shown[5, 5]) == (255, 255, 255)
            assert np.mean(apart > 48) < 1e-3
            assert np.mean(np.any(whole != 255, axis=2)) > 0.01
