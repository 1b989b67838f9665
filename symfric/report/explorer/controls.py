"""The controls of the explorer's page: a slider and a number for each value and each start, choices, buttons."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from symfric.report.explorer.views import Explorer, SliderRange

# what a browser does with the text of a saved file, once the server has sent it
DOWNLOAD = """
const text = cb_obj.data.text[0];
if (text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], {type: "application/toml"}));
  link.download = cb_obj.data.file[0];
  link.click();
  URL.revokeObjectURL(link.href);
}
"""


Widgets = dict[str, tuple[Any, Any]]  # slider and number, by name


@dataclass(frozen=True, eq=False)
class Controls:
    """The widgets of the page.

    Attributes
    ----------
    values, starts : dict of str to (Slider, NumericInput)
    coordinate, contact : Select or None
        None where there is one only.
    reset, save : Button
    compare : Toggle
        While it is on, the curves that were shown when it was switched on stay beside the new ones.
    saved : ColumnDataSource
        What the browser saves: a file's text and name.
    """

    values: Widgets
    starts: Widgets
    coordinate: Any
    contact: Any
    reset: Any
    save: Any
    compare: Any
    saved: Any

    def numbers(self) -> tuple[dict[str, float], dict[str, float]]:
        """Return the values and the starts."""
        values, starts = ({n: float(field.value) for n, (_, field) in of.items()} for of in (self.values, self.starts))
        return values, starts

    def chosen(self) -> tuple[int, int]:
        """Return the numbers of the coordinate and of the contact."""
        coordinate, contact = (0 if s is None else s.options.index(s.value) for s in (self.coordinate, self.contact))
        return coordinate, contact


def controls(explorer: Explorer) -> Controls:
    """Return the widgets, with the values of the file."""
    from bokeh.models import ColumnDataSource, CustomJS
    from bokeh.models.widgets import Button, Toggle

    saved = ColumnDataSource({"text": [""], "file": [""]})
    saved.js_on_change("data", CustomJS(code=DOWNLOAD))
    scene = explorer.file.scene
    return Controls(
        {r.name: _number(r) for r in explorer.ranges},
        {r.name: _number(r, "start of ") for r in explorer.starts},
        _choice([q.name for q in scene.system.q], "coordinate"),
        _choice([c.name for c in scene.contacts if not c.frictionless], "contact"),
        Button(label="Reset", name="reset", width=70),
        Button(label="Save as TOML", name="save", width=110, disabled=explorer.tables is None),
        Toggle(label="Compare", name="compare", width=90),
        saved,
    )


def _number(r: SliderRange, before: str = "") -> tuple[Any, Any]:
    """Return a slider and the field of its number."""
    from bokeh.models.widgets import NumericInput, Slider

    name = before + r.name
    slider = Slider(
        start=r.low,
        end=r.high,
        value=r.value,
        step=r.step,
        title="",
        show_value=False,
        name=name,
        width=175,
        margin=(5, 5, 5, 10),  # the knob at the lower end needs room
        align="center",
    )
    return slider, NumericInput(value=r.value, mode="float", name=f"number of {name}", width=100)


def _choice(names: list[str], what: str) -> Any:
    """Return a menu of names, None for one or none; equal names are told apart by their number."""
    from bokeh.models.widgets import Select

    if len(names) < 2:
        return None
    return Select(value=names[0], options=list[Any](names), name=what, width=180)


def connect(made: Controls, explorer: Explorer, answer: Callable[[], None], tell: Callable[[str], None]) -> None:
    """Connect the widgets: sliders with their numbers, and every change with a new answer."""
    state = {"quiet": False}
    pairs = [(r, made.values[r.name]) for r in explorer.ranges] + [(r, made.starts[r.name]) for r in explorer.starts]

    def quietly(change: Callable[[], None]) -> None:
        before, state["quiet"] = state["quiet"], True
        try:
            change()
        finally:
            state["quiet"] = before
        if not before:
            answer()

    def moved(entry: Any, value: float) -> None:
        if not state["quiet"]:
            quietly(lambda: entry.update(value=value))

    def typed(slider: Any, entry: Any, r: SliderRange, value: float | None) -> None:
        if value is None:
            entry.update(value=r.value)
        elif not state["quiet"]:
            low, high = min(slider.start, value), max(slider.end, value)
            quietly(lambda: slider.update(start=low, end=high, value=value))

    def restored() -> None:
        for r, (slider, entry) in pairs:
            slider.update(start=r.low, end=r.high, value=r.value)
            entry.update(value=r.value)

    def save() -> None:
        from symfric.errors import SceneError

        try:
            text = explorer.toml(*made.numbers())
        except SceneError as error:
            tell(f"not saved: {error}")
            return
        name = explorer.file.path.rpartition("/")[2].removesuffix(".toml")
        # an empty line makes every saving a change, also of the same text
        again = "\n" if made.saved.data["text"][0] == text else ""
        made.saved.data = {"text": [text + again], "file": [f"{name}_explored.toml"]}

    for r, (slider, entry) in pairs:
        slider.on_change("value", lambda _a, _o, new, entry=entry: moved(entry, new))
        entry.on_change("value", lambda _a, _o, new, s=slider, e=entry, r=r: typed(s, e, r, new))
    for menu in (made.coordinate, made.contact):
        if menu is not None:
            menu.on_change("value", lambda _attribute, _old, _new: answer())
    made.reset.on_click(lambda: quietly(restored))
    made.save.on_click(save)
