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
from symfric.report.study.drawing.axes import BLUE, GREEN, GREY, ORANGE
from symfric.templates import template

AT_ONCE = 0.015  # time per batch of points of the amplitude diagram, s
Named = dict[str, Any]  # widgets, figures and sources of Bokeh by name
WAIT = 20  # time between two batches, ms
KEPT = "before "  # begins the names of the sources of what is kept for comparison
NAMED = {"held", "stuck", "law", "effective"}  # what the legend names
VISIBLE = 1e-3  # least height of a figure, in largest motions: errors are not blown up to fill it


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
        made.compare.on_change("active", lambda _attribute, _old, on: _keep(figures, on))
        connect(made, explorer, answer, lambda words: note.update(text=words))
        answer()

    return fill


def _panel(explorer: Explorer, made: Controls) -> list[Any]:
    """Return the controls in their order on the page."""
    from bokeh.layouts import row

    parts: list[Any] = [row(made.reset, made.save, made.compare)]
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
    """Return an empty figure with a toolbar, one of whose tools saves the picture."""
    from bokeh.plotting import figure

    shown = figure(
        title=title,
        name=title,
        height=280,
        sizing_mode="stretch_width",
        tools="pan,box_zoom,wheel_zoom,reset,save",
        active_drag=None,  # a finger scrolls the page
        toolbar_location="right",
    )
    shown.toolbar.logo = None
    return shown


def _lines(shown: Any, *of: tuple[str, str, float, str]) -> None:
    """Draw lines, each of a new source of data and over one that is kept for comparison.

    A legend above the drawing names those that are there.
    """
    from bokeh.models import ColumnDataSource, PlainText
    from bokeh.models.annotations import Legend, LegendItem

    entries = []
    kept = [(f"{KEPT}{name}", GREY, width, words and f"{words}, before") for name, _, width, words in of]
    for name, colour, width, words in (*kept, *of):
        source = ColumnDataSource({"x": [], "y": []}, name=name)
        line = shown.line("x", "y", source=source, color=colour, line_width=width)
        entries.append(LegendItem(label=words or "before", renderers=[line], visible=False, name=f"legend of {name}"))
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
    _lines(phase, ("phase", BLUE, 1.3, ""), ("held", ORANGE, 3.5, sticks))
    _lines(history, ("history", BLUE, 1.3, ""), ("stuck", ORANGE, 3.5, sticks))
    figures = {"phase": phase, "motion": history}
    if explorer.rubbing:
        figures["friction"] = _figure("friction")
        _lines(figures["friction"], ("law", BLUE, 1.3, "law"), ("effective", ORANGE, 1.5, "under the fast excitation"))
    if explorer.swept:
        figures["amplitude"] = shown = _figure("amplitude")
        _lines(shown, ("amplitude", GREEN, 1.3, ""))
        shown.scatter("x", "y", source=_sources(figures)["amplitude"], color=GREEN, size=4)
        now = ColumnDataSource({"x": [], "y": []}, name="now")
        shown.vspan(x="x", source=now, color=ORANGE, line_dash="dashed")
    return figures


def _put(figures: Named, sources: Named, name: str, x: Any, y: Any) -> None:
    """Show a line, and its name in the legend if there is something to see of it."""
    sources[name].data = {"x": x, "y": y}
    for shown in figures.values():
        for entry in shown.legend.items:
            if entry.name == f"legend of {name}":
                there = bool(np.any(np.isfinite(np.asarray(y, dtype=float))))
                entry.visible = there and (name in NAMED or name.startswith(KEPT))


def _keep(figures: Named, on: bool) -> None:
    """Keep the curves that are shown in grey, or remove those that are kept."""
    sources = _sources(figures)
    for name in [n for n in sources if f"{KEPT}{n}" in sources]:
        data = sources[name].data
        x, y = (np.array(data[k]) if on else np.zeros(0) for k in ("x", "y"))
        _put(figures, sources, f"{KEPT}{name}", x, y)


def _sources(figures: Named) -> Named:
    """Return the sources of data of the figures by name."""
    return {r.data_source.name: r.data_source for shown in figures.values() for r in shown.renderers}


def _label(figures: Named, explorer: Explorer, coordinate: int, contact: int) -> None:
    """Write the names and units of what is shown on the axes, as plain text, and set the least heights."""
    from bokeh.models import PlainText

    system, units = explorer.file.scene.system, explorer.file.units
    q, u = (_in_unit(s[coordinate].name, units.get(s[coordinate].name)) for s in (system.q, system.u))
    labels = {"phase": (q, u), "motion": (_in_unit("t", units.get("t")), q)}
    if "friction" in figures:
        speed = units.of(explorer.rubbing[contact].slip)
        labels["friction"] = (_in_unit("sliding speed", speed), "coefficient")
    if "amplitude" in figures:
        labels["amplitude"] = (_in_unit(explorer.swept, units.get(explorer.swept)), f"half range of {q}")
    least = VISIBLE * explorer.reach
    n = len(system.q)
    figures["phase"].x_range.min_interval = least[coordinate] or None
    figures["phase"].y_range.min_interval = least[n + coordinate] or None
    for name in {"motion", "amplitude"} & set(figures):
        figures[name].y_range.min_interval = least[coordinate] or None
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
            with doc.models.freeze():  # each new label is a model, for which Bokeh would look through the page again
                _label(figures, explorer, coordinate, contact)
        view = explorer.view(values, initial, coordinate, contact)
        # a stick ends at the first moment of sliding
        held = view.held | np.roll(view.held, 1) if view.held.size else view.held
        for name, x, y, held_name in (("phase", view.x, view.u, "held"), ("history", view.t, view.x, "stuck")):
            _put(figures, sources, name, x, y)
            _put(figures, sources, held_name, x, np.where(held, y, np.nan))
        if "law" in sources:
            _put(figures, sources, "law", view.speed, view.friction)
            _put(figures, sources, "effective", view.speed, view.effective)
        if explorer.swept:
            sources["now"].data = {"x": [values[explorer.swept]], "y": [0.0]}
            lots = explorer.amplitudes(values, AT_ONCE, initial, coordinate)
            _show(sources["amplitude"], next(lots), anew=True)
            doc.add_timeout_callback(lambda change=state["change"]: more(lots, change), WAIT)
        spent = 1000 * (time.perf_counter() - begin)
        note.text = (f"{view.status}; " if view.status else "") + f"answered in {spent:.0f} ms"

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
