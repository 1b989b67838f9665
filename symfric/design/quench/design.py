"""The smallest fast excitation that prevents self-excited vibration of a mass on a belt."""

import itertools
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from symfric.design.quench.averaged_damping import average_belt
from symfric.design.quench.belt_scene import AMPLITUDE, FREQUENCY, SPEED_NAME, Belt, read_belt
from symfric.design.quench.feedback import with_feedback
from symfric.design.quench.finite_frequency import corrected
from symfric.design.quench.followed_speeds import FollowedSpeeds
from symfric.design.quench.full_model import beside, checked, decay_rate
from symfric.design.quench.limits import missing, read_limits
from symfric.design.quench.multipliers import MultiplierCheck, prepare_map, probe
from symfric.design.quench.search import Optimum, QuenchProblem, search
from symfric.design.quench.worst_speed import SHARES, SpeedRange, evaluated
from symfric.design.result import Curve, Design
from symfric.design.verification import BEST_FOUND, Interrupted, Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.arguments import flag, is_one_of
from symfric.model.scene import Scene
from symfric.model.symbols import finite, nearest, pair, positive, shortened

OBJECTIVES = ("intensity", "power", "force")
ACTIVE = 1e-8  # slack relative to the condition's size up to which it counts as active
FAST = 3.0  # least excitation frequency in natural frequencies; below, fast and slow motion do not separate
NONE_NEEDED = "no excitation needed"


@logged
def quench(
    scene: Scene,
    speeds: tuple[float, float],
    *,
    Omega: tuple[float, float],
    a: tuple[float, float],
    minimise: Literal["intensity", "power", "force"] = "intensity",
    margin: float = 0.0,
    limits: Mapping[str, float] | None = None,
    follow: bool = False,
    k: tuple[float, float] | None = None,
) -> Design:
    r"""Find the smallest excitation :math:`a\Omega^2\sin\Omega t` that keeps steady sliding stable.

    Parameters
    ----------
    scene : Scene
        One mass on a linear spring and damper, a contact with slip ``u - v_b`` or several, of any laws and constant
        loads (pads on one disc: what they rub with adds up), and a harmonic force that shakes it with velocity a Omega:
        `symfric.scenes.mass_on_belt` or one like it with parameters v_b, a and Omega. Its own values of these three are
        not used.
    speeds : (float, float)
        Lowest and highest belt speed, 0 <= low <= high > 0.
    Omega, a : (float, float)
        Bounds of frequency (at least 3 natural frequencies) and amplitude (>= 0).
    minimise : {"intensity", "power", "force"}
        ``a Omega``; the largest mean power over the belt speeds; ``a Omega^2``.
    margin : float
        Least damping ``c + N mubar'`` of the slow motion, >= 0, in the units of c; 0 is the limit of stability.
    limits : mapping of str to float, optional
        Any of "friction": least share, 0 to 1, of the friction without excitation that must be left as the mean at
        every belt speed of the range (a brake must still brake); "acceleration": largest ``a Omega^2``, in the units
        of a times those of Omega squared; "power": largest mean power at any belt speed of the range, in the units of
        c times a squared times Omega squared, as `minimise` has it.
    follow : bool
        Let the intensity follow the measured belt speed, ``a Omega = k v_b`` with one k for all speeds; `a` then bounds
        the amplitude at the highest speed, from 0.
    k : (float, float), optional
        Bounds of k where it follows, from 0 to infinity unless given; one above 1 is needed on slow belts, and how far
        above, the error of the measured speed decides.

    Returns
    -------
    Design
        With values "a" and "Omega"; "k" and "Omega" where the excitation follows the belt speed ("k_v" if the scene has
        a k), then with a scene in which it does and the objective at the highest speed. Where several reach the
        optimum, the one of least force: the lowest frequency.
        Its status is "infimum" if the damping jumps there: any larger intensity satisfies the condition, this one
        does not. `corrected` holds the amplitude at which the forced motion of the full model is as stable as asked for
        at the belt speeds that decide, whatever the limits; None where it sticks or touches zero slip. With limits on
        friction or power the check holds what the full model leaves and spends at the optimum.

    Raises
    ------
    SceneError
        If the scene is another one, or an argument is wrong.
    NotFound
        If no excitation within the bounds and limits does it; names the one that comes closest, its worst belt speed
        and the damping that is missing, or, if the limits are in the way, which of them and by how much.

    Notes
    -----
    On the averaged model: ``N mubar'(v; q) + c >= margin`` for every v in `speeds`, Thomsen (52), with the effective
    friction (41) and q = a Omega; (56)-(58) are its solutions for the cubic law. Averaging needs Omega far above the
    natural frequency: the lower bound of Omega is where the user says what far is, and the check what comes of it.
    The mean power is that of ``x' = q cos``, see `symfric.theory.belt.mean_power`; Thomsen (59) is the kinetic energy.
    The mean friction is (41) too; on a belt at rest fast vibration leaves none of it, so that a limit on the friction
    asks for a lowest belt speed above 0, unless the excitation follows the speed: Thomsen, section 5.4, proposes a
    Omega slightly larger than v_b, which leaves most of the friction. A k above 1 makes the slip reverse at every
    speed, and there the damping jumps: hence "infimum" at k = 1. The check lets the belt run through its speeds,
    measures them, and shakes with what is measured.
    The condition is local: large stick-slip cycles beside a stable sliding are not excluded, and no motion is started
    far out. Several masses are not taken, though `symfric.separate` gives their slow scene: there the fast slip of each
    contact has its own amplitude, and stability is no longer the sign of one damping but of eigenvalues.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2)
    >>> found = sf.design.quench(scene, (0.05, 0.4), Omega=(50, 50), a=(0, 0.01), follow=True, k=(1.05, 2.0))
    >>> {name: round(value, 4) for name, value in found.values.items()}
    {'k': 1.05, 'Omega': 50.0}
    """
    flag(follow, "follow")
    belt = read_belt(scene)
    problem = _problem(belt, speeds, Omega, a, minimise, margin, limits, _ratios(follow, k))
    still = _unshaken(problem.speeds)
    if problem.intensities[0] == 0 and still[0] >= problem.margin:
        return _idle(belt, problem, still)
    tell("the optimum of the averaged model")
    optimum = search(problem)
    if not isinstance(optimum, Optimum):
        raise NotFound(missing(problem, still))
    tell("verification on the full model")
    return _design(belt, problem, optimum)


