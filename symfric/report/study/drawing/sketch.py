"""Sketch of a scene: bodies in a row with springs, dampers, contacts and loads; a graph if a row would be tangled."""

from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np

from symfric.model.scene import Scene
from symfric.report.html.elements import Picture
from symfric.report.study.drawing.axes import GREY, ORANGE, Axes, to_svg
from symfric.report.study.drawing.diagram import GROUND, Diagram, Link, Surface, diagram_of
from symfric.report.study.drawing.labels import POINTS, SCALE, WIDTH, Sheet, mathematics, width, write_key
from symfric.report.study.drawing.shapes import INK, arrow, block, damper, gap, ground, roller, slider, spring, wall

PALE = "0.65"
ROW, HIGHEST_ROUTES = 6, 2  # most bodies in a row, and most pairs that are linked past others
LANE, ROUTE = 0.62, 0.72  # heights of a link beside a body and above the row
Routes = list[tuple[int, int, list[Link]]]  # links above the row, by their bodies
DRAW = {"stiffness": spring, "damping": damper, "friction": slider, "gap": gap}


def plot_system(diagram: Diagram, ax: Axes | None = None) -> Axes:
    """Draw a system; return the Axes."""
    from matplotlib.figure import Figure

    own = Figure(figsize=(SCALE * WIDTH, 1.0))
    given, ax = ax, own.add_axes((0, 0, 1, 1)) if ax is None else ax
    sheet, order = Sheet(ax), _order(diagram)
    low, top = _row(sheet, diagram, order) if order else _graph(sheet, diagram)
    low = write_key(sheet, diagram, low)
    for text in ax.texts:
        text.set_fontsize(min(POINTS, text.get_fontsize()))
    ax.set_xlim(0, WIDTH)
    ax.set_ylim(low - 0.1, top + 0.1)
    ax.set_aspect("equal")
    ax.axis("off")
    if given is None:
        own.set_size_inches(SCALE * WIDTH, SCALE * (top - low + 0.2))
    return ax


def picture(scene: Scene) -> Picture | None:
    """Return the sketch of a scene with its caption; None if the scene is too large to be drawn."""
    diagram = diagram_of(scene)
    if diagram is None:
        return None
    caption = "The system: bodies with their masses, springs, dampers, contacts and loads, drawn from the equations."
    if any(c.in_plane for c in scene.contacts):
        caption += " A contact in the plane is drawn once for each of its two directions, 0 and 1."
    return Picture(to_svg(plot_system(diagram)), in_words(diagram), caption)


def in_words(diagram: Diagram) -> str:
    """Return what a sketch shows as a sentence for those who cannot see it."""
    names = [b.coordinate.name for b in diagram.bodies]
    parts = [f"bodies {', '.join(names)}" if len(names) > 1 else f"a body {names[0]}"]
    for x in diagram.links:
        to = "the ground" if x.second == GROUND else names[x.second]
        what = {"friction": f"contact {x.name}", "gap": f"gap of contact {x.name}"}.get(x.kind, x.kind)
        parts.append(f"{what} between {names[x.first]} and {to}")
    for s in diagram.surfaces:
        moving = "" if s.velocity.is_zero else f", which moves at {s.velocity}"
        parts.append(f"{names[s.body]} in contact with {s.name}{moving}")
    parts += [f"a force on {names[e.body]}" for e in diagram.loads]
    return "Sketch of the system: " + "; ".join(parts) + "."


def _order(diagram: Diagram) -> tuple[int, ...]:
    """Return the order of the bodies in a row; empty if they are drawn as a graph."""
    n = len(diagram.bodies)
    pairs = {(link.first, link.second) for link in diagram.links if link.second != GROUND}
    grounded = {link.first for link in diagram.links if link.second == GROUND}
    if n > ROW:
        return ()

    def cost(order: tuple[int, ...]) -> tuple[float, tuple[int, ...]]:
        at = {body: k for k, body in enumerate(order)}
        inner = sum(0 < at[i] < n - 1 for i in grounded) - 0.1 * (order[0] in grounded)
        return 4 * sum(abs(at[i] - at[j]) for i, j in pairs) + inner, order

    best = min(permutations(range(n)), key=cost)
    far = [p for p in pairs if abs(best.index(p[0]) - best.index(p[1])) > 1]
    return best if len(far) <= HIGHEST_ROUTES else ()


def _stacked(diagram: Diagram) -> tuple[int, int] | None:
    """Return the upper and the lower of two bodies that only rub on each other; None otherwise."""
    pairs = [link for link in diagram.links if link.second != GROUND]
    if len(diagram.bodies) != 2 or len(pairs) != 1 or pairs[0].kind != "friction":
        return None
    sliding = {s.body for s in diagram.surfaces}
    return next(((i, 1 - i) for i in (0, 1) if i not in sliding), None)


