"""Analysis of a computed decay: energy balance, and distance of each turning point from the stick limit."""

import math
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from symfric.errors import SceneError
from symfric.model import scenes
from symfric.model.numeric import numeric
from symfric.model.results import Result
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import TIME, shortened
from symfric.spelling import spelt

ENERGIES = ("E_viscous", "E_contact")  # outputs of the ready scene used in the balance


@runtime_checkable
class Run(Protocol):
    """What is used here of a run, the class of which a layer above defines."""

    scene: Scene
    base: Any
    final: Any
    outputs: Any
    events: Any


@dataclass(frozen=True)
class EnergyBalance(Result):
    """Energy balance of a contact damper, J.

    Attributes
    ----------
    input : float
        Initial energy, potential and kinetic.
    viscous, contact : float
        Dissipated by the damper, and by the contact.
    elastic, kinetic : float
        Remaining at the end: in the spring, because the rod sticks beside its middle, and of motion, 0 once it rests.

    Examples
    --------
    >>> import symfric as sf
    >>> rod = sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.005)
    >>> found = sf.theory.transient.energy_balance(sf.simulate(rod))
    >>> round(found.ratio, 6)
    0.29075
    >>> "ratio" in found.to_dict()
    True
    """

    input: float
    viscous: float
    contact: float
    elastic: float
    kinetic: float
    _told = ("input", "viscous", "contact", "elastic", "kinetic", "ratio", "gap", "printed_gap")

    @property
    def ratio(self) -> float:
        """``R = E_viscous/E_contact``, Younes and Ashour (6)."""
        return self.viscous / self.contact if self.contact else math.inf if self.viscous else math.nan

    @property
    def gap(self) -> float:
        """Relative error of the balance; about the tolerance of the run."""
        return self._lacking(self.viscous + self.contact + self.elastic + self.kinetic)

    @property
    def printed_gap(self) -> float:
        """Relative error of the balance (5) as printed, which omits the energy that remains in the spring."""
        return self._lacking(self.viscous + self.contact)

    def _lacking(self, told: float) -> float:
        return (self.input - told) / self.input if self.input else 0.0


@dataclass(frozen=True, eq=False)
class Decisions(Result):
    """Times at which the slip of a contact reached zero, and the distance from sticking at each.

    Attributes
    ----------
    t, x : ndarray, shape (n,)
        Time and position; the start is the first one if the mass starts at rest.
    margin : ndarray, shape (n,)
        Force on the mass over what friction can bear, less one: the mass sticks where it is 0 or negative.

    Examples
    --------
    >>> import symfric as sf
    >>> rod = sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.005)
    >>> found = sf.theory.transient.decisions(sf.simulate(rod))
    >>> round(found.last, 6)
    -0.606257
    >>> "last" in found.to_dict()
    True
    """

    t: np.ndarray
    x: np.ndarray
    margin: np.ndarray
    _told = ("t", "x", "margin", "closest", "last")

    @property
    def closest(self) -> float:
        """The margin nearest to 0; if it is near 0, a small change of parameters adds or removes a half cycle."""
        return float(self.margin[np.argmin(np.abs(self.margin))]) if self.margin.size else math.nan

    @property
    def last(self) -> float:
        """The margin at the last of these times."""
        return float(self.margin[-1]) if self.margin.size else math.nan

    def __repr__(self) -> str:
        return f"Decisions({self.t.size} times at rest, closest {self.closest:+.3g}, last {self.last:+.3g})"


def _checked(run: object) -> Run:
    if not isinstance(run, Run):
        raise SceneError(f"run is {shortened(run)}; give a Run, the result of sf.simulate")
    return run