def _ratios(follow: bool, k: tuple[float, float] | None) -> tuple[float, float] | None:
    """Return the bounds of k, None if the excitation does not follow the belt speed."""
    if k is not None and not follow:
        raise SceneError("k = a*Omega/v_b is given; it belongs to follow=True")
    if not follow:
        return None
    if k is None:
        return 0.0, np.inf
    low, high = k if isinstance(k, tuple | list) and len(k) == 2 else (k, None)
    if high == np.inf:
        high = np.finfo(float).max
    return _bounds((low, high), "k")


def _problem(
    belt: Belt,
    speeds: Any,
    Omega: Any,
    a: Any,
    minimise: str,
    margin: float,
    limits: Mapping[str, float] | None,
    ratios: tuple[float, float] | None,
) -> QuenchProblem:
    """Check the arguments of `quench` and build the averaged model."""
    if not is_one_of(minimise, OBJECTIVES):
        raise SceneError(f"no objective {shortened(minimise)}{nearest(str(minimise), OBJECTIVES)}")
    low, high = _bounds(speeds, "speeds")
    if not high > 0:
        raise SceneError("the highest of the speeds is 0; a belt at rest excites no vibration")
    Omega, a = _bounds(Omega, "Omega"), _bounds(a, "a")
    if not Omega[0] > 0:
        raise SceneError(f"Omega is {Omega}; its lower bound must be positive, and far above the natural frequency")
    if not a[1] > 0:
        raise SceneError(f"a is {a}; its upper bound must be positive")
    margin = positive(margin, "margin", zero=True)
    if Omega[0] < FAST * belt.frequency:
        raise SceneError(
            f"the lower bound of Omega is {Omega[0]:g}; fast vibration needs at least {FAST:g} times the natural "
            f"frequency {belt.frequency:.6g}, and the averaged model becomes exact far above it"
        )
    limits = read_limits(limits)
    if "friction" in limits:
        least = min(np.linspace(low, high, 200)[low == 0 :], key=belt.law)
        if not belt.law(least) > 0:
            raise SceneError(f"without excitation there is no friction at v_b = {least:.6g}, so no share of it to keep")
    averaged = average_belt(belt, (low, high), belt.gain * a[1] * Omega[1])
    if ratios is None:
        return QuenchProblem(SpeedRange(averaged, low, high), belt.gain, minimise, Omega, a, margin, limits)
    if a[0] > 0:
        raise SceneError(f"the lower bound of a is {a[0]:g}; the amplitude follows the belt speed, so give 0")
    ratios = belt.gain * ratios[0], belt.gain * ratios[1]
    speeds = FollowedSpeeds(averaged, low, high)
    problem = QuenchProblem(speeds, belt.gain, minimise, Omega, a, margin, limits, high, ratios, belt.ratio)
    if problem.intensities[0] > problem.intensities[1]:
        raise SceneError(
            f"k is at least {ratios[0] / belt.gain:g}, but a and Omega within their bounds and limits reach only "
            f"{problem.intensities[1] / belt.gain:.6g} at v_b = {high:g}"
        )
    return problem


