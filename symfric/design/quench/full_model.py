"""Verification of an averaged optimum: runs of the full model with slightly more and less excitation."""

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from symfric.design.comparison import Compared
from symfric.design.quench.belt_scene import AMPLITUDE, FREQUENCY, SPEED_NAME, Belt
from symfric.design.quench.feedback import averaging_error, measured
from symfric.design.quench.multipliers import MultiplierCheck, forced, prepare_map, probe
from symfric.design.quench.search import Optimum, QuenchProblem
from symfric.design.quench.worst_speed import SpeedPoint
from symfric.design.verification import Neighbour
from symfric.locks import SYMBOLIC, alone
from symfric.model.outputs import Integral, Output, friction_force
from symfric.solve.protocol import Program

NEAR = 12.0  # error of averaging: relative difference of the full model in units of (natural frequency/Omega)^2
AT = 1e-8  # relative distance from a limit at which the design is on it
OTHERS = 2  # further belt speeds at which the full model is run
BESIDE = 2e-3  # distance from a kink at which the full model is run, relative to the fast velocity


@dataclass(frozen=True)
class _Side:
    """A neighbouring excitation with its worst belt speed, and damping and friction of the averaged model there."""

    excitation: tuple[float, float]
    v_b: float
    damping: float
    friction: float


def checked(belt: Belt, problem: QuenchProblem, optimum: Optimum) -> MultiplierCheck:
    """Run the full model with a changed by 1 % plus the averaging error, and by more if that is still stable below."""
    a, Omega = problem.excitation(optimum.q)
    step = 0.01 + 4 * (belt.frequency / Omega) ** 2
    worst = (c.slack(problem.speeds.worst(optimum.regime, optimum.q, c.kind)[0].value) for c in problem.conditions[1:])
    bound = problem.followed and optimum.q <= problem.intensities[0] * (1 + AT)
    limited = min(worst, default=1.0) < AT or bound  # a limit is active: no instability is required below
    for _ in range(4):
        below = _side(belt, problem, ((1 - step) * a, Omega))
        if below.damping < 0 or problem.margin > 0 or limited or step > 0.2:
            break
        step *= 2
    excitation = ((1 + step) * a, Omega)
    above = [_side(belt, problem, excitation), *_others(belt, problem, excitation)]
    meters = _meters(belt, [c.kind for c in problem.conditions[1:]])
    program, duration = prepare_map(belt, (a, Omega), above[0].v_b, meters)
    probes = []
    for side in (*above, below):
        rest = belt.normal * side.friction / belt.stiffness
        rate = decay_rate(belt, side.damping)
        probes.append(probe(belt, program, duration, side.excitation, side.v_b, rest, rate))
    first, *more, less = probes
    at = replace(optimum, q=(1 + step) * optimum.q) if problem.followed and optimum.q == 1 else optimum  # 1 is a limit
    limits = _limited(belt, problem, at, program, duration, tuple(meters))
    if problem.followed:
        limits += measured(belt, problem, problem.values(at.q))
    return MultiplierCheck(step, (first,), (less,), limits, tuple(more))


def beside(belt: Belt, problem: QuenchProblem, optimum: Optimum, check: MultiplierCheck) -> list[Neighbour]:
    """Return the neighbours of an optimum within the bounds: one on the full model, the others on the averaged one."""
    q, (low, high), name = optimum.q, problem.intensities, problem.symbol.partition(" ")[0]
    neighbours = []
    for share in (1 - 1e-2, 1 - 1e-3, 1 - 1e-5, 1 + 1e-5, 1 + 1e-3):
        if low <= share * q <= high:
            regime = problem.speeds.regime_of(share * q)
            change = f"{name} {'larger' if share > 1 else 'smaller'} by {100 * abs(share - 1):.2g} %"
            miss = -problem.slack(regime, share * q)
            neighbours.append(Neighbour(change, problem.objective(regime, share * q), miss))
    least = (1 - check.step) * q
    (p,) = check.below
    if low <= least and problem.margin == 0 and p.status == "OK":
        change = f"{name} smaller by {100 * check.step:.3g} %, on the full model at v_b = {p.v_b:.6g}"
        cost = problem.objective(problem.speeds.regime_of(least), least)
        limited = max((-c.slack(_worst(problem, least, c.kind)) for c in problem.conditions[1:]), default=-1.0)
        neighbours.append(Neighbour(change, cost, max(-p.decay_rate / belt.frequency, limited)))
    return neighbours


def _worst(problem: QuenchProblem, q: float, kind: str) -> float:
    return problem.speeds.worst(problem.speeds.regime_of(q), q, kind)[0].value


