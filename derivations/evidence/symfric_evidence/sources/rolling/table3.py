"""Table 3 of the study of scaled rolling isolation: ranges of the returned ratios, as a table and a figure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from symfric.motions import Motion
from symfric.report.study.drawing.axes import COLOURS, tidy
from symfric_evidence.sources.rolling.study import rolling_study, synthetic_set

if TYPE_CHECKING:
    import xarray as xr

PRINTED = {  # ranges of the returned ratio in table 3: acceleration, velocity, displacement, residual
    (1e5, "case 2"): ((0.82, 1.03), (0.88, 1.07), (0.71, 1.22), (0.0, 15.0)),
    (1e5, "case 3"): ((0.71, 1.10), (0.62, 1.40), (0.49, 1.67), (0.0, 650.0)),
    (2e5, "case 2"): ((0.83, 1.18), (0.91, 1.07), (0.72, 1.42), (0.0, 11.0)),
    (2e5, "case 3"): ((0.72, 1.12), (0.72, 1.22), (0.54, 1.49), (0.0, 21.0)),
}
SHOWN = ("peak_acceleration", "peak_velocity", "peak_displacement", "residual")
WORDS = ("acceleration", "velocity", "displacement", "residual displacement")


class Ranges(TypedDict):
    """One row of the table: the smallest and the largest ratio, computed and printed."""

    damping: float
    friction: str
    response: str
    computed: list[float]
    printed: list[float]


@dataclass(frozen=True, eq=False)
class Table3:
    """Returned ratios of the models of table 1 with scaled gravity on uneven floors.

    Attributes
    ----------
    study : xarray.Dataset
        All cases.
    ranges : dict of (float, str) to ndarray, shape (4, 2)
        Smallest and largest ratio of acceleration, velocity, displacement and residual displacement, its magnitude,
        for each damping and case.
    """

    study: "xr.Dataset"
    ranges: dict[tuple[float, str], np.ndarray]

    def rows(self) -> list[Ranges]:
        """Return one row for each damping, case and response: computed and printed range."""
        return [
            {
                "damping": damping,
                "friction": case,
                "response": word,
                "computed": [float(v) for v in limits],
                "printed": list(printed),
            }
            for (damping, case), ranges in self.ranges.items()
            for word, limits, printed in zip(WORDS, ranges, PRINTED[damping, case], strict=True)
        ]

    def text(self) -> str:
        """Return the table as text."""
        lines = [f"{'C [kN s/m]':>10}  {'friction':8}  {'response':22}  {'computed':>16}  {'printed':>14}"]
        for row in self.rows():
            computed, printed = ("{:.2f}~{:.4g}".format(*limits) for limits in (row["computed"], row["printed"]))
            c = row["damping"] / 1e3
            lines.append(f"{c:10g}  {row['friction']:8}  {row['response']:22}  {computed:>16}  {printed:>14}")
        bad = int((self.study.status != 0).sum())
        lines.append(f"{self.study.status.size} cases, {bad} without an answer; motions scaled by the mean spectrum")
        lines.append("the source says neither what the cells of its floors are nor how they were drawn")
        return "\n".join(lines) + "\n"


def table_3(motions: Sequence[Motion] | None = None, progress: Callable[[int, int], None] | None = None) -> Table3:
    """Run the study; with artificial motions unless given."""
    study = rolling_study(synthetic_set() if motions is None else motions, progress=progress)
    scaled = study.sel(model=[m for m in study.model.values if m.startswith("table 1") and m.endswith("scaled g")])
    ranges = {}
    for damping, case in PRINTED:
        part = scaled.sel(damping=damping, friction=case)
        ratios = (np.abs(part[f"ratio_{name}"].values) for name in SHOWN)
        ranges[damping, case] = np.array([[np.nanmin(r), np.nanmax(r[np.isfinite(r)])] for r in ratios])
    return Table3(study, ranges)


def plot_table_3(table: Table3, axes: Any = None) -> Any:
    """Draw the returned acceleration ratio against the intensity: gravity scaled or not, floors even or not.

    Lines are medians over the motions; bands hold four fifths of them, for the largest and the smallest model.
    """
    from matplotlib.figure import Figure

    panels = {
        "table 1, gravity of the table: even floor": ("table 1", "g", "case 1"),
        "table 1, scaled gravity: floor of case 3": ("table 1", "scaled g", "case 3"),
        "table 2, gravity of the table: even floor": ("table 2", "g", "case 1"),
        "table 1, scaled gravity: R = 0.05 1/m": ("table 1", "scaled g", "R = 0.05 1/m"),
    }
    if axes is None:
        axes = Figure(figsize=(9.0, 7.0), layout="constrained").subplots(2, 2, squeeze=False)
    ratio = table.study["ratio_peak_acceleration"].sel(damping=1e5)
    for (title, (start, end, friction)), ax in zip(panels.items(), axes.flat, strict=True):
        names = [m for m in ratio.model.values if m.startswith(start) and m.endswith(f", {end}")]
        for name, colour in zip(names, COLOURS * 2, strict=False):
            part = ratio.sel(model=name, friction=friction)
            middle = part.median("motion")
            ax.plot(part.pga, middle, "o-", color=colour, markersize=3, label=name.split(", ")[1])
            if name in (names[0], names[-1]):
                low, high = part.quantile(0.1, "motion"), part.quantile(0.9, "motion")
                ax.fill_between(part.pga, low, high, color=colour, alpha=0.15, linewidth=0)
        ax.axhline(1.0, color="0.6", linewidth=0.8)
        ax.set(title=title, xlabel="peak ground acceleration [g]", ylabel="acceleration ratio RR", xscale="log")
        ax.set_xticks(list(part.pga.values), [f"{v:g}" for v in part.pga.values], minor=False)
        ax.minorticks_off()
        low, high = ax.get_ylim()
        ax.set_ylim(min(low, 0.95), max(high, 1.05))
        tidy(ax)
    axes.flat[0].figure.legend(
        *axes.flat[0].get_legend_handles_labels(), loc="outside upper center", ncols=6, frameon=False
    )
    return axes