def _bounds(given: tuple[float, float | None], name: str) -> tuple[float, float]:
    low, high = (finite(e, f"a bound of {name}") for e in pair(given, name))
    if low < 0:
        raise SceneError(f"the lower bound of {name} is {low:g}; it must not be negative")
    if low > high:
        raise SceneError(f"{name} is ({low:g}, {high:g}); the lower bound comes first")
    return low, high


def _unshaken(speeds: SpeedRange | FollowedSpeeds) -> tuple[float, float]:
    """Return the least damping without excitation and the belt speed of it."""
    edges = [speeds.low, *(b for b in speeds.averaged.levels if speeds.low < b < speeds.high), speeds.high]
    parts: list[np.ndarray] = []
    for a, b in itertools.pairwise(edges):
        inside = np.array([np.nextafter(b, a)])  # the slope jumps at a break
        parts += [a + (b - a) * SHARES, np.linspace(a, b, 200), inside]
    v = np.concatenate(parts)
    y = np.array(speeds.averaged.unshaken(v[None])).ravel()
    k = int(np.argmin(y))
    return float(y[k]), float(v[k])


def _idle(belt: Belt, problem: QuenchProblem, still: tuple[float, float]) -> Design:
    """Return the design without excitation."""
    speeds, Omega = problem.speeds, problem.Omega[0]
    v = np.linspace(0.0, 1.3 * speeds.high, 201)[1:]
    curve = _curve(problem, v, np.array(speeds.averaged.unshaken(v[None])).ravel(), ())
    at = still[1] if still[1] > 0 else 0.01 * speeds.high  # a belt at rest has no sliding state to verify
    rest = belt.normal * belt.law(at) / belt.stiffness
    damping = float(speeds.averaged.unshaken(at))
    program, duration = prepare_map(belt, (0.0, Omega), at)
    seen = probe(belt, program, duration, (0.0, Omega), at, rest, decay_rate(belt, damping))
    values = problem.values(0.0)
    scene = _placed(belt, problem, values, at)
    around = [Neighbour("any excitation", float(np.nextafter(0, 1)), 0.0)]
    check = MultiplierCheck(0.0, (seen,), ())
    return design(values, 0.0, (NONE_NEEDED,), scene, check, curve, claim="optimal", neighbours=around)


def _design(belt: Belt, problem: QuenchProblem, optimum: Optimum) -> Design:
    excitation = problem.excitation(optimum.q)
    speeds = problem.speeds
    worst = speeds.worst(optimum.regime, optimum.q)
    near = problem.margin + ACTIVE * speeds.averaged.scale
    marks = [p.v for p in worst if p.value <= near]
    limit = _at_a_jump(problem, optimum)
    if limit:
        marks += [p.v for p in speeds.worst("outside", 1.0)[:1]] if problem.followed else [speeds.high]
    marks = sorted(set(marks))
    active = [f"damping at v_b = {v:.6g}" for v in marks]
    if problem.minimise == "power" and speeds.low < speeds.high:
        active.append(f"mean power largest at v_b = {speeds.worst(optimum.regime, optimum.q, 'power')[0].v:.6g}")
    active += _on_limits(problem, optimum)
    active += _on_bounds(*_bounded(problem, optimum))
    values = problem.values(optimum.q)
    scene = _placed(belt, problem, values, marks[0] if marks else worst[0].v)
    claim = "infimum" if limit else "optimal"
    curve = _along(problem, optimum.q, tuple(marks))
    with until_interrupted("quench"):
        check = checked(belt, problem, optimum)
        better = None if problem.followed else _corrected(belt, problem, excitation, marks)
        around = beside(belt, problem, optimum, check)
        return design(
            values, optimum.objective, active, scene, check, curve, claim=claim, neighbours=around, corrected=better
        )
    return design(values, optimum.objective, active, scene, Interrupted(), curve, claim=BEST_FOUND, neighbours=())


