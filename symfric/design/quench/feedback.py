"""Excitation whose intensity follows the measured belt speed, and its verification while the belt changes its speed."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from symfric.design.comparison import Compared
from symfric.design.quench.belt_scene import AMPLITUDE, FREQUENCY, SPEED_NAME, Belt
from symfric.design.quench.search import QuenchProblem
from symfric.locks import SYMBOLIC, alone
from symfric.model.outputs import Integral, OutputOfExpression, friction_force
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME
from symfric.solve.routes import simulate

CYCLES = 16  # natural periods in which the belt runs from its lowest speed to the highest and back
NODES = 400  # of the quadrature over the speeds
SLOWEST = 0.05  # lowest speed of the run, relative to the highest: the belt does not stand still
TOLERANCE = 1e-9  # of the run
LAG = 0.1  # time constant of the measurement in natural periods over 2 pi
NEAR = 12.0  # error of averaging: relative difference of the full model in units of (natural frequency/Omega)^2
RUBBED = 6.0  # the same in units of the square of the fast velocity that friction takes away, over the fast velocity
SLOW = 0.02  # error of the mean friction because the speed changes in a finite time


@alone(SYMBOLIC)
def with_feedback(belt: Belt) -> Scene:
    """Return the scene with ``a = k v_b/Omega``: the parameter k in the place of the amplitude a."""
    scene, k = belt.scene, sp.Symbol(belt.ratio, real=True)
    a, Omega, v_b = (scene.parameter(name) for name in (AMPLITUDE, FREQUENCY, SPEED_NAME))
    return _exchanged(scene, {a: k * v_b / Omega}, {s: v for s, v in scene.values.items() if s != a} | {k: None})


def _exchanged(scene: Scene, by: Mapping[sp.Symbol, sp.Expr], values: Mapping[sp.Symbol, Any]) -> Scene:
    """Return the scene with symbols replaced in forces, contacts, start and outputs."""
    system = replace(scene.system, force=[e.subs(by) for e in scene.system.force])
    contacts = tuple(
        replace(c, slip=c.slip.subs(by), normal=sp.sympify(c.normal).subs(by), profile=sp.sympify(c.profile).subs(by))
        for c in scene.contacts
    )
    initial = {s: sp.sympify(v).subs(by) for s, v in scene.initial.items()}
    outputs = {
        name: replace(o, expr=o.expr.subs(by)) if isinstance(o, OutputOfExpression) else o
        for name, o in scene.outputs.items()
    }
    return replace(scene, system=system, contacts=contacts, values=values, initial=initial, outputs=outputs)


@alone(SYMBOLIC)
def _running(belt: Belt, values: dict[str, float], low: float, high: float, rest: float) -> Scene:
    """Return the scene with a belt that runs from low to high and back, and a sensor that lags behind it.

    It starts with the slow position `rest` of steady sliding.
    """
    duration = 2 * np.pi * CYCLES / belt.frequency
    scene = belt.scene
    a, Omega, v_b = (scene.parameter(name) for name in (AMPLITUDE, FREQUENCY, SPEED_NAME))
    seen = sp.Symbol("measured", real=True)
    speed = low + (high - low) * sp.sin(sp.pi * TIME / duration) ** 2
    force = [
        e.subs({a: values[belt.ratio] * seen / values[FREQUENCY], Omega: values[FREQUENCY]}) for e in scene.system.force
    ]
    follows = (speed - seen) * belt.frequency / LAG
    system = replace(scene.system, force=force, z=(seen,), z_rate=(follows,))
    contacts = [replace(c, slip=c.slip.subs(v_b, speed)) for c in scene.contacts]
    (x,), (u,) = scene.system.q, scene.system.u
    fast = belt.fast_start(values[belt.ratio] * low / values[FREQUENCY], values[FREQUENCY])
    rubbing = sum(friction_force(c.name) * c.slip.diff(u) for c in scene.contacts)
    return Scene(
        system,
        contacts,
        {s: v for s, v in scene.values.items() if s not in (a, Omega, v_b)},
        {x: rest + fast[0], u: fast[1], seen: low},
        duration,
        {"friction": Integral(rubbing)},
    )


def _at_rest(belt: Belt) -> float:
    return float(belt.law.kinetic.subs(SPEED, 0))


@alone(SYMBOLIC)
def averaging_error(belt: Belt, Omega: float, q: Any) -> Any:
    """Return the relative error of averaging at fast slips q: it falls with Omega^2, and grows on slow belts.

    Friction of the size N mu(0) changes the fast velocity by N mu(0)/(m Omega), no longer little where q is small.
    """
    rubbed = belt.normal * _at_rest(belt) / (belt.mass * Omega * q)
    return NEAR * (belt.frequency / Omega) ** 2 + RUBBED * rubbed**2


def measured(belt: Belt, problem: QuenchProblem, values: dict[str, float]) -> tuple[Compared, ...]:
    """Compare the mean friction of a run through the speeds, with measured speed, with the averaged model."""
    speeds = problem.speeds
    low, high = max(speeds.low, SLOWEST * speeds.high), speeds.high
    phase = (np.arange(NODES) + 0.5) / NODES * np.pi
    v = low + (high - low) * np.sin(phase) ** 2
    ratio = belt.gain * values[belt.ratio] / abs(1 - (belt.frequency / values[FREQUENCY]) ** 2)
    averaged = speeds.averaged.inside if ratio > 1 else speeds.averaged.outside
    friction = np.array(averaged(v[None], ratio * v[None])[2]).ravel()
    rest = belt.normal * float(averaged(low, ratio * low)[2]) / belt.stiffness
    run = simulate(_running(belt, values, low, high, rest), TOLERANCE)
    computed = float(run["friction"]) / run.t_final / belt.normal if run.status == 0 else np.nan
    tolerance = SLOW + float(np.mean(averaging_error(belt, values[FREQUENCY], ratio * v)))
    words = f"mean friction while the belt runs from {low:.5g} to {high:.5g} and back, excitation by the measured speed"
    return (Compared(words, float(friction.mean()), computed, tolerance, size=_at_rest(belt)),)
