"""Tuned mass damper: tuning and damping for least peak, least mean square, fastest decay or largest stability.

The optima are closed forms of `symfric.theory.absorber`, verified on the event-driven model. With a friction contact
there is no closed form, and `symfric.design.absorber.rough` takes over.
"""

import itertools
from collections.abc import Callable, Sequence
from math import ceil, log
from typing import Any, Literal

import numpy as np

from symfric.design.absorber.rough import rough_absorber
from symfric.design.comparison import Compared, Comparison
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.errors import SceneError
from symfric.long_calls import logged
from symfric.model import scenes
from symfric.model.arguments import is_one_of
from symfric.model.excitation import excitation_of
from symfric.model.outputs import End, HalfRange, Integral
from symfric.model.scene import Scene
from symfric.model.symbols import finite, nearest, shortened
from symfric.orbits.steady_state import Schedule, Settling
from symfric.search import ROUNDING, Function, zero
from symfric.solve.routes import prepare
from symfric.solve.run import finished
from symfric.theory import absorber as theory

CRITERIA = ("hinf", "h2", "decay", "self-excited")
TOLERANCE = 1e-11  # tolerance of the runs
GONE = 1e-11  # remaining fraction of a transient after which the amplitude is measured
BESIDE = 0.02  # distance from the bound of self-excitation, relative to it, at which the event-driven model is run
SIMPLEX = np.array([[1.0, 1.0], [1.01, 1.0], [1.0, 1.01]])
COINCIDENT = 1e-4  # error of a decay rate by rounding where eigenvalues coincide in pairs
MULTIPLIERS = 1e-14  # rounding error of the multipliers from a run over the decay time
QUADRUPLE = 0.02  # relative distance from the mass ratio 4 within which all four eigenvalues nearly coincide


@logged
def absorber(
    mass_ratio: float,
    criterion: Literal["hinf", "h2", "decay", "self-excited"] = "hinf",
    *,
    contact: Literal["absorber", "main"] | None = None,
    friction: float = 0.0,
    static_friction: float | None = None,
    band: tuple[float, float] = (0.5, 1.5),
) -> Design:
    """Find the best tuning and damping of a mass damper on an undamped main mass.

    Parameters
    ----------
    mass_ratio : float
        ``m2/m1`` > 0.
    criterion : {"hinf", "h2", "decay", "self-excited"}
        The least peak of ``|x1 k1/F|``; the least mean square J of x1 under white noise as the force; the
        largest decay rate of free vibration over omega1; the largest ``-c1/(2 m1 omega1)`` of a main mass that excites
        itself and is still stabilised.
    contact : {None, "absorber", "main"}
        A dry contact between the masses, or between the main mass and the ground; with "hinf" only. The optimum is then
        found on the event-driven model, see `symfric.design.absorber.rough`: status "best found" is possible there.
    friction, static_friction : float
        Of the contact, over the force's amplitude F.
    band : (float, float)
        Frequencies over omega1 in which the peak counts, with a contact; all of them count without one.

    Returns
    -------
    Design
        With values "tuning", ``omega2/omega1``, and "damping", ``c2/(2 m2 omega2)``. For "self-excited" its status is
        "infimum": values as near to these as one likes stabilise what lies as little below the objective.

    Raises
    ------
    SceneError
        If an argument is wrong.

    Notes
    -----
    `symfric.theory.absorber.least_peak` (Nishihara and Asami), `least_variance` (Warburton), `fastest_decay` and
    `widest_stability`, all proved in derivations/absorber.py. Den Hartog's design is
    `symfric.theory.absorber.fixed_points`, and `symfric.theory.absorber.peaks` tells how high its peaks are.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.design.absorber(0.1)
    >>> {name: round(float(value), 6) for name, value in found.values.items()}
    {'tuning': 0.909058, 'damping': 0.18547}
    >>> round(float(found.objective), 6)
    4.589166
    """
    if not is_one_of(criterion, CRITERIA):
        raise SceneError(f"no criterion {shortened(criterion)}{nearest(str(criterion), CRITERIA)}")
    if contact is not None:
        if criterion != "hinf":
            raise SceneError(f"with a contact the criterion is 'hinf', not {criterion!r}; no other is available")
        return rough_absorber(mass_ratio, contact, friction, static_friction, band)
    if finite(friction, "friction") != 0 or static_friction is not None:
        raise SceneError("friction is given without a contact; say contact='absorber' or contact='main'")
    design = {"hinf": _least_peak, "h2": _least_variance, "decay": _fastest_decay, "self-excited": _widest_stability}
    return design[criterion](mass_ratio)


