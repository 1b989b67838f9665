"""The full model asked a little beside an optimum of the averaged one."""

from dataclasses import dataclass
from math import sqrt

from symfric.design.belt import Belt
from symfric.design.check import Check, prepare_map, probe
from symfric.design.search import Optimum, Problem

BESIDE = 2e-3  # of the fast velocity: distance from a kink at which the full model is asked


@dataclass(frozen=True)
class _Side:
    """An excitation beside the optimum and its worst belt speed; damping and friction of the averaged model there."""

    excitation: tuple[float, float]
    v_b: float
    damping: float
    friction: float


def checked(belt: Belt, problem: Problem, found: Optimum) -> Check:
    """Ask the full model with a changed by a step: 1 % and what averaging misses, more if nothing shows yet below."""
    a, Omega = problem.excitation(found.q)
    step = 0.01 + 4 * (belt.frequency / Omega) ** 2
    for _ in range(4):
        below = _side(belt, problem, ((1 - step) * a, Omega))
        if below.damping < 0 or problem.margin > 0 or step > 0.2:
            break
        step *= 2
    above = _side(belt, problem, ((1 + step) * a, Omega))
    program, duration = prepare_map(belt, (a, Omega), above.v_b)
    probes = []
    for side in (above, below):
        rest = belt.normal * side.friction / belt.stiffness
        rate = decay_rate(belt, side.damping)
        probes.append(probe(belt, program, duration, side.excitation, side.v_b, rest, rate))
    return Check(step, (probes[0],), (probes[1],))


def _side(belt: Belt, problem: Problem, excitation: tuple[float, float]) -> _Side:
    """Return the worst belt speed under an excitation, a little beside the kinks, where the full model grazes.

    At finite frequency the amplitude of the fast velocity is that of the linear oscillator, q/(1 - (omega/Omega)^2).
    """
    a, Omega = excitation
    speeds = problem.speeds
    q = belt.gain * a * Omega / abs(1 - (belt.frequency / Omega) ** 2)
    regime = "outside" if q <= speeds.low else "mixed" if q <= speeds.high else "inside"
    worst = speeds.worst(regime, q)[0].v
    beside = [worst]
    for kink in (abs(level + side * q) for level in speeds.averaged.levels for side in (-1, 1)):
        if abs(worst - kink) < BESIDE * q:
            beside = [min(max(kink + side * BESIDE * q, speeds.low), speeds.high) for side in (-1, 1)]
    found = []
    for v in beside:
        damping, _, friction, _ = (speeds.averaged.inside if v < q else speeds.averaged.outside)(v, q)
        found.append((float(damping), float(v), float(friction)))
    damping, v, friction = min(found)
    return _Side(excitation, v, damping, friction)


def decay_rate(belt: Belt, damping: float) -> float:
    """Return the decay rate of ``m x'' + damping x' + k x = 0``."""
    half = damping / (2 * belt.mass)
    beyond = half**2 - belt.frequency**2
    return half - sqrt(beyond) if beyond > 0 and half > 0 else half + sqrt(max(beyond, 0.0)) * (1 if half > 0 else -1)
