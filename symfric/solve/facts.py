"""Properties of a scene on which route selection depends."""

import logging
from dataclasses import dataclass
from functools import cache

import numpy as np
import sympy as sp

from symfric.model.constant_parameters import averaged_over, vanishing
from symfric.model.outputs import OutputOfExpression
from symfric.model.scene import Scene
from symfric.solve.lowered import LoweredScene

_LITTLE = 1e-9  # factor of a term of a surface's speed that is rounding


@dataclass(frozen=True)
class Facts:
    """Properties of a scene that decide its route and what can be left out.

    Attributes
    ----------
    contacts, kinks, states : int
        Number of contacts that can stick, of kinks in the forces and laws, of states.
    remembering : int
        Number of contacts whose law has memory.
    smooth : bool
        No contact can stick.
    autonomous, sampled : bool
        Time appears nowhere; an input is sampled.
    dropped : tuple of str
        Parameters that are exactly zero and are left out of the equations.
    averaged_over : tuple of str
        Parameters inside a law's mean over fast vibration, which is made for their present values.
    redundant : tuple of str
        Contacts whose slip is a combination of those of the contacts before them: when all stick, their forces are not
        determined, and hold as long as any within the bounds do.
    path, events, scalars : bool
        Whether a trajectory, the events, or scalar outputs are among the outputs.
    """

    contacts: int
    kinks: int
    states: int
    remembering: int
    smooth: bool
    autonomous: bool
    sampled: bool
    dropped: tuple[str, ...]
    averaged_over: tuple[str, ...]
    redundant: tuple[str, ...]
    path: bool
    events: bool
    scalars: bool


def facts_of(lowered: LoweredScene) -> Facts:
    """Determine the properties of a scene."""
    scene, automaton = lowered.scene, lowered.automaton
    outputs = list(scene.outputs.values())
    return Facts(
        contacts=sum(automaton.sticks) + sum(not c.clocks for c in automaton.layout.others) - 2 * len(automaton.planes),
        kinks=automaton.layout.switches,
        states=len(automaton.states),
        smooth=not (any(automaton.sticks) or automaton.layout.others),
        remembering=sum(c.law.memory is not None for c in scene.contacts),
        autonomous=automaton.autonomous,
        sampled=bool(automaton.inputs),
        dropped=tuple(sorted(s.name for s in vanishing(scene, lowered.varied))),
        averaged_over=tuple(sorted(s.name for s in averaged_over(scene, lowered.varied))),
        redundant=redundant(scene),
        path=any(o.keeps_path for o in outputs),
        events=any(o.keeps_events for o in outputs),
        scalars=any(isinstance(o, OutputOfExpression) for o in outputs),
    )


def redundant(scene: Scene) -> tuple[str, ...]:
    """Return the contacts that can stick and whose slip depends linearly on those of earlier ones, at the start.

    Surfaces that move apart, belts at two speeds, cannot be stuck to together. Contacts that open are left out: most of
    the time few of them touch.
    """
    sticking = [c for c in scene.contacts if not c.law.smooth and c.along_line and c.unilateral is None]
    if len(sticking) < 2:
        return ()
    sticking = [c for c in sticking for _ in c.slips]
    numbers, slopes = scene.numbers(), [scene.system.slopes(w) for c in dict.fromkeys(sticking) for w in c.slips]
    if not all(isinstance(row, np.ndarray) for row in slopes):
        entries = sp.Matrix([list(row) for row in slopes]).xreplace(numbers)
        if entries.free_symbols:
            return ()
        slopes = entries.tolist()
    rows, dependent, rank = np.array(slopes, dtype=float), [], 0
    slips = [w for c in dict.fromkeys(sticking) for w in c.slips]
    for k, contact in enumerate(sticking):
        now = int(np.linalg.matrix_rank(rows[: k + 1]))
        if now == rank and _move_as_one(scene, slips[: k + 1], np.linalg.lstsq(rows[:k].T, rows[k], rcond=None)[0]):
            dependent.append(contact.name)
        rank = now
    return tuple(dict.fromkeys(dependent))


def _move_as_one(scene: Scene, slips: list[sp.Expr], shares: np.ndarray) -> bool:
    """Whether the surface of the last contact moves as a combination of the others, term by term.

    The speeds of surfaces are what is left of slips without velocities.
    """
    part = scene.system.linear
    rows = () if part is None else [s for s, row in part.rows.items() if row.of == "u"]
    still = dict.fromkeys((*scene.system.u, *rows), sp.S.Zero)
    rest = slips[-1] - sp.Add(*(float(c) * w for c, w in zip(shares, slips, strict=False)))
    terms = sp.expand(rest.xreplace(still).xreplace(scene.parameter_values())).as_coefficients_dict()
    return all(abs(float(factor)) < _LITTLE for factor in terms.values())


@cache
def warn_of_redundance(names: tuple[str, ...]) -> None:
    """Log once that the forces of redundant contacts are not determined separately."""
    logging.getLogger("symfric").warning(
        "redundant contacts: the slip of %s follows from that of others; the motion is unique, the forces while they "
        "stick are not: parallel ones share them in proportion to their bounds, any other along a line carries nothing "
        "until another has reached its bound; in the plane feet of a body that turns have forces well inside their "
        "bounds, which friction_force shows, one choice of many",
        ", ".join(names),
    )