def _scene(mass_ratio: float, tuned: theory.Tuned, **changes: Any) -> Scene:
    return scenes.absorber(mass_ratio=mass_ratio, tuning=tuned.tuning, damping=tuned.damping, **changes)


def _result(
    tuned: theory.Tuned,
    active: Sequence[str],
    scene: Scene,
    rows: Sequence[Compared],
    curve: Curve,
    objective: Callable[[float, float], float],
    claim: str = "optimal",
    sense: int = 1,
) -> Design:
    """Return the verified design; `objective` is evaluated for the neighbouring designs too."""
    values = {"tuning": tuned.tuning, "damping": tuned.damping}
    check, beside = Comparison(tuple(rows)), _beside(tuned, objective)
    return design(values, tuned.value, active, scene, check, curve, claim=claim, neighbours=beside, sense=sense)


def _beside(tuned: theory.Tuned, objective: Callable[[float, float], float]) -> list[Neighbour]:
    """Return the neighbours of a design, in eight directions and at two distances."""
    neighbours = []
    for step, f, z in itertools.product((1e-2, 1e-3), (-1, 0, 1), (-1, 0, 1)):
        if f or z:
            tuning, damping = tuned.tuning * (1 + f * step), tuned.damping * (1 + z * step)
            change = f"tuning {tuning:.6g}, damping {damping:.6g}"
            neighbours.append(Neighbour(change, objective(tuning, damping), 0.0))
    return neighbours


def _least_peak(mass_ratio: float) -> Design:
    tuned = theory.least_peak(mass_ratio)
    places = sorted(g for g, _ in theory.peaks(mass_ratio, *tuned[:2]))
    scene = _scene(mass_ratio, tuned, Omega=places[-1])
    rate = theory.decay_rate(mass_ratio, *tuned[:2])
    amplitude = _steady_amplitude(scene, rate)
    rows = [
        Compared(f"amplitude at Omega = {places[-1]:.6g}", tuned.value, amplitude, 1e-6),
        Compared("H-infinity norm", tuned.value, theory.peaks(mass_ratio, *tuned[:2])[0][1], 1e-9),
    ]
    active = [f"amplitude at Omega = {g:.6g}" for g in places]
    curve = _response_curve(mass_ratio, tuned, places)
    return _result(tuned, active, scene, rows, curve, lambda f, z: theory.peaks(mass_ratio, f, z)[0][1])


def _least_variance(mass_ratio: float) -> Design:
    tuned = theory.least_variance(mass_ratio)
    scene = _scene(mass_ratio, tuned, F=0.0)
    (x1, *_), rate = scene.system.q, theory.decay_rate(mass_ratio, *tuned[:2])
    struck = scene.starting({"u1": 1.0}).until(0.5 * log(1 / GONE) / rate, {"J": Integral(x1**2)})
    computed = finished(prepare(struck, TOLERANCE).run())["J"]
    rows = [
        Compared("mean square, from the response to an impulse", tuned.value, computed, 1e-8),
        Compared("squared H2 norm", tuned.value, theory.variance(mass_ratio, *tuned[:2]), 1e-9),
    ]
    places = sorted(g for g, _ in theory.peaks(mass_ratio, *tuned[:2]))
    curve = _response_curve(mass_ratio, tuned, places)
    return _result(tuned, (), scene, rows, curve, lambda f, z: theory.variance(mass_ratio, f, z))


def _fastest_decay(mass_ratio: float) -> Design:
    tuned = theory.fastest_decay(mass_ratio)
    scene = _scene(mass_ratio, tuned, F=0.0)
    computed = rate_of_runs(scene, 1.0 / tuned.value)
    active = ["both pairs of eigenvalues coincide" if mass_ratio <= 4 else "three eigenvalues coincide"]
    rows = [Compared("decay rate", tuned.value, computed, _blurred(mass_ratio), size=1.0)]
    curve = _rate_curve("decay rate", tuned, lambda f: theory.decay_rate(mass_ratio, f, tuned.damping))
    return _result(tuned, active, scene, rows, curve, lambda f, z: theory.decay_rate(mass_ratio, f, z), sense=-1)


def _blurred(mass_ratio: float) -> float:
    """Return the error of a computed rate at coinciding eigenvalues: the k-th root of rounding for a k-fold one."""
    fold = 4 if abs(mass_ratio / 4 - 1) < QUADRUPLE else 2 if mass_ratio < 4 else 3
    return max(COINCIDENT, MULTIPLIERS ** (1 / fold))


