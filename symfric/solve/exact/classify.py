"""Classify a scene for the `exact` route: an oscillator in closed form, or matrices for every mode."""

from dataclasses import dataclass

import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.automaton import Automaton
from symfric.lower.linear_modes import Matrices, Oscillator, lines_of, matrices, oscillator, without_harmonics
from symfric.model.outputs import RANGE
from symfric.model.scene import Scene
from symfric.solve.exact.record.observables import Recorded, recorded_in
from symfric.solve.lowered import LoweredScene


@dataclass(frozen=True)
class ModalForm:
    """Equations that are linear in every mode, by their matrices."""

    automaton: Automaton
    matrices: Matrices


@dataclass(frozen=True)
class Form:
    """Form of a scene that is linear between events.

    Attributes
    ----------
    scene : Scene
        With states for the functions of time.
    parameters : tuple of Symbol
    problem : Oscillator, Recorded or ModalForm
        One mass in closed form, one under a sampled input, or matrices for every mode.
    cheapest : bool
        Whether the other routes take longer. The matrices of ten masses are compiled in half the time of their series;
        a run by series is faster by a third, which some thousand runs pay back. Harmonics as states make every step
        longer.
    words : str
        For `explain`.
    """

    scene: Scene
    parameters: tuple[sp.Symbol, ...]
    problem: Oscillator | Recorded | ModalForm
    cheapest: bool
    words: str


def form_of(lowered: LoweredScene) -> Form:
    """Determine the form of a scene.

    Raises
    ------
    NoRoute
        If it is not linear between events; the message names the nonlinear part.
    """
    scene, varied = lowered.scene, lowered.varied
    for contact in scene.contacts_behind_springs:
        raise NoRoute(f"contact {contact.name!r} is behind a spring")
    for contact in scene.contacts:
        lines_of(contact.law)
    try:
        return _in_closed_form(lowered)
    except NoRoute as reason:
        why = str(reason)
    timeless = without_harmonics(scene)
    automaton = (lowered if timeless is scene else LoweredScene(timeless, varied)).automaton
    slopes = matrices(automaton)
    many = max(len(scene.system.q), len(scene.contacts)) > 1
    cheapest = many and timeless is scene
    words = f"linear between events, by powers of its matrices (no closed form: {why})"
    return Form(timeless, automaton.parameters, ModalForm(automaton, slopes), cheapest, words)


def _in_closed_form(lowered: LoweredScene) -> Form:
    """Return the closed form of a single mass, which needs no matrices."""
    scene = lowered.scene
    if scene.inputs:
        recorded = recorded_in(lowered)
        words = "one mass on the floor under a sampled input, from sample to sample in closed form"
        return Form(scene, recorded.problem.parameters, recorded, True, words)
    closed = _closed(lowered)
    words = "one mass, linear between events, in closed form"
    return Form(scene, closed.parameters, closed, True, words)


def _closed(lowered: LoweredScene) -> Oscillator:
    rows = lowered.wanted.rows
    if any(r.kind != RANGE for r in rows):
        raise NoRoute("an integral or a value at a time is wanted")
    return oscillator(lowered.dynamics, [r.expr for r in rows])
