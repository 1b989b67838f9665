"""The explorer's page: controls and live figures.

BokehJS interprets some texts as HTML, and any text with TeX in it; texts of a scene file are therefore passed as plain
text.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from symfric.report.explorer.controls import Controls, connect, controls
from symfric.report.explorer.views import Explorer, SliderRange
from symfric.report.study.drawing.axes import BLUE, GREEN, ORANGE
from symfric.templates import template

AT_ONCE = 0.015  # time per batch of points of the amplitude diagram, s
Named = dict[str, Any]  # widgets, figures and sources of Bokeh by name
WAIT = 20  # time between two batches, ms


def page(explorer: Explorer) -> Callable[[Any], None]:
    """Return a function that fills a Bokeh document."""

    def fill(doc: Any) -> None:
        from bokeh.layouts import column, row

        figures = _figures(explorer)
        made, note = controls(explorer), _text("", name="note")
        doc.title = explorer.file.title or "symfric explore"
        doc.template = template("explore.html")
        doc.template_variables["heading"] = doc.title
        doc.add_root(
            row(
                column(*_panel(explorer, made), note, width=320),
                column(*figures.values(), sizing_mode="stretch_width", min_width=320),
                sizing_mode="stretch_width",
                styles={"flex-wrap": "wrap"},  # stacked on narrow screens
            )
        )
        answer = _answering(doc, explorer, figures, made, note)
        connect(made, explorer, answer, lambda words: note.update(text=words))
        answer()

    return fill


def _panel(explorer: Explorer, made: Controls) -> list[Any]:
    """Return the controls in their order on the page."""
    from bokeh.layouts import row

    parts: list[Any] = [row(made.reset, made.save)]
    for menu, words in ((made.coordinate, "coordinate"), (made.contact, "contact")):
        if menu is not None:
            parts += [_text(words), menu]
    for ranges, of, words in ((explorer.ranges, made.values, ""), (explorer.starts, made.starts, "start of ")):
        for r in ranges:
            parts += [_text(words + _with_unit(r)), row(*of[r.name])]
    return parts


def _with_unit(r: SliderRange) -> str:
    return _in_unit(r.name, r.unit)


def _in_unit(name: str, unit: str | None) -> str:
    return f"{name} [{unit}]" if unit else name


def _text(text: str, **options: Any) -> Any:
    """Return a line of plain text."""
    from bokeh.models.widgets import Div

    style: dict[str, str | None] = {"overflow-wrap": "anywhere"}
    return Div(
        text=text, render_as_text=True, disable_math=True, width=300, margin=(5, 5, 0, 5), styles=style, **options
    )


def _figure(title: str) -> Any:
    """Return an empty figure."""
    from bokeh.plotting import figure

    return figure(title=title, name=title, height=260, sizing_mode="stretch_width", toolbar_location=None)


def _lines(shown: Any, *of: tuple[str, str, float, str]) -> None:
    """Draw lines, each of a new source of data; a legend beside the drawing names them."""
    from bokeh.models import ColumnDataSource, PlainText
    from bokeh.models.annotations import Legend, LegendItem

    entries = []
    for name, colour, width, words in of:
        source = ColumnDataSource({"x": [], "y": []}, name=name)
        line = shown.line("x", "y", source=source, color=colour, line_width=width)
        if words:
            entries.append(LegendItem(label=words, renderers=[line]))
    if entries:
        legend = Legend(items=entries, orientation="horizontal", border_line_color=None, margin=0)
        legend.update(padding=0)
        shown.add_layout(legend, "above")
    for axis in (shown.xaxis, shown.yaxis):
        axis.axis_label = PlainText(text="")


def _figures(explorer: Explorer) -> Named:
    """Return the figures by name."""
    from bokeh.models import ColumnDataSource

    phase, history = _figure("phase portrait"), _figure("motion")
    sticks = "sticking" if explorer.rubbing else ""
    _lines(phase, ("phase", BLUE, 1, ""), ("held", ORANGE, 3.5, sticks))
    _lines(history, ("history", BLUE, 1, ""), ("stuck", ORANGE, 3.5, sticks))
    figures = {"phase": phase, "motion": history}
    if explorer.rubbing:
        figures["friction"] = _figure("friction")
        _lines(figures["friction"], ("law", BLUE, 1, "law"), ("effective", ORANGE, 1.5, "under the fast excitation"))
    if explorer.swept:
        figures["amplitude"] = shown = _figure("amplitude")
        _lines(shown, ("amplitude", GREEN, 1, ""))
        shown.scatter("x", "y", source=shown.renderers[0].data_source, color=GREEN, size=4)
        now = ColumnDataSource({"x": [], "y": []}, name="now")
        shown.vspan(x="x", source=now, color=ORANGE, line_dash="dashed")
    return figures


def _sources(figures: Named) -> Named:
    """Return the sources of data of the figures by name."""
    return {r.data_source.name: r.data_source for shown in figures.values() for r in shown.renderers}


def _label(figures: Named, explorer: Explorer, coordinate: int, contact: int) -> None:
    """Write the names and units of what is shown on the axes, as plain text."""
    from bokeh.models import PlainText

    system, units = explorer.file.scene.system, explorer.file.units
    q, u = (_in_unit(s[coordinate].name, units.get(s[coordinate].name)) for s in (system.q, system.u))
    labels = {"phase": (q, u), "motion": (_in_unit("t", units.get("t")), q)}
    if "friction" in figures:
        speed = units.of(explorer.rubbing[contact].slip)
        labels["friction"] = (_in_unit("sliding speed", speed), "coefficient")
    if "amplitude" in figures:
        labels["amplitude"] = (_in_unit(explorer.swept, units.get(explorer.swept)), f"half range of {q}")
    for name, texts in labels.items():
        for axis, text in zip((figures[name].xaxis, figures[name].yaxis), texts, strict=True):
            axis.axis_label = PlainText(text=text)


def _answering(doc: Any, explorer: Explorer, figures: Named, made: Controls, note: Any) -> Callable[[], None]:
    """Return the callback of a change: updates motion and friction at once, and the amplitude diagram in batches."""
    state: dict[str, Any] = {"change": 0, "shown": None}
    sources = _sources(figures)

    def answer() -> None:
        begin = time.perf_counter()
        state["change"] += 1
        values, initial = made.numbers()
        coordinate, contact = made.chosen()
        if state["shown"] != (coordinate, contact):
            state["shown"] = coordinate, contact
            _label(figures, explorer, coordinate, contact)
        view = explorer.view(values, initial, coordinate, contact)
        # a stick ends at the first moment of sliding
        held = view.held | np.roll(view.held, 1) if view.held.size else view.held
        for name, x, y, held_name in (("phase", view.x, view.u, "held"), ("history", view.t, view.x, "stuck")):
            sources[name].data = {"x": x, "y": y}
            sources[held_name].data = {"x": x, "y": np.where(held, y, np.nan)}
        if "law" in sources:
            sources["law"].data = {"x": view.speed, "y": view.friction}
            sources["effective"].data = {"x": view.speed, "y": view.effective}
        if explorer.swept:
            sources["now"].data = {"x": [values[explorer.swept]], "y": [0.0]}
            lots = explorer.amplitudes(values, AT_ONCE, initial, coordinate)
            _show(sources["amplitude"], next(lots), anew=True)
            doc.add_timeout_callback(lambda change=state["change"]: more(lots, change), WAIT)
        spent = 1000 * (time.perf_counter() - begin)
        note.text = f"answered in {spent:.0f} ms" + (f"; {view.status}" if view.status else "")

    def more(lots: Iterator[list[tuple[float, float]]], change: int) -> None:
        points = next(lots, None)
        if points is not None and change == state["change"]:
            _show(sources["amplitude"], points, anew=False)
            doc.add_timeout_callback(lambda: more(lots, change), WAIT)

    return answer


def _show(source: Any, points: list[tuple[float, float]], anew: bool) -> None:
    """Show points in increasing order of the abscissa."""
    x, y = (np.array(part, dtype=float) for part in (zip(*points, strict=True) if points else ((), ())))
    if not anew:
        x, y = np.concatenate([source.data["x"], x]), np.concatenate([source.data["y"], y])
    order = np.argsort(x)
    source.data = {"x": x[order], "y": y[order]}