def _widest_stability(mass_ratio: float) -> Design:
    tuned = theory.widest_stability(mass_ratio)
    rows = []
    for share, word in ((1 - BESIDE, "less"), (1 + BESIDE, "more")):
        beta = share * tuned.value
        beside = _most_stable(mass_ratio, beta, tuned)
        scene = _scene(mass_ratio, beside, F=0.0, main_damping=-beta)
        name = f"decay rate with {100 * BESIDE:.2g} % {word} self-excitation, tuning {beside.tuning:.5g}, damping "
        rows.append(Compared(f"{name}{beside.damping:.5g}", beside.value, rate_of_runs(scene, 20.0), COINCIDENT, 1.0))
    curve = _rate_curve(
        "decay rate at the bound", tuned, lambda f: theory.decay_rate(mass_ratio, f, tuned.damping, -tuned.value)
    )
    scene = _scene(mass_ratio, tuned, F=0.0, main_damping=-tuned.value)
    active = ["both pairs of eigenvalues meet on the imaginary axis"]
    return _result(tuned, active, scene, rows, curve, lambda f, z: _bound(mass_ratio, f, z), "infimum", sense=-1)


def _bound(mass_ratio: float, tuning: float, damping: float) -> float:
    """Return the largest self-excitation at which a tuning and damping is stable."""
    return stable_up_to(lambda beta: theory.decay_rate(mass_ratio, tuning, damping, -beta), 1.0)


def stable_up_to(rate: Function, most: float) -> float:
    """Return the self-excitation up to which a decay rate is positive, 0 if it is not without any."""
    return zero(rate, 0.0, most, xtol=1e-14, rtol=ROUNDING) if rate(most) < 0 < rate(0.0) else 0.0


def _most_stable(mass_ratio: float, beta: float, tuned: theory.Tuned) -> theory.Tuned:
    """Return tuning, damping and decay rate of the fastest decay near a design, for a given self-excitation."""
    from scipy.optimize import minimize

    def rate(p: np.ndarray) -> float:
        tuning, damping = np.abs(p)
        return -theory.decay_rate(mass_ratio, tuning, damping, -beta)

    fastest = minimize(
        rate,
        tuned[:2],
        method="Nelder-Mead",
        options={"xatol": 1e-6, "fatol": 1e-9, "initial_simplex": np.array(tuned[:2]) * SIMPLEX},
    )
    tuning, damping = (float(e) for e in np.abs(fastest.x))
    return theory.Tuned(tuning, damping, -float(fastest.fun))


def rate_of_runs(scene: Scene, duration: float) -> float:
    """Return the decay rate of the event-driven model, from the largest multiplier over a time."""
    program = prepare(scene.until(duration, {"end": End()}), TOLERANCE)
    names = [s.name for s in scene.system.states]
    starts = (dict(zip(names, row, strict=True)) for row in np.eye(4).tolist())
    columns = [finished(program.run(initial=start)).final for start in starts]
    return -float(np.log(np.max(np.abs(np.linalg.eigvals(np.column_stack(columns)))))) / duration


def _steady_amplitude(scene: Scene, rate: float) -> float:
    """Return the amplitude of x1 over one period after the transient."""
    period = excitation_of(scene).period({s.name: v for s, v in scene.parameter_values().items()})
    times = Schedule(period * ceil(log(1 / GONE) / (rate * period)), period, period)
    outputs = {"amplitude": HalfRange(scene.system.q[0])}
    return Settling(scene, times, outputs, tolerance=TOLERANCE).measured()["amplitude"]


def _response_curve(mass_ratio: float, tuned: theory.Tuned, places: list[float]) -> Curve:
    g = np.unique(np.concatenate([np.linspace(0.0, 2.0 * places[-1], 401), places]))
    y = theory.response(mass_ratio, *tuned[:2], g)
    highest = theory.peaks(mass_ratio, *tuned[:2])[0][1]
    marks = tuple(p for p in places if theory.response(mass_ratio, *tuned[:2], p) > highest * (1 - 1e-9))
    return Curve(g, y, highest, "frequency Omega/omega1", "amplitude |x1 k1/F|", marks)


def _rate_curve(label: str, tuned: theory.Tuned, rate: Callable[[float], float]) -> Curve:
    f = tuned.tuning * np.linspace(0.8, 1.2, 201)
    y = np.array([rate(e) for e in f])
    return Curve(f, y, float(np.max(y)), "tuning omega2/omega1", label, (tuned.tuning,))
