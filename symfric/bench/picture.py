"""The work-precision picture and the table of a benchmark."""

import math
from collections.abc import Sequence

import numpy as np

from symfric.bench.growth import Growth
from symfric.bench.needs import Need
from symfric.bench.result import Benchmark

_MARKERS = "osD^vPX*<>"
_SMALLEST = 1e-16  # an error of zero is drawn here


def work_precision(benchmark: Benchmark, ax=None):
    """Draw CPU time against achieved error, one panel a problem and one curve a solver; return the Axes."""
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys(c.problem for c in benchmark.curves if c.points))
    solvers = list(dict.fromkeys(c.solver for c in benchmark.curves))
    if ax is None:
        _, ax = plt.subplots(1, max(1, len(names)), figsize=(4.2 * max(1, len(names)), 4), squeeze=False)
    panels, named = np.atleast_1d(ax).ravel(), set()
    for panel, name in zip(panels, names, strict=False):
        for curve in (c for c in benchmark.curves if c.problem == name and c.points):
            k = solvers.index(curve.solver)
            errors = [max(p.error, _SMALLEST) for p in curve.points]
            seconds = [p.seconds for p in curve.points]
            panel.loglog(
                errors,
                seconds,
                marker=_MARKERS[k % 10],
                color=f"C{k % 10}",
                label=None if curve.solver in named else curve.solver,
            )
            named.add(curve.solver)
        panel.invert_xaxis()
        panel.set(xlabel="error", ylabel="CPU time / s", title=name)
        panel.grid(True, which="major", alpha=0.3)
        if panel.get_legend_handles_labels()[1]:
            panel.legend(fontsize="small")  # every solver is named once, where it first appears
    return ax if np.ndim(ax) == 0 else (panels[0] if panels.size == 1 else ax)


def table(benchmark: Benchmark):
    """Return a rich Table: a row for each solver that answered on each problem."""
    from rich.table import Table

    result = Table(title="CPU time of one run, median of interleaved rounds")
    columns = ("problem", "solver", "ms to 1e-6", "ms to 1e-10", "best error", "events", "first run s")
    for name in columns:
        result.add_column(name, justify="left" if name in ("problem", "solver") else "right")
    last = None
    for curve in (c for c in benchmark.curves if c.points):
        if last not in (None, curve.problem):
            result.add_section()
        result.add_row(curve.problem, *_row(curve))
        last = curve.problem
    return result


def _row(curve) -> tuple[str, ...]:
    best = min(p.error for p in curve.points)
    found = "-"
    if curve.events is not None:
        wrong = sum(p.events != curve.events for p in curve.points)
        found = f"{curve.events}" if not wrong else f"{curve.events}, wrong in {wrong} of {len(curve.points)}"
    times = (_milliseconds(curve.time_to(error)) for error in (1e-6, 1e-10))
    return (curve.solver, *times, f"{best:.1e}", found, f"{curve.prepared:.3f}")


def _milliseconds(seconds: float) -> str:
    return "not reached" if math.isnan(seconds) else f"{1e3 * seconds:.3g}"


def needs_table(title: str, needs: Sequence[Need], unit: str, scale: float):
    """Return a rich Table of what is wanted, its time in `unit` (s times `scale`) and its memory."""
    from rich.table import Table

    result = Table("wanted", title=title)
    for name in (unit, "kB"):
        result.add_column(name, justify="right")
    for need in needs:
        result.add_row(need.wanted, f"{scale * need.seconds:.3g}", f"{need.kilobytes:.4g}")
    return result


def growth_table(growths: Sequence[Growth]):
    """Return a rich Table of times over sizes, with the slope of their logarithms."""
    from rich.table import Table

    result = Table(title="Growth of cost")
    for name in ("of", "sizes", "s for one", "times", "exponent"):
        result.add_column(name, justify="left" if name in ("of", "s for one") else "right")
    for g in growths:
        sizes, times = (", ".join(f"{v:.3g}" for v in row) for row in (g.sizes, g.seconds))
        result.add_row(g.name, sizes, g.unit, times, f"{g.exponent:.2f}")
    return result