@spelt
def damper_numbers(scene: Scene) -> tuple[dict[str, float], bool]:
    """Return the numbers of a contact damper, its start as x0 and v0, and whether its law is the literal one.

    Parameters
    ----------
    scene : Scene
        A `sf.scenes.contact_damper`.

    Returns
    -------
    (dict of str to float, bool)

    Raises
    ------
    SceneError
        If the scene is not `symfric.scenes.contact_damper`.

    Examples
    --------
    >>> import symfric as sf
    >>> rod = sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.005)
    >>> numbers, literal = sf.theory.transient.damper_numbers(rod)
    >>> numbers["f_n"], literal
    (10.0, False)
    """
    check_scene(scene)
    for literal in (False, True):
        model = scenes.contact_damper(f_n=1.0, mu_m=0.1, literal=literal)
        if (scene.system, scene.contacts) == (model.system, model.contacts):
            x, u = scene.system.states
            numbers = scene.numbers()
            named = {s.name: v for s, v in numbers.items()}
            return {**named, "x0": numbers[x], "v0": numbers[u]}, literal
    raise SceneError(
        "this holds for sf.scenes.contact_damper; this scene has other equations (sf.simulate with sf.StopTime() and "
        "sf.Integral(...) takes any)"
    )


@spelt
def energy_balance(run: Any) -> EnergyBalance:
    r"""Return the energy balance of a contact damper.

    Parameters
    ----------
    run : Run
        Of `symfric.scenes.contact_damper` with its outputs E_viscous and E_contact.

    Returns
    -------
    EnergyBalance

    Raises
    ------
    SceneError
        If the scene is another one or lacks these outputs.

    Notes
    -----
    ``m v0^2/2 + k x0^2/2 = int 2 zeta omega m x'^2 dt + int mu N |x'| dt + k x_f^2/2``, Younes and Ashour (4), (5),
    with the corrections of derivations/younes_ashour/system.py. Both sides are computed apart: the integrals along the
    run, the rest from its two ends.

    Examples
    --------
    >>> import symfric as sf
    >>> rod = sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.005)
    >>> round(sf.theory.transient.energy_balance(sf.simulate(rod)).ratio, 6)
    0.29075
    """
    run = _checked(run)
    missing = next((name for name in ENERGIES if name not in run.base.outputs), None)
    if missing:
        raise SceneError(f"the balance needs the output {missing}; keep those of sf.scenes.contact_damper")
    numbers, _ = damper_numbers(run.scene)
    m, stiffness = numbers["m"], numbers["m"] * (2 * np.pi * numbers["f_n"]) ** 2
    x, u = (float(v) for v in run.final)
    given = 0.5 * (stiffness * numbers["x0"] ** 2 + m * numbers["v0"] ** 2)
    viscous, contact = (float(run.outputs[name]) for name in ENERGIES)
    return EnergyBalance(given, viscous, contact, 0.5 * stiffness * x**2, 0.5 * m * u**2)


@spelt
def decisions(run: Any) -> Decisions:
    """Return the distance of a mass from the stick limit whenever its contact stopped sliding.

    The time of a decay jumps with the parameters where a turning point just reaches the limit; `Decisions.closest` says
    how far that is.

    Parameters
    ----------
    run : Run
        Of one mass with one contact whose slip is its velocity less a constant, with its trajectory.

    Returns
    -------
    Decisions

    Raises
    ------
    SceneError
        If the scene has another shape, or the run kept no trajectory.

    Examples
    --------
    >>> import symfric as sf
    >>> rod = sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.005)
    >>> sf.theory.transient.decisions(sf.simulate(rod))
    Decisions(22 times at rest, closest -0.606, last -0.606)
    """
    scene = _checked(run).scene.written_out()
    system = scene.system
    if len(system.states) != 2 or len(scene.contacts) != 1 or scene.inputs:
        raise SceneError("decisions are those of one mass with one contact and no sampled input")
    (contact,), (u,) = scene.contacts, system.u
    if contact.slip.free_symbols & {*system.q, TIME}:
        raise SceneError(f"the slip of contact {contact.name!r} is {contact.slip}; it may be u less a constant only")
    arrivals = [e.t for e in run.events if e.before]
    numbers = scene.numbers()
    at_rest = float(contact.slip.subs(numbers)) == 0 and numbers[system.q[0]] != 0
    times = np.array([0.0, *arrivals] if at_rest else arrivals)
    states = run(times)
    bound = contact.slip.diff(u) * contact.normal * contact.profile * contact.law.stick
    symbols = (*system.states, *scene.parameters, TIME)
    values = (numbers[s] for s in scene.parameters)
    force, largest = numeric(symbols, (system.force[0], bound))(*states, *values, times)
    with np.errstate(divide="ignore"):
        margin = np.abs(force) / np.abs(largest) - 1
    return Decisions(times, states[0], margin)
