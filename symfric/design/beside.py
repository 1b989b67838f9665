"""The full model asked a little beside an optimum of the averaged one."""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from symfric.design.belt import AMPLITUDE, FREQUENCY, SPEED_NAME, Belt
from symfric.design.check import Check, forced, prepare_map, probe
from symfric.design.compared import Compared
from symfric.design.search import Optimum, Problem
from symfric.model.outputs import Integral, Output, friction_force
from symfric.solve.choose import Program

NEAR = 12.0  # times (natural frequency over Omega)^2: relative difference of the full model that averaging explains
AT = 1e-8  # of a limit: so near to it the design is at it
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
    worst = (c.slack(problem.speeds.worst(found.regime, found.q, c.kind)[0].value) for c in problem.conditions[1:])
    limited = min(worst, default=1.0) < AT  # then nothing need show below
    for _ in range(4):
        below = _side(belt, problem, ((1 - step) * a, Omega))
        if below.damping < 0 or problem.margin > 0 or limited or step > 0.2:
            break
        step *= 2
    above = _side(belt, problem, ((1 + step) * a, Omega))
    meters = _meters(belt, [c.kind for c in problem.conditions[1:]])
    program, duration = prepare_map(belt, (a, Omega), above.v_b, meters)
    probes = []
    for side in (above, below):
        rest = belt.normal * side.friction / belt.stiffness
        rate = decay_rate(belt, side.damping)
        probes.append(probe(belt, program, duration, side.excitation, side.v_b, rest, rate))
    return Check(step, (probes[0],), (probes[1],), _limited(belt, problem, found, program, duration, tuple(meters)))


def _meters(belt: Belt, kinds: list[str]) -> dict[str, Output]:
    """Return the integrals of the friction, along the slip u - v_b, and of the power of the excitation."""
    scene, (u,) = belt.scene, belt.scene.system.u
    (force,) = scene.system.force
    shaking = force - force.subs(scene.parameter(AMPLITUDE), 0)
    rubbing = sum(friction_force(c.name) * c.slip.diff(u) for c in scene.contacts)
    both = {"friction": Integral(rubbing), "power": Integral(shaking * u)}
    return {kind: both[kind] for kind in kinds}


def _limited(
    belt: Belt, problem: Problem, found: Optimum, program: Program, duration: float, kinds: tuple[str, ...]
) -> tuple[Compared, ...]:
    """Return what the limits on friction and power speak of beside the full model, forced at its finite frequency."""
    a, Omega = problem.excitation(found.q)
    rows = []
    for kind in kinds:
        worst = problem.speeds.worst(found.regime, found.q, kind)[0]
        averaged = problem.speeds.averaged.inside if worst.inside else problem.speeds.averaged.outside
        rest = belt.normal * float(averaged(worst.v, found.q)[2]) / belt.stiffness
        start = forced(belt, program, (a, Omega), worst.v, rest)
        mean = np.nan
        if np.all(np.isfinite(list(start.values()))):
            values = {SPEED_NAME: worst.v, AMPLITUDE: a, FREQUENCY: Omega}
            run = program.run(values=values, initial=start)
            mean = float(run[kind]) / duration if run.status == 0 else np.nan
        unit = belt.normal * belt.law(worst.v) if kind == "friction" else 1.0
        tolerance = NEAR * (belt.frequency / Omega) ** 2 * min(1.0, abs(worst.value))
        words = {"friction": "share of the friction", "power": "mean power"}[kind]
        rows.append(Compared(f"{words} at v_b = {worst.v:.6g}", worst.value, mean / unit, tolerance))
    return tuple(rows)


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
