"""The explorer's page: sliders beside live pictures, served by Bokeh to this machine only."""

import time
from collections.abc import Callable

import numpy as np

from symfric.report.explore import Explorer
from symfric.report.figures import BLUE, GREEN, ORANGE

AT_ONCE = 0.015  # s for points of the amplitude diagram in an answer; the others follow in lots of as long
STEPS = 200
WAIT = 20  # ms between two lots of points


def page(explorer: Explorer) -> Callable:
    """Return a function that fills a Bokeh document."""

    def fill(doc) -> None:
        from bokeh.layouts import column, row
        from bokeh.models import Div

        sources, plots = _plots(explorer)
        sliders = _sliders(explorer)
        note = Div(text="", name="note")
        doc.title = explorer.file.title or "symfric explore"
        doc.add_root(
            column(
                Div(text=f"<h2>{doc.title}</h2>"),
                row(
                    column(*sliders.values(), note, width=320),
                    column(*plots, sizing_mode="stretch_width", min_width=320),
                    sizing_mode="stretch_width",
                    styles={"flex-wrap": "wrap"},  # below one another on a phone
                ),
                sizing_mode="stretch_width",
            )
        )
        answer = _answering(doc, explorer, sources, sliders, note)
        for slider in sliders.values():
            slider.on_change("value", lambda _attribute, _old, _new: answer())
        answer()

    return fill


def _sliders(explorer: Explorer) -> dict:
    from bokeh.models import Slider

    return {
        r.name: Slider(
            start=r.low,
            end=r.high,
            value=r.value,
            step=(r.high - r.low) / STEPS,
            title=f"{r.name} [{r.unit}]" if r.unit else r.name,
            format="0[.]0000a",
            name=r.name,
            width=300,
        )
        for r in explorer.ranges
    }


def _plots(explorer: Explorer) -> tuple[dict, list]:
    """Return the sources of the pictures by name, and the pictures."""
    from bokeh.models import ColumnDataSource
    from bokeh.plotting import figure

    system, units = explorer.file.scene.system, explorer.file.units
    words = lambda name: f"{name} [{units[name]}]" if units.get(name) else name  # noqa: E731
    look = {"height": 260, "sizing_mode": "stretch_width", "toolbar_location": None}
    sources = {
        name: ColumnDataSource({"x": [], "y": []}, name=name)
        for name in ("phase", "law", "effective", "amplitude", "now")
    }
    phase = figure(
        name="phase portrait",
        title="phase portrait",
        x_axis_label=words(system.q[0].name),
        y_axis_label=words(system.u[0].name),
        **look,
    )
    phase.line("x", "y", source=sources["phase"], color=BLUE)
    friction = figure(title="friction", x_axis_label="sliding speed", y_axis_label="coefficient", **look)
    friction.line("x", "y", source=sources["law"], color=BLUE, legend_label="law")
    friction.line("x", "y", source=sources["effective"], color=ORANGE, legend_label="under the fast excitation")
    friction.legend.location = "bottom_right"
    plots = [phase, *([friction] if explorer.file.scene.contacts else ())]
    if explorer.swept:
        label = f"half range of {words(system.q[0].name)}"
        amplitude = figure(title="amplitude", x_axis_label=words(explorer.swept), y_axis_label=label, **look)
        amplitude.line("x", "y", source=sources["amplitude"], color=GREEN)
        amplitude.scatter("x", "y", source=sources["amplitude"], color=GREEN, size=4)
        amplitude.vspan(x="x", source=sources["now"], color=ORANGE, line_dash="dashed")
        plots.append(amplitude)
    return sources, plots


def _answering(doc, explorer: Explorer, sources: dict, sliders: dict, note) -> Callable[[], None]:
    """Return what answers a change: motion and friction at once, points of the diagram as time allows."""
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
    """Put points in order of their place."""
    x, y = (np.array(part, dtype=float) for part in (zip(*points, strict=True) if points else ((), ())))
    if not anew:
        x, y = np.concatenate([source.data["x"], x]), np.concatenate([source.data["y"], y])
    order = np.argsort(x)
    source.data = {"x": x[order], "y": y[order]}


def serve(explorer: Explorer, port: int, ready: Callable[[str], None]) -> None:
    """Serve the page on this machine's loopback until interrupted.

    Parameters
    ----------
    port : int
        0 for any that is free.
    ready : callable ``(address) -> None``
        Called once the page can be opened.
    """
    from bokeh.server.server import Server

    server = Server({"/": page(explorer)}, address="127.0.0.1", port=port)
    server.start()
    ready(f"http://localhost:{server.port}/")  # the one origin that the server lets connect
    try:
        server.io_loop.start()
    finally:
        server.stop()
