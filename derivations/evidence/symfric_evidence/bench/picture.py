"""Work-precision figure and tables of a benchmark."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric_evidence.bench.needs import Need
from symfric_evidence.bench.scaling import CostGrowth
from symfric_evidence.bench.where import KINDS

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table

    from symfric_evidence.bench.ensembles import CaseCost
    from symfric_evidence.bench.published import PublishedDifference
    from symfric_evidence.bench.result import Benchmark, ErrorCurve
    from symfric_evidence.bench.where import Share

_MARKERS, _COLORS = "osD^vPX*<>hp", [*(f"C{k}" for k in range(10)), "black", "gold"]
_SMALLEST = 1e-16  # smallest error drawn, also for zero


def work_precision(benchmark: "Benchmark", ax: Any = None) -> Any:
    """Draw CPU time against achieved error, one panel a problem and one curve a solver; return the Axes."""
    import matplotlib.pyplot as plt

    problems, solvers = _problems(benchmark), list(dict.fromkeys(c.solver for c in benchmark.curves))
    if ax is None:
        ax = _panels(plt.figure(figsize=_size(len(problems)), layout="constrained"), len(problems))
    panels = np.atleast_1d(ax).ravel()
    for panel, name in zip(panels, problems, strict=False):
        for curve in (c for c in benchmark.curves if c.problem == name and c.points):
            k = solvers.index(curve.solver)
            errors = [max(p.error, _SMALLEST) for p in curve.points]
            seconds = [p.seconds for p in curve.points]
            panel.loglog(errors, seconds, marker=_MARKERS[k % 12], color=_COLORS[k % 12], label=curve.solver)
        panel.invert_xaxis()
        panel.set(xlabel="error", ylabel="CPU time / s", title=f"{name}: {benchmark.titles[name]}")
        panel.title.set_fontsize("medium")
        panel.grid(True, which="major", alpha=0.3)
    named: dict[str, object] = {}
    for panel in panels:
        handles, labels = panel.get_legend_handles_labels()
        named = dict(zip(labels, handles, strict=True)) | named
    if panels.size == 1:
        panels[0].legend(fontsize="small")
    else:
        panels[0].figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=5, fontsize="small")
    return ax if np.ndim(ax) == 0 else (panels[0] if panels.size == 1 else ax)


def picture(benchmark: "Benchmark") -> "Figure":
    """Return the Figure of `work_precision`, three panels in a row."""
    from matplotlib.figure import Figure

    number = len(_problems(benchmark))
    figure = Figure(figsize=_size(number), layout="constrained")
    work_precision(benchmark, _panels(figure, number))
    return figure


def _problems(benchmark: "Benchmark") -> list[str]:
    return list(dict.fromkeys(c.problem for c in benchmark.curves if c.points))


def _size(number: int) -> tuple[float, float]:
    return 4.6 * min(number, 3), 3.8 * math.ceil(number / 3) + 0.6


def _panels(figure: Any, number: int) -> np.ndarray:
    """Return as many Axes, three in a row."""
    axes = figure.subplots(math.ceil(number / 3), min(number, 3), squeeze=False).ravel()
    for unused in axes[number:]:
        unused.remove()
    return np.asarray(axes[:number])


def _table(title: str, columns: Sequence[str], words: Sequence[str]) -> "Table":
    """Return an empty table; columns of words begin at the left, those of numbers end at the right."""
    from rich.table import Table

    result = Table(title=title)
    for name in columns:
        result.add_column(name, justify="left" if name in words else "right")
    return result


def table(benchmark: "Benchmark") -> "Table":
    """Return a rich Table: a row for each solver that answered on each problem."""
    columns = ("problem", "solver", "ms to 1e-6", "ms to 1e-10", "best error", "events", "first run s")
    result = _table("CPU time of one run, median of interleaved rounds", columns, ("problem", "solver"))
    last = None
    for curve in (c for c in benchmark.curves if c.points):
        if last not in (None, curve.problem):
            result.add_section()
        result.add_row(curve.problem, *_row(curve))
        last = curve.problem
    return result


def _row(curve: "ErrorCurve") -> tuple[str, ...]:
    best = min(p.error for p in curve.points)
    events = "-"
    if curve.events is not None:
        wrong = sum(p.events != curve.events for p in curve.points)
        events = f"{curve.events}" if not wrong else f"{curve.events}, wrong in {wrong} of {len(curve.points)}"
    times = (_milliseconds(curve.time_to(error), curve.stopped) for error in (1e-6, 1e-10))
    return (curve.solver, *times, f"{best:.1e}", events, f"{curve.prepared:.3f}")


def _milliseconds(seconds: float, stopped: bool) -> str:
    return f"{1e3 * seconds:.3g}" if not math.isnan(seconds) else "not tried" if stopped else "not reached"


def published_table(rows: Sequence["PublishedDifference"]) -> "Table":
    """Return a rich Table: the largest difference of every signal from its published numbers."""
    columns = ("model", "signal", "difference", "at t", "of")
    result = _table("Modelica's friction examples against their published results", columns, ("model", "signal"))
    for row in rows:
        result.add_row(row.model, row.signal, f"{row.difference:.1e}", f"{row.time:g}", f"{row.size:.3g}")
    return result


def needs_table(title: str, needs: Sequence[Need], unit: str, scale: float) -> "Table":
    """Return a rich Table of outputs with their time in `unit` (s times `scale`) and memory."""
    result = _table(title, ("wanted", unit, "kB"), ("wanted",))
    for need in needs:
        result.add_row(need.wanted, f"{scale * need.seconds:.3g}", f"{need.kilobytes:.4g}")
    return result


def costs_table(title: str, costs: Sequence[Need]) -> "Table":
    """Return a rich Table of CPU times in ms, and relative to the first."""
    result = _table(title, ("what", "ms", "relative"), ("what",))
    for cost in costs:
        result.add_row(cost.wanted, f"{1e3 * cost.seconds:.3g}", f"{cost.seconds / costs[0].seconds:.2f}")
    return result


def where_table(shares: "Sequence[Share]") -> "Table":
    """Return a rich Table of CPU seconds of long calls by the kind of work."""
    columns = ("call", "caches", "CPU s", *KINDS, "runs", "with derivatives")
    result = _table("Where the CPU time of long calls goes", columns, ("call", "caches"))
    for share in shares:
        seconds = (f"{share.total:.2f}", *(f"{share.seconds[kind]:.2f}" for kind in KINDS))
        result.add_row(share.call, share.state, *seconds, f"{share.runs}", f"{share.varied}")
    return result


def cases_table(costs: "Sequence[CaseCost]") -> "Table":
    """Return a rich Table of the time of a case, a column for each number of cases."""
    sizes = [f"{size}" for size in costs[0].sizes] if costs else []
    result = _table("One belt of P5 among many, us", ("cases together", *sizes), ("cases together",))
    for cost in costs:
        result.add_row(cost.name, *(f"{1e6 * s:.3g}" for s in cost.seconds))
    return result


def growth_table(growths: Sequence[CostGrowth]) -> "Table":
    """Return a rich Table of times over sizes, with the slope of their logarithms."""
    result = _table("Growth of cost", ("of", "sizes", "s for one", "times", "exponent"), ("of", "s for one"))
    for g in growths:
        sizes, times = (", ".join(f"{v:.3g}" for v in row) for row in (g.sizes, g.seconds))
        result.add_row(g.name, sizes, g.unit, times, f"{g.exponent:.2f}")
    return result
