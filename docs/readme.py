"""The picture of the README: ``python -m docs.readme`` draws it anew."""

from pathlib import Path

import matplotlib
import numpy as np

import symfric as sf

PICTURE = Path(__file__).parents[1] / "examples" / "amplitude.png"


def main() -> None:
    """Draw how far the mass on a belt swings against the speed of the belt: predicted in closed form, and computed."""
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    belt = sf.scenes.mass_on_belt(v_b=0.2)
    onset, stick = sf.theory.belt.onset_speed(belt), sf.theory.belt.stick_speed(belt)
    speeds = np.concatenate([np.linspace(0.005, stick, 60), onset - np.geomspace(onset - stick, 1e-5, 40)])
    predicted = [_predicted(belt.where({"v_b": v}), v < stick) for v in speeds]
    computed = np.linspace(0.02, 0.5, 25)
    x = belt.system.q[0]
    swings = belt.until(1000.0).wanting({"size": sf.HalfRange(x, after=900.0)})
    fig, ax = plt.subplots(figsize=(7.2, 3.8), layout="constrained")
    ax.axvspan(onset, 0.5, color="0.93")
    ax.plot([*speeds, onset, 0.5], [*predicted, 0.0, 0.0], label="predicted in closed form")
    ax.plot(computed, sf.sweep(swings, {"v_b": computed}).size, "o", fillstyle="none", label="computed motion")
    for place, words in ((0.2, "sticks and slips"), (0.5 * (stick + onset), "slips"), (0.5 * (onset + 0.5), "quiet")):
        ax.text(place, 0.01, words, ha="center", color="0.35", rotation=90 if words == "slips" else 0, va="bottom")
    ax.axvline(stick, color="0.6", linewidth=0.8)
    ax.set(xlabel="speed of the belt", ylabel="the mass swings by", xlim=(0.0, 0.5), ylim=(0.0, 0.45))
    ax.legend(frameon=False, loc="upper left")
    fig.savefig(PICTURE, dpi=100)


def _predicted(belt: sf.Scene, sticks: bool) -> float:
    if sticks:
        return sf.theory.belt.stick_slip_amplitude(belt, order=2)
    return sf.theory.belt.pure_slip_amplitude(belt)


if __name__ == "__main__":
    main()
