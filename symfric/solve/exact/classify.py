"""Classify a scene for the `exact` route: an oscillator in closed form, or matrices for every mode."""

from dataclasses import dataclass

import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.automaton import Automaton
from symfric.lower.linear_modes import Matrices, Oscillator, lines_of, matrices, oscillator, without_harmonics
from symfric.lower.sampled_oscillator import Record, record
from symfric.lower.structure_modes import OtherForm, structure_matrices
from symfric.model.rows import CROSSINGS, INTEGRAL, RANGE, Row
from symfric.model.scene import Scene
from symfric.solve.loop.stepping.linear_series import MOST
from symfric.solve.lowered import LoweredScene
from symfric.solve.observables import Observables

_WRITTEN = 4  # coordinates up to which powers of the whole matrices, written out, are faster than by the structure
_FULL = 40  # matrix entries per row beyond which a product with all of them takes longer than a series


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
    problem : Oscillator, Record or ModalForm
        One mass in closed form, one under a sampled input, or matrices for every mode.
    observables : Observables
        Of `scene`.
    cheapest : bool
        Whether the other routes take longer until the first result. The matrices of ten masses with ten contacts are
        ready in a sixth of the time that their series take to compile. A run takes .27 ms, to all digits, and one by
        series .21 to .27, to 4 digits or all: some ten thousand runs pay the series back. Harmonics as states make
        every step longer. A structure is ready ten times sooner; a run takes 1 to 1.5 times as long with ten modes, two
        thirds of the time with thirty, a fifth with a hundred, of which harmonics are a small part.
    words : str
        For `explain`.
    """

    scene: Scene
    parameters: tuple[sp.Symbol, ...]
    problem: Oscillator | Record | ModalForm
    observables: Observables
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
    if scene.clocks and scene.system.linear is not None:
        raise NoRoute("held variables and resets beside the matrices of a structure are for the route 'taylor'")
    for contact in scene.contacts:
        if contact.in_plane:
            raise NoRoute(f"contact {contact.name!r} slides in the plane")
        try:
            lines_of(contact.law)
        except NoRoute as reason:
            raise NoRoute(f"{reason} (contact {contact.name!r})") from None
    try:
        return _in_closed_form(lowered)
    except NoRoute as reason:
        why = str(reason)
    timeless = without_harmonics(scene)
    inner = lowered if timeless is scene else LoweredScene(timeless, varied)
    if scene.system.linear is not None and len(scene.system.q) > _WRITTEN:
        try:
            return _structure(timeless, inner)
        except OtherForm as reason:
            why = str(reason)
    form = ModalForm(inner.automaton, matrices(inner.automaton))
    words = f"linear between events, by powers of its matrices (no closed form: {why})"
    cheapest = _cheapest(scene, timeless, form.matrices)
    if cheapest and len(form.matrices.rows) > MOST:
        words += "; ready far sooner than the series of route='taylor', of which a run may be a little faster"
    return Form(timeless, inner.automaton.parameters, form, inner.observables, cheapest, words)


def _structure(scene: Scene, lowered: LoweredScene) -> Form:
    """Return the form of a scene from matrices of which the mode changes only what contacts feel and do."""
    modal = structure_matrices(scene, [r.expr for r in lowered.observables.rows], lowered.varied)
    words = "linear between events, by powers of the structure's matrices, with contacts along its rows"
    form = ModalForm(lowered.automaton, modal)
    return Form(scene, lowered.automaton.parameters, form, lowered.observables, True, words)


def _cheapest(scene: Scene, timeless: Scene, modal: Matrices) -> bool:
    """Whether powers of matrices of which no form is known are prepared and run faster than series."""
    if timeless is not scene or scene.clocks or max(len(scene.system.q), len(scene.contacts)) < 2:
        return False
    return len(modal.rows) <= _FULL * modal.n_r


def _in_closed_form(lowered: LoweredScene) -> Form:
    """Return the closed form of a single mass, which needs no matrices."""
    scene = lowered.scene
    if scene.contacts_that_open:
        raise NoRoute("a contact opens")
    if scene.clocks:
        raise NoRoute("held variables or resets")
    if scene.inputs:
        recorded = recorded_in(lowered)
        words = "one mass on the floor under a sampled input, from sample to sample in closed form"
        return Form(scene, recorded.parameters, recorded, lowered.observables, True, words)
    closed = _closed(lowered)
    words = "one mass, linear between events, in closed form"
    return Form(scene, closed.parameters, closed, lowered.observables, True, words)


def recorded_in(lowered: LoweredScene) -> Record:
    """Express a scene as one mass under a record.

    Raises
    ------
    NoRoute
        If the scene has another form, or an output that the march does not provide.
    """
    rows = lowered.observables.rows
    if any(r.kind == INTEGRAL for r in rows):
        raise NoRoute("an integral is wanted")
    _refuse_parts(rows)
    return record(lowered.dynamics, lowered.scene.inputs, [r.expr for r in rows])


def _refuse_parts(rows: tuple[Row, ...]) -> None:
    """Raise if an observable is accumulated over a part of the run, or its crossings are counted."""
    if any(r.kind == CROSSINGS for r in rows):
        raise NoRoute("a period is wanted")
    if any(r.start > 0.0 for r in rows):
        raise NoRoute("an extreme after a time is wanted")


def _closed(lowered: LoweredScene) -> Oscillator:
    rows = lowered.observables.rows
    if any(r.kind != RANGE for r in rows):
        raise NoRoute("an integral, a period or a value at a time is wanted")
    _refuse_parts(rows)
    return oscillator(lowered.dynamics, [r.expr for r in rows])