@dataclass(frozen=True)
class _Place:
    """Where a body is: its left and lower ends, width and height."""

    left: float
    low: float
    width: float
    height: float

    @property
    def right(self) -> float:
        return self.left + self.width

    @property
    def top(self) -> float:
        return self.low + self.height

    @property
    def middle(self) -> float:
        return self.left + 0.5 * self.width


def _row(sheet: Sheet, diagram: Diagram, order: tuple[int, ...]) -> tuple[float, float]:
    """Draw bodies in a row, or one upon the other; return the lower and the upper end of the drawing."""
    places = _on_each_other(diagram, _stacked(diagram)) if _stacked(diagram) else _side_by_side(diagram, order)
    stacked, sprung = bool(_stacked(diagram)), any(s.sprung for s in diagram.surfaces)
    floor = min(p.low for p in places.values()) - (0.42 if sprung else 0.0)
    routed = _draw_links(sheet, diagram, places, order)
    for i, body in enumerate(diagram.bodies):
        p = places[i]
        block(sheet.ax, p.left, p.low, p.width, p.height, sheet.label(body.mass, p.width - 0.1, "mass"))
        aside = stacked and p.low == min(q.low for q in places.values())
        _coordinate(sheet, diagram, i, p, aside, p.width if routed else _pitch(places, i) - 0.3)
    low = floor
    for i, p in places.items():
        own = [s for s in diagram.surfaces if s.body == i]
        room = _pitch(places, i)
        for k, surface in enumerate(own):
            part, edge = (min(room / len(own), 1.3), 0.2) if len(own) > 1 else (p.width, 0.0)
            if len(own) > 1:  # a foot on all of them
                half = 0.5 * len(own) * part - edge
                sheet.ax.plot([p.middle - half, p.middle + half], [p.low] * 2, color=INK, linewidth=2.4)
            left = p.middle + (k - 0.5 * len(own)) * part
            at = _Place(left + edge, p.low, part - 2 * edge, p.height)
            low = min(low, _surface(sheet, surface, at, floor, part - 0.1 if len(own) > 1 else room))
        if not own and p.low == min(q.low for q in places.values()):
            for x in (p.left + 0.25 * p.width, p.right - 0.25 * p.width):
                roller(sheet.ax, x, p.low - 0.09, 0.09)
            ground(sheet.ax, p.low - 0.18, p.left - 0.1, p.right + 0.1)
            low = min(low, p.low - 0.35)
    top = max(p.top for p in places.values()) + 0.6 + 0.65 * bool(diagram.loads)
    return low, _draw_routes(sheet, places, routed, top)


def _pitch(places: dict[int, _Place], i: int) -> float:
    """Return the room below a body, up to half of the way to its neighbours."""
    p = places[i]
    others = [abs(q.middle - p.middle) for j, q in places.items() if j != i and q.low == p.low]
    return min([2 * (min(p.middle, WIDTH - p.middle) - 0.1), *(d - 0.12 for d in others)])


def _lanes(diagram: Diagram, first: int, second: int) -> list[Link]:
    return [x for x in diagram.links if {x.first, x.second} == {first, second}]


def _side_by_side(diagram: Diagram, order: tuple[int, ...]) -> dict[int, _Place]:
    n = len(order)
    left = 1.25 if _lanes(diagram, order[0], GROUND) else 0.45
    right = 1.25 if n > 1 and _lanes(diagram, order[-1], GROUND) else 0.45
    gaps = [left, *([1.25] * (n - 1)), right]
    unit = min(1.3, (WIDTH - 0.4) / (n + sum(gaps)))
    start = 0.5 * (WIDTH - unit * (n + sum(gaps)))
    ends = list(pairwise(order))
    most = max(
        [len(_lanes(diagram, i, j)) for i, j in ends] + [len(_lanes(diagram, e, GROUND)) for e in (order[0], order[-1])]
    )
    height = max(1.05, LANE * most)
    return {body: _Place(start + unit * (sum(gaps[: k + 1]) + k), 0.0, unit, height) for k, body in enumerate(order)}


def _on_each_other(diagram: Diagram, pair: tuple[int, int] | None) -> dict[int, _Place]:
    assert pair is not None
    upper, lower = pair
    high = [max(1.0, LANE * len(_lanes(diagram, i, GROUND))) for i in (lower, upper)]
    return {lower: _Place(1.9, 0.0, 2.6, high[0]), upper: _Place(1.9, high[0], 1.4, high[1])}


