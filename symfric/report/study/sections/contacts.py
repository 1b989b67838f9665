"""What each contact of a structure does during the motion: sticking, least load, dissipated energy."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric.report.html.elements import Picture, gallery, subheading, table
from symfric.report.html.words import measured
from symfric.report.study.drawing.axes import BLUE, ORANGE, Axes, label, legend, new_axes, plain_name, to_svg
from symfric.report.study.measurement import SampledMotion, contact_outputs
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.report.study.sections.matrices import is_structure
from symfric.report.study.sections.motion import MOTION, STEADY

PERIODS = 4.0  # of the last stretch of the motion
Intervals = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class ContactShare:
    """What a contact does during the motion.

    Attributes
    ----------
    contact : str
    sticks : float
        Fraction of the time.
    least : float
        Smallest normal load; zero if it opens.
    dissipated : float
        Energy.
    """

    contact: str
    sticks: float
    least: float
    dissipated: float


def _compute(study: StudyResult, _tell: Progress) -> tuple[ContactShare, ...]:
    motion, scene = study[MOTION].found, study.file.scene
    if not contact_outputs(scene):
        return ()
    end = float(motion.t[-1])
    return tuple(
        ContactShare(
            c.name,
            sum(b - a for a, b in motion.sticks[c.name]) / end,
            motion.also[f"least load of contact {c.name}"],
            motion.also[f"energy dissipated in contact {c.name}"],
        )
        for c in scene.contacts
    )


def _page(study: StudyResult) -> Iterator[Markup]:
    shares, units = study[CONTACTS].value, study.file.units
    if not shares:
        return
    first = study.file.scene.contacts[0]
    load, energy = units.of(first.normal), units.of(first.normal * first.slip * TIME)
    head = [
        "contact",
        "sticks [%]",
        "least load" + (f" [{load}]" if load else ""),
        "energy dissipated" + (f" [{energy}]" if energy else ""),
    ]
    rows = [
        [
            s.contact,
            measured(100 * s.sticks),
            "0 (opens)" if s.least <= 0 else measured(s.least),
            measured(s.dissipated),
        ]
        for s in shares
    ]
    yield subheading("What the contacts do")
    yield gallery(lambda: [_picture(study, study[MOTION].found)])
    yield table(head, rows, [1, 2, 3])


def _picture(study: StudyResult, motion: SampledMotion) -> Picture:
    """Draw when the contacts stick and open, over the last periods of the motion."""
    scene, end, steady = study.file.scene, float(motion.t[-1]), study[STEADY].value
    begin = 0.0
    if steady is not None and np.isfinite(steady.period):
        begin = max(0.0, end - PERIODS * steady.period)
    states = {c.name: (motion.sticks[c.name], _open(scene, motion, c)) for c in scene.contacts}
    what = "over the last periods" if begin > motion.t[0] else "over the motion"
    return Picture(
        to_svg(plot_contacts(states, (begin, end), study.file.units)),
        f"When each of {len(states)} contacts sticks, slips and opens, {what}",
        f"The contacts {what}: sticking, slipping, open.",
    )


def _open(scene: Scene, motion: SampledMotion, contact: Contact) -> Intervals:
    """Return the intervals in which the load of a contact is zero, to the samples of the motion."""
    used = sorted(contact.normal.free_symbols & set(scene.system.rows), key=str)
    part, values = scene.system.linear, scene.parameter_values()
    known = [s for s in contact.normal.free_symbols if s in values]
    if not used or part is None or set(contact.normal.free_symbols) - set(used) - set(known):
        return []
    n = len(scene.system.q)
    rows = [part.rows[s].weights @ (motion.x[:n] if part.rows[s].of == "q" else motion.x[n : 2 * n]) for s in used]
    letters = tuple(type(s)(f"row{k}", real=True) for k, s in enumerate(used))
    written = contact.normal.xreplace(dict(zip(used, letters, strict=True)))
    load = numeric_function((*letters, *known), written)(*rows, *(float(values[s]) for s in known))
    shut = np.concatenate([[False], load <= 0, [False]])
    starts, ends = np.flatnonzero(shut[1:] & ~shut[:-1]), np.flatnonzero(~shut[1:] & shut[:-1]) - 1
    return [(float(motion.t[a]), float(motion.t[b])) for a, b in zip(starts, ends, strict=True)]


def plot_contacts(
    states: Mapping[str, tuple[Intervals, Intervals]],
    span: tuple[float, float],
    units: Mapping[str, str],
    otherwise: str = "slips",
    ax: Axes | None = None,
) -> Axes:
    """Draw when contacts stick and when they are open, one line for each; else they are as the word says."""
    ax = new_axes((5.4, 1.3 + 0.3 * len(states))) if ax is None else ax
    for k, (sticks, opens) in enumerate(states.values()):
        ax.barh(k, span[1] - span[0], left=span[0], height=0.72, color="0.92", label="" if k else otherwise)
        for intervals, colour, word in ((sticks, ORANGE, "sticks"), (opens, BLUE, "open")):
            parts = [(max(a, span[0]), min(b, span[1])) for a, b in intervals if b > span[0] and a < span[1]]
            ax.broken_barh([(a, b - a) for a, b in parts], (k - 0.36, 0.72), color=colour, linewidth=0)
            if k == 0:
                ax.barh(k, 0.0, left=span[0], color=colour, label=word)
    ax.set_yticks(range(len(states)), [plain_name(name) for name in states])
    ax.set_xlim(span)
    ax.set_ylim(len(states) - 0.4, -0.6)
    ax.set_xlabel(label("t", units))
    legend(ax, 3, above=1.0)
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    ax.tick_params(axis="y", length=0)
    return ax


def _data(_study: StudyResult, shares: tuple[ContactShare, ...]) -> dict[str, object]:
    return {s.contact: {"sticks": s.sticks, "least_load": s.least, "dissipated": s.dissipated} for s in shares}


CONTACTS = Section(
    "contacts", _compute, asked=is_structure, place=51, page=_page, key="structure.contacts", data=_data, without={}
)
