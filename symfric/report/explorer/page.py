"""The explorer's page: sliders and live figures.

BokehJS interprets some texts as HTML, and any text with TeX in it; texts of a scene file are therefore passed as plain
text.
"""

import time
from collections.abc import Callable

import numpy as np

from symfric.report.explorer.views import Explorer
from symfric.report.study.figures import BLUE, GREEN, ORANGE
from symfric.templates import template

AT_ONCE = 0.015  # time per batch of points of the amplitude diagram, s
STEPS = 200
WAIT = 20  # time between two batches, ms


def page(explorer: Explorer) -> Callable:
    """Return a function that fills a Bokeh document."""

    def fill(doc) -> None:
        from bokeh.layouts import column, row

        sources, plots = _plots(explorer)
        sliders = _sliders(explorer)
        note = _text("", name="note")
        doc.title = explorer.file.title or "symfric explore"
        doc.template = template("explore.html")
        doc.template_variables["heading"] = doc.title
        labelled = [part for r in explorer.ranges for part in (_text(_with_unit(r.name, r.unit)), sliders[r.name])]
        doc.add_root(
            row(
                column(*labelled, note, width=320),
                column(*plots, sizing_mode="stretch_width", min_width=320),
                sizing_mode="stretch_width",
                styles={"flex-wrap": "wrap"},  # stacked on narrow screens
            )
        )
        answer = _answering(doc, explorer, sources, sliders, note)
        for slider in sliders.values():
            slider.on_change("value", lambda _attribute, _old, _new: answer())
        answer()

    return fill


def _with_unit(name: str, unit: str | None) -> str:
    return f"{name} [{unit}]" if unit else name


def _text(text: str, **options):
    """Return a line of plain text."""
    from bokeh.models.widgets import Div

    style: dict[str, str | None] = {"overflow-wrap": "anywhere"}
    return Div(
        text=text, render_as_text=True, disable_math=True, width=300, margin=(5, 5, 0, 5), styles=style, **options
    )


def _sliders(explorer: Explorer) -> dict:
    from bokeh.models.widgets import Slider

    return {
        r.name: Slider(
            start=r.low,
            end=r.high,
            value=r.value,
            step=(r.high - r.low) / STEPS,
            title="",
            format="0[.]0000a",
            name=r.name,
            width=300,
        )
        for r in explorer.ranges
    }


def _figure(title: str, x: str, y: str):
    """Return an empty figure; its labels are plain text."""
    from bokeh.models import PlainText
    from bokeh.plotting import figure

    return figure(
        title=title,
        x_axis_label=PlainText(text=x),
        y_axis_label=PlainText(text=y),
        height=260,
        sizing_mode="stretch_width",
        toolbar_location=None,
    )


def _plots(explorer: Explorer) -> tuple[dict, list]:
    """Return the data sources of the figures by name, and the figures."""
    from bokeh.models import ColumnDataSource

    system, units = explorer.file.scene.system, explorer.file.units
    words = lambda name: _with_unit(name, units.get(name))  # noqa: E731
    sources = {
        name: ColumnDataSource({"x": [], "y": []}, name=name)
        for name in ("phase", "law", "effective", "amplitude", "now")
    }
    phase = _figure("phase portrait", words(system.q[0].name), words(system.u[0].name))
    phase.name = "phase portrait"
    phase.line("x", "y", source=sources["phase"], color=BLUE)
    friction = _figure("friction", "sliding speed", "coefficient")
    friction.line("x", "y", source=sources["law"], color=BLUE, legend_label="law")
    friction.line("x", "y", source=sources["effective"], color=ORANGE, legend_label="under the fast excitation")
    friction.legend.location = "bottom_right"
    plots = [phase, *([friction] if explorer.file.scene.contacts else ())]
    if explorer.swept:
        amplitude = _figure("amplitude", words(explorer.swept), f"half range of {words(system.q[0].name)}")
        amplitude.line("x", "y", source=sources["amplitude"], color=GREEN)
        amplitude.scatter("x", "y", source=sources["amplitude"], color=GREEN, size=4)
        amplitude.vspan(x="x", source=sources["now"], color=ORANGE, line_dash="dashed")
        plots.append(amplitude)
    return sources, plots


def _answering(doc, explorer: Explorer, sources: dict, sliders: dict, note) -> Callable[[], None]:
    """Return the callback of a slider: updates motion and friction at once, and the amplitude diagram in batches."""
    state = {"change": 0}

    def answer() -> None:
        begin = time.perf_counter()
        state["change"] += 1
        values = {name: float(s.value) for name, s in sliders.items()}
        view = explorer.view(values)
        sources["phase"].data = {"x": view.x, "y": view.u}
        sources["law"].data = {"x": view.speed, "y": view.friction}
        sources["effective"].data = {"x": view.speed, "y": view.effective}
        if explorer.swept:
            sources["now"].data = {"x": [values[explorer.swept]], "y": [0.0]}
            lots = explorer.amplitudes(values, AT_ONCE)
            _show(sources["amplitude"], next(lots), anew=True)
            doc.add_timeout_callback(lambda change=state["change"]: more(lots, change), WAIT)
        spent = 1000 * (time.perf_counter() - begin)
        note.text = f"answered in {spent:.0f} ms" + (f"; {view.status}" if view.status else "")

    def more(lots, change: int) -> None:
        points = next(lots, None)
        if points is not None and change == state["change"]:
            _show(sources["amplitude"], points, anew=False)
            doc.add_timeout_callback(lambda: more(lots, change), WAIT)

    return answer


def _show(source, points: list[tuple[float, float]], anew: bool) -> None:
    """Show points in increasing order of the abscissa."""
    x, y = (np.array(part, dtype=float) for part in (zip(*points, strict=True) if points else ((), ())))
    if not anew:
        x, y = np.concatenate([source.data["x"], x]), np.concatenate([source.data["y"], y])
    order = np.argsort(x)
    source.data = {"x": x[order], "y": y[order]}