def _coordinate(sheet: Sheet, diagram: Diagram, i: int, p: _Place, aside: bool, room: float) -> None:
    """Draw the arrow of a coordinate and that of the load; beside the body if another one stands on it."""
    x, y = (p.right + 0.2, p.low + 0.45 * p.height) if aside else (p.middle - 0.3, p.top + 0.2)
    arrow(sheet.ax, x, y, 0.6, 0, sheet.label(diagram.bodies[i].coordinate, 0.8, "coordinate"), INK)
    for load in (e for e in diagram.loads if e.body == i):
        x, y = (p.right + 0.2, p.low + 0.1) if aside else (p.left + 0.2, p.top + 0.82)
        room = (WIDTH - 0.1 - x) if len(diagram.bodies) == 1 or aside else room
        colour, back = PALE if load.absent else ORANGE, load.force.could_extract_minus_sign()
        sheet.pale |= load.absent
        arrow(sheet.ax, x + 0.5 * back, y, -0.5 if back else 0.5, 0, "", colour)
        name = sheet.label(-load.force if back else load.force, room, "force")
        sheet.ax.text(x, y + 0.08, name, ha="left", va="bottom")


def _draw_links(sheet: Sheet, diagram: Diagram, places: dict[int, _Place], order: tuple[int, ...]) -> Routes:
    """Draw links between neighbours and to walls; return those that go above the row."""
    routed, stacked = [], _stacked(diagram)
    at = {body: k for k, body in enumerate(order)}
    last = len(order) - 1
    pairs = dict.fromkeys((x.first, x.second) for x in diagram.links)
    for first, second in pairs:
        links, p = _lanes(diagram, first, second), places[first]
        if second != GROUND:
            if stacked:
                _rub(sheet, links[0], max(places.values(), key=lambda q: q.low))
            elif abs(at[first] - at[second]) > 1:
                routed.append((first, second, links))
            else:
                a, b = sorted((p, places[second]), key=lambda q: q.left)
                _side(sheet, links, a.right, b.left, p)
        elif stacked or at[first] == 0:
            wall(sheet.ax, 0.3 if stacked else p.left - 1.25 * p.width, p.low, p.top)
            _side(sheet, links, 0.3 if stacked else p.left - 1.25 * p.width, p.left, p)
        elif at[first] == last:
            wall(sheet.ax, p.right + 1.25 * p.width, p.low, p.top, side=1)
            _side(sheet, links, p.right, p.right + 1.25 * p.width, p)
        else:
            routed.append((first, GROUND, links))
    return routed


def _side(sheet: Sheet, links: list[Link], start: float, end: float, p: _Place) -> None:
    """Draw the links of a gap, one below the other."""
    for k, link in enumerate(links):
        y = p.top - p.height * (k + 0.5) / len(links) - 0.12
        _link(sheet, link, start, end, y, end - start - 0.08)


def _link(sheet: Sheet, link: Link, start: float, end: float, y: float, room: float) -> None:
    colour = PALE if link.absent and link.kind in ("stiffness", "damping") else INK
    sheet.pale |= colour == PALE
    if link.kind == "coupling":
        sheet.dotted = True
        sheet.ax.plot([start, end], [y, y], color=INK, linewidth=1.2, linestyle=":")
        return
    if link.kind == "friction":
        name = sheet.words(link.name, room, "contact") + _drive(sheet, link)
    elif link.kind == "gap":
        name = sheet.words(link.name, room, "contact")
    else:
        name = sheet.label(link.size, room, link.kind)
    DRAW[link.kind](sheet.ax, start, end, y, name, colour)


def _drive(sheet: Sheet, link: Link) -> str:
    """Return the mark of the velocity with which a contact of two bodies is driven; empty without one."""
    return "" if link.size.is_zero else " " + sheet.mark(f"drive of {link.name}:", mathematics(link.size))


def _rub(sheet: Sheet, link: Link, upper: _Place) -> None:
    """Write the name of the contact between a body and the one below it."""
    name = sheet.words(link.name, 1.1, "contact") + _drive(sheet, link)
    sheet.ax.plot([upper.left, upper.right], [upper.low] * 2, color=ORANGE, linewidth=3)
    sheet.ax.text(upper.right + 0.1, upper.low + 0.08, name, ha="left", va="bottom", color=INK)


def _surface(sheet: Sheet, surface: Surface, p: _Place, floor: float, room: float) -> float:
    """Draw the surface under a body; return the lower end of what is written below it."""
    if floor < p.low:
        if surface.sprung:
            zig = p.middle + np.array([0, 0, 0.12, -0.12, 0.12, -0.12, 0, 0])
            sheet.ax.plot(zig, np.linspace(p.low, floor + 0.1, 8), color=INK, linewidth=1.1)
            block(sheet.ax, p.middle - 0.2, floor, 0.4, 0.1, "")
        else:
            block(sheet.ax, p.middle - 0.2, floor, 0.4, p.low - floor, "")
    lines, y = [sheet.words(surface.name, room, "contact")], floor - 0.42
    if surface.velocity.is_zero:
        ground(sheet.ax, floor, p.left - 0.12, p.right + 0.12)
    else:
        _belt(sheet, surface, p, floor, room)
        y = floor - 0.9
    if surface.load != 1:
        load = mathematics(surface.load)
        line = f"load {load}"
        lines.append(line if width(line) <= room else sheet.mark("load", load))
    for line in lines:
        sheet.ax.text(p.middle, y, line, ha="center", va="center", color=INK)
        y -= 0.3
    return y + 0.1