@alone(SYMBOLIC)
def _meters(belt: Belt, kinds: list[str]) -> dict[str, Output]:
    """Return outputs: integrals of the friction force along the slip u - v_b and of the power of the excitation."""
    scene, (u,) = belt.scene, belt.scene.system.u
    (force,) = scene.system.force
    shaking = force - force.subs(scene.parameter(AMPLITUDE), 0)
    rubbing = sum(friction_force(c.name) * c.slip.diff(u) for c in scene.contacts)
    both = {"friction": Integral(rubbing), "power": Integral(shaking * u)}
    return {kind: both[kind] for kind in kinds}


def _limited(
    belt: Belt, problem: QuenchProblem, optimum: Optimum, program: Program, duration: float, kinds: tuple[str, ...]
) -> tuple[Compared, ...]:
    """Compare limited friction and power with the full model under the excitation at its finite frequency."""
    rows = []
    for kind in kinds:
        worst = problem.speeds.worst(optimum.regime, optimum.q, kind)[0]
        averaged = problem.speeds.averaged.inside if worst.inside else problem.speeds.averaged.outside
        rest = belt.normal * float(averaged(worst.v, problem.speeds.fast(optimum.q, worst.v))[2]) / belt.stiffness
        a, Omega = problem.at_speed(problem.excitation(optimum.q), worst.v)
        start = forced(belt, program, (a, Omega), worst.v, rest)
        mean = np.nan
        if np.all(np.isfinite(list(start.values()))):
            values = {SPEED_NAME: worst.v, AMPLITUDE: a, FREQUENCY: Omega}
            run = program.run(values=values, initial=start)
            mean = float(run[kind]) / duration if run.status == 0 else np.nan
        unit = belt.normal * belt.law(worst.v) if kind == "friction" else 1.0
        tolerance, size = NEAR * (belt.frequency / Omega) ** 2, 0.0
        if problem.followed:  # on slow belts, too
            fast = problem.speeds.fast(optimum.q, worst.v)
            tolerance = float(averaging_error(belt, Omega, fast))
            size = belt.normal * belt.law(worst.v) * fast if kind == "power" else 1.0
        words = {"friction": "share of the friction", "power": "mean power"}[kind]
        rows.append(Compared(f"{words} at v_b = {worst.v:.6g}", worst.value, mean / unit, tolerance, size))
    return tuple(rows)


def _fast(belt: Belt, excitation: tuple[float, float]) -> float:
    """Return the amplitude of the fast velocity of the linear oscillator."""
    a, Omega = excitation
    return belt.gain * a * Omega / abs(1 - (belt.frequency / Omega) ** 2)


def _others(belt: Belt, problem: QuenchProblem, excitation: tuple[float, float]) -> list[_Side]:
    """Return further belt speeds: the next local minima of the averaged damping, away from kinks."""
    speeds, q = problem.speeds, _fast(belt, excitation) / problem.top
    first, *rest = speeds.worst(speeds.regime_of(q), q)
    away = [first.v, *speeds.kinks_of(q)]
    if problem.followed:  # the damping may have one minimum only
        rest = [*rest, *(SpeedPoint(np.nan, v, q > 1) for v in np.linspace(speeds.low, speeds.high, 4)[1:])]

    def apart(p: SpeedPoint) -> bool:
        least = BESIDE * speeds.fast(q, p.v)
        return p.v > BESIDE * speeds.fast(q, speeds.high) and all(abs(p.v - e) > least for e in away)

    return [_at(problem, excitation, p.v, q) for p in list(filter(apart, rest))[:OTHERS]]


def _at(problem: QuenchProblem, excitation: tuple[float, float], v: float, q: float) -> _Side:
    averaged, fast = problem.speeds.averaged, problem.speeds.fast(q, v)
    damping, _, friction, _ = (averaged.inside if v < fast else averaged.outside)(v, fast)
    return _Side(problem.at_speed(excitation, v), float(v), float(damping), float(friction))


def _side(belt: Belt, problem: QuenchProblem, excitation: tuple[float, float]) -> _Side:
    """Return the worst belt speed under an excitation, away from kinks, where the full model would graze."""
    speeds = problem.speeds
    q = _fast(belt, excitation) / problem.top
    worst = max(speeds.worst(speeds.regime_of(q), q)[0].v, BESIDE * speeds.high if problem.followed else 0.0)
    beside, step = [worst], BESIDE * speeds.fast(q, worst)
    for kink in speeds.kinks_of(q):
        if abs(worst - kink) < step:
            beside = [min(max(kink + side * step, speeds.low), speeds.high) for side in (-1, 1)]
    return min((_at(problem, excitation, v, q) for v in beside), key=lambda s: s.damping)


def decay_rate(belt: Belt, damping: float) -> float:
    """Return the decay rate of ``m x'' + damping x' + k x = 0``."""
    half = damping / (2 * belt.mass)
    beyond = half**2 - belt.frequency**2
    return half - sqrt(beyond) if beyond > 0 and half > 0 else half + sqrt(max(beyond, 0.0)) * (1 if half > 0 else -1)