def _corrected(
    belt: Belt, problem: QuenchProblem, excitation: tuple[float, float], marks: list[float]
) -> dict[str, float] | None:
    """Return the excitation with the largest of the amplitudes that the full model requires at the active speeds."""
    a, Omega = excitation
    averaged, q, required = problem.speeds.averaged, belt.gain * a * Omega, []
    for v in (v for v in marks if v > 0):
        friction = float((averaged.inside if v < q else averaged.outside)(v, q)[2])
        required.append(corrected(belt, excitation, v, belt.normal * friction / belt.stiffness, problem.margin))
    amplitudes = [e for e in required if e is not None]
    if not required or len(amplitudes) < len(required):
        return None
    return {AMPLITUDE: max(amplitudes), FREQUENCY: Omega}


def _on_limits(problem: QuenchProblem, optimum: Optimum) -> list[str]:
    """Return the limits that hold with equality."""
    a, Omega = problem.excitation(optimum.q)
    active = []
    for c in problem.conditions[1:]:
        worst = problem.speeds.worst(optimum.regime, optimum.q, c.kind)[0]
        if c.slack(worst.value) <= ACTIVE:
            active.append(f"limit on the {c.kind} at v_b = {worst.v:.6g}")
    largest = problem.limits.get("acceleration", np.inf)
    return [*active, "limit on the acceleration"] if a * Omega**2 >= largest * (1 - ACTIVE) else active


def _on_bounds(*variables: tuple[str, float, tuple[float, float]]) -> list[str]:
    sides = ((0, "lower"), (1, "upper"))
    return [
        f"{name} at its {word} bound"
        for name, value, bounds in variables
        for k, word in sides
        if abs(value - bounds[k]) <= 1e-9 * min(bounds[1], max(value, bounds[0]))
    ]


def _bounded(problem: QuenchProblem, optimum: Optimum) -> list[tuple[str, float, tuple[float, float]]]:
    """Return name, value and bounds of the design parameters, and of the amplitude at the highest speed."""
    a, Omega = problem.excitation(optimum.q)
    both = [(AMPLITUDE, a, problem.a), (FREQUENCY, Omega, problem.Omega)]
    return [*both, (problem.ratio, optimum.q, problem.ratios)] if problem.followed else both


def _at_a_jump(problem: QuenchProblem, optimum: Optimum) -> bool:
    """Whether the damping jumps at an optimum, so that only a larger excitation satisfies the condition."""
    edge, before = (1.0, "outside") if problem.followed else (problem.speeds.high, "mixed")
    return optimum.regime == "inside" and optimum.q == edge and problem.slack(before, optimum.q) < 0


def _placed(belt: Belt, problem: QuenchProblem, values: dict[str, float], v_b: float) -> Scene:
    """Return the scene with the designed values, and with v_b if it has no belt speed yet."""
    scene = with_feedback(belt) if problem.followed else belt.scene
    missing = scene.values[scene.parameter(SPEED_NAME)] is None
    return scene.where({**values, SPEED_NAME: v_b} if missing else values)


def _along(problem: QuenchProblem, q: float, marks: tuple[float, ...]) -> Curve:
    """Return the curve of the damping over the belt speeds, slightly beyond their range."""
    averaged = problem.speeds.averaged
    if problem.followed:
        speeds = np.linspace(0.0, 1.3 * problem.speeds.high, 401)[1:]
        return _curve(problem, speeds, evaluated(averaged, q > 1, speeds, q * speeds)["damping"], marks)
    v, y, gap = [], [], np.array([np.nan])
    for inside, low, high in ((True, 0.0, q), (False, q, 1.3 * max(q, problem.speeds.high))):
        part = np.unique(np.concatenate([low + (high - low) * SHARES, np.linspace(low, high, 101)]))
        part = part[part < q] if inside else part
        v += [part, gap]
        y += [evaluated(averaged, inside, part, np.full(part.shape, q))["damping"], gap]
    return _curve(problem, np.concatenate(v), np.concatenate(y), marks)


def _curve(problem: QuenchProblem, v: np.ndarray, y: np.ndarray, marks: tuple[float, ...]) -> Curve:
    return Curve(v, y, problem.margin, "speed v_b", "damping of the slow motion", marks)