def _belt(sheet: Sheet, surface: Surface, p: _Place, floor: float, room: float) -> None:
    """Draw a belt with the arrow of its velocity."""
    for x in (p.left + 0.05, p.right - 0.05):
        roller(sheet.ax, x, floor - 0.14, 0.14)
    for y in (floor, floor - 0.28):
        sheet.ax.plot([p.left + 0.05, p.right - 0.05], [y, y], color=INK, linewidth=1.4)
    back = surface.velocity.could_extract_minus_sign()
    name = sheet.label(-surface.velocity if back else surface.velocity, max(0.2, room - 0.6), "velocity")
    whole = 0.55 + width(name)
    x = p.middle - 0.5 * whole
    arrow(sheet.ax, x + (0.45 if back else 0), floor - 0.52, -0.45 if back else 0.45, 0, "")
    sheet.ax.text(x + 0.55, floor - 0.52, name, ha="left", va="center")


def _draw_routes(sheet: Sheet, places: dict[int, _Place], routed: Routes, top: float) -> float:
    """Draw links that pass above others, those to the ground first and side by side; return the upper end."""
    base = top
    for first, _, links in (r for r in routed if r[1] == GROUND):
        p, pitch = places[first], _pitch(places, first)
        x, end = p.left + 0.08, p.left + min(1.5, pitch - 0.1)
        for k, link in enumerate(links):
            y = base + 0.25 + k * ROUTE
            wall(sheet.ax, end, y - 0.22, y + 0.22, side=1)
            sheet.ax.plot([x, x], [p.top, y], color=GREY, linewidth=0.9)
            _link(sheet, link, x, end, y, end - x)
            top = max(top, y + ROUTE - 0.25)
    pairs = [r for r in routed if r[1] != GROUND]
    for first, second, links in pairs:
        a, b = sorted((places[first], places[second]), key=lambda q: q.left)
        x, end = a.right - 0.08, b.left + 0.08
        for link in links:
            y = top + 0.25
            sheet.ax.plot([x, x], [a.top, y], color=GREY, linewidth=0.9)
            sheet.ax.plot([end, end], [b.top, y], color=GREY, linewidth=0.9)
            _link(sheet, link, x, end, y, end - x if len(pairs) == 1 else 0.35)
            top += ROUTE
    return top


def _graph(sheet: Sheet, diagram: Diagram) -> tuple[float, float]:
    """Draw bodies on a circle, with lines for links; return the lower and the upper end of the drawing."""
    from matplotlib.patches import Circle

    n, centre, far = len(diagram.bodies), np.array([0.5 * WIDTH, 0.0]), 2.0
    angle = np.pi / 2 - 2 * np.pi * np.arange(n) / n
    out = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    at, size = centre + far * out, min(0.3, 0.8 * np.pi * far / n)
    for link in (x for x in diagram.links if x.second != GROUND):
        ends = at[[link.first, link.second]]
        style = {"friction": (ORANGE, "-"), "coupling": (INK, ":")}.get(link.kind, (INK, "-"))
        sheet.dotted |= link.kind == "coupling"
        sheet.ax.plot(ends[:, 0], ends[:, 1], color=style[0], linestyle=style[1], linewidth=1.1, zorder=1)
    grounded = {x.first for x in diagram.links if x.second == GROUND}
    rubbing = {s.body for s in diagram.surfaces}
    for i, body in enumerate(diagram.bodies):
        side = np.array([-out[i, 1], out[i, 0]])
        for colour, shift in [(INK, -0.1)] * (i in grounded) + [(ORANGE, 0.1)] * (i in rubbing):
            foot = at[i] + (size + 0.3) * out[i] + shift * side
            sheet.ax.plot(*np.stack([at[i] + shift * side, foot]).T, color=colour, linewidth=1.1, zorder=1)
            sheet.ax.plot(*np.stack([foot - 0.1 * side, foot + 0.1 * side]).T, color=colour, linewidth=2.4)
        sheet.ax.add_patch(Circle(tuple(at[i]), size, facecolor="white", edgecolor=INK, zorder=2))
        name = sheet.label(body.coordinate, 1.9 * size, "coordinate")
        sheet.ax.text(*at[i], name, ha="center", va="center", zorder=3)
    sheet.key.append("black: springs and dampers; orange: contacts; ends outside: to the ground or a drive")
    reach = far + size + 0.5
    return -reach, reach
