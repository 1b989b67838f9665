"""Animations of motions: the coordinates in time beside the phase portrait, as they come about."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.errors import SceneError
from symfric.locks import DRAWING, alone
from symfric.model.symbols import finite
from symfric.solve.plotting import in_brackets, labelled, motion_to_draw

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.animation import FuncAnimation
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

    from symfric.solve.run import Run

_TRACE = 2000  # points of the lines
_MOST = 5000  # frames
_PLACES = np.array([256**2, 256, 1])  # of red, green and blue in one number
_ENDINGS = ".gif", ".mp4", ".webm", ".mov"


@alone(DRAWING)
def animate_run(
    run: "Run", path: str | PathLike[str] | None, begin: float, end: float, seconds: float, frames_per_second: int
) -> "FuncAnimation":
    """Return the animation of a motion from `begin` to `end`, written to `path`; see `Run.animate`."""
    import matplotlib.pyplot as plt
    from matplotlib.animation import FFMpegWriter, FuncAnimation

    if path is not None:
        _check_film(path)

    begin, end = finite(begin, "begin"), finite(end, "end")
    if not 0.0 <= begin < end <= run.t_final:
        raise SceneError(f"an animation from t = {begin:g} to {end:g} is outside the run, 0 to {run.t_final:g}")
    if not (np.isfinite(seconds) and seconds > 0 and frames_per_second > 0):
        raise SceneError(f"an animation of {seconds:g} s with {frames_per_second} frames per second; both are positive")
    frames = max(2, round(seconds * frames_per_second))
    if frames > _MOST:
        raise SceneError(f"an animation of {frames} frames; at most {_MOST}: fewer seconds or frames per second")
    within = run.t[(run.t > begin) & (run.t < end)]
    t, x, on = motion_to_draw(run, np.union1d(np.linspace(begin, end, _TRACE), within))
    units, n = run.base.units, len(run.base.system.q)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained", width_ratios=(1.35, 1.0))
    lines = [left.plot([], [], lw=1.2, label=q.name)[0] for q in run.base.system.q]
    dots = [left.plot([], [], "o", color=line.get_color(), ms=5)[0] for line in lines]
    right.plot(x[0], x[n], color="0.85", lw=0.8)
    (trace,) = right.plot([], [], color="C0", lw=1.2)
    (held,) = right.plot([], [], color="C1", lw=3.5, solid_capstyle="butt", label="a contact sticks")
    (point,) = right.plot([], [], "o", color="C3", ms=6)
    left.set_xlim(begin, end)
    left.set_ylim(*_with_margin(x[:n]))
    left.set_xlabel("time t" + in_brackets(units.get("t")))
    left.set_ylabel(labelled(run.names[0], units) if n == 1 else "coordinate")
    if n > 1:
        left.legend(loc="upper right", fontsize="small")
    if on.any():
        right.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    right.set_xlabel(labelled(run.names[0], units))
    right.set_ylabel(labelled(run.names[n], units))
    stuck = np.where(on, x[n], np.nan)
    last = np.searchsorted(t, np.linspace(begin, end, frames), side="right") - 1

    def show(frame: int) -> list[Any]:
        k = int(last[frame])
        for i, (line, dot) in enumerate(zip(lines, dots, strict=True)):
            line.set_data(t[: k + 1], x[i, : k + 1])
            dot.set_data([t[k]], [x[i, k]])
        trace.set_data(x[0, : k + 1], x[n, : k + 1])
        held.set_data(x[0, : k + 1], stuck[: k + 1])
        point.set_data([x[0, k]], [x[n, k]])
        return [*lines, *dots, trace, held, point]

    animation = FuncAnimation(figure, show, frames=frames, interval=1000.0 / frames_per_second, blit=False)
    if path is not None:
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # the same for every frame; else each of them computes it three times
        if Path(path).suffix.lower() == ".gif":
            _write_gif(figure, show, frames, Path(path), frames_per_second)
        else:
            animation.save(Path(path), writer=FFMpegWriter(frames_per_second))
        plt.close(figure)
    return animation


def _write_gif(
    figure: "Figure", show: "Callable[[int], list[Artist]]", frames: int, path: Path, frames_per_second: int
) -> None:
    """Write frames that differ only in some artists: the rest is drawn once, in the colours of the last frame.

    Matplotlib's own writer draws everything three times for each frame, and looks for a palette in each.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas = FigureCanvasAgg(figure)
    moving = show(frames - 1)
    for artist in moving:
        artist.set_visible(False)
    canvas.draw()
    still, shape = canvas.copy_from_bbox(figure.bbox), canvas.get_width_height()[::-1]
    for artist in moving:
        artist.set_visible(True)

    def codes(number: int) -> np.ndarray:
        canvas.restore_region(still)
        for artist in show(number):
            figure.draw_artist(artist)
        return np.asarray(canvas.buffer_rgba(), dtype=np.int64)[..., :3] @ _PLACES

    found, counts = np.unique(codes(frames - 1), return_counts=True)
    palette = found[np.argsort(-counts, kind="stable")[:256], None] // _PLACES % 256

    def frame(number: int) -> Image.Image:
        found, index = np.unique(codes(number), return_inverse=True)
        distance = np.sum((found[:, None, None] // _PLACES % 256 - palette) ** 2, axis=-1)
        image = Image.fromarray(np.argmin(distance, axis=1).astype(np.uint8)[index.reshape(shape)])
        image.putpalette(palette.astype(np.uint8).tobytes())
        return image

    drawn = map(frame, range(frames))
    length = round(1000.0 / frames_per_second)
    next(drawn).save(path, format="GIF", save_all=True, append_images=drawn, duration=length, loop=0)


def _check_film(path: str | PathLike[str]) -> None:
    """Raise unless an animation can be written to a file of this name."""
    from matplotlib.animation import FFMpegWriter

    kind = Path(path).suffix.lower()
    if kind not in _ENDINGS:
        raise SceneError(f"{path}: animations are saved as .gif, .mp4, .webm or .mov")
    if kind != ".gif" and not FFMpegWriter.isAvailable():
        raise SceneError(f"{path}: films need the program ffmpeg, which is not installed; save a .gif")


def _with_margin(rows: np.ndarray) -> tuple[float, float]:
    low, high = float(np.nanmin(rows)), float(np.nanmax(rows))
    room = 0.06 * (high - low) or 0.5
    return low - room, high + room
