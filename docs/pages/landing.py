"""The animation of the landing page: stick-slip of a mass on a belt beside its phase portrait."""

from pathlib import Path

import matplotlib

from docs.kept import kept
from symfric import limit_cycle, scenes

_FRAMES, _SECONDS = 15, 4.0  # frames per second, and duration


def write(folder: Path) -> None:
    """Write the animation and the still picture that browsers show which are set to move little."""
    matplotlib.use("Agg")
    folder.mkdir(exist_ok=True)
    places = folder / "stick_slip.gif", folder / "stick_slip.png"
    made = folder / "stick_slip.json"
    if not all(p.is_file() for p in places):
        made.unlink(missing_ok=True)
    kept(made, Path(__file__).read_text(encoding="utf-8"), lambda: _made(*places))


def _made(film: Path, still: Path) -> dict[str, float]:
    import matplotlib.pyplot as plt
    from PIL import Image

    orbit = limit_cycle(scenes.mass_on_belt(v_b=0.2))
    with matplotlib.rc_context({"font.size": 15, "lines.linewidth": 2.5}):  # it is shown at less than half of its size
        orbit.animate(film, periods=2.0, seconds=_SECONDS, frames_per_second=_FRAMES)
    plt.close("all")
    with Image.open(film) as image:
        image.seek(image.n_frames - 1)
        image.convert("RGB").save(still)
    return {"period": orbit.period}
