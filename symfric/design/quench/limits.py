"""Limits of a quench on friction, acceleration and power, and the message if they cannot be met."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from symfric.design.quench.search import Optimum, QuenchProblem, edge, grid_of, refined, search
from symfric.errors import SceneError
from symfric.model.symbols import nearest, positive, shortened
from symfric.search import minimum

LIMITS = ("friction", "acceleration", "power")
QUANTITY = {"acceleration": "acceleration", "power": "mean power"}


def read_limits(limits: Mapping[str, float] | None) -> dict[str, float]:
    """Return the limits of `symfric.design.quench.design` as numbers.

    Raises
    ------
    SceneError
        If one is unknown or out of range.
    """
    if limits is None:
        return {}
    if not isinstance(limits, Mapping):
        raise SceneError(
            f"limits is {shortened(limits)}; write a dict such as {{'friction': 0.5, 'acceleration': 50.0}}"
        )
    numbers = {}
    for name, value in limits.items():
        if name not in LIMITS:
            raise SceneError(f"no limit {name!r}{nearest(str(name), LIMITS)}")
        numbers[name] = positive(value, f"the limit on the {name}")
    if numbers.get("friction", 0.0) > 1:
        raise SceneError(
            f"the limit on the friction is {numbers['friction']:g}; it is the remaining fraction, at most 1"
        )
    return numbers


def missing(problem: QuenchProblem, still: tuple[float, float]) -> str:
    """Return a message: no excitation meets the conditions, which comes closest and by how much it fails.

    Parameters
    ----------
    problem : QuenchProblem
        Without a solution.
    still : (float, float)
        The least damping without excitation and its belt speed.
    """
    stable = replace(problem, limits={})
    answer = search(stable)
    if isinstance(answer, Optimum):
        return _beyond_limits(problem, stable)
    return _unstable(stable, answer, still)


def _unstable(problem: QuenchProblem, closest: tuple[float, str], still: tuple[float, float]) -> str:
    q, regime = closest
    point = problem.speeds.worst(regime, q)[0] if q > 0 else None
    damping, v = (point.value, point.v) if point else still
    if problem.a[0] == 0 and still[0] >= damping:
        q, (damping, v) = 0.0, still
    low, high = (e / problem.gain for e in problem.intensities)
    short, symbol = problem.margin - damping, problem.symbol
    return (
        f"no excitation with {symbol} from {low:.6g} to {high:.6g} keeps sliding stable at every belt speed from "
        f"{problem.speeds.low:g} to {problem.speeds.high:g}: the one that comes closest, "
        f"{symbol.partition(' ')[0]} = {q / problem.gain:.6g}, leaves the damping at v_b = {v:.6g} short by "
        + (f"{short:.6g}" if np.isfinite(short) else "any amount, because the friction falls there with infinite slope")
    )


def _beyond_limits(problem: QuenchProblem, stable: QuenchProblem) -> str:
    q, regime = _least_excess(problem, stable)
    a, Omega = problem.excitation(q)
    seen = {kind: problem.speeds.worst(regime, q, kind)[0] for kind in problem.limits if kind != "acceleration"}
    words = []
    for kind, limit in problem.limits.items():
        value = a * Omega**2 if kind == "acceleration" else limit * round(seen[kind].value / limit, 12)
        over, at = abs(value - limit), "" if kind == "acceleration" else f" at v_b = {seen[kind].v:.6g}"
        if kind == "friction" and value < limit:
            words.append(f"it leaves {value:.9g} of the friction{at}, short of {limit:g} by {over:.9g}")
        if kind != "friction" and value > limit:
            words.append(f"its {QUANTITY[kind]} {value:.9g}{at} is above the limit {limit:g} by {over:.9g}")
    words_of = " and ".join(f"{name} = {value:.6g}" for name, value in problem.values(q).items())
    return (
        f"no excitation within the bounds and limits keeps sliding stable at every belt speed from "
        f"{problem.speeds.low:g} to {problem.speeds.high:g}: of those that do, {words_of} "
        f"comes closest; {', and '.join(words)}"
    )


def _excess(problem: QuenchProblem, q: Any, values: Mapping[str, Any]) -> np.ndarray:
    """Return the largest relative excess over a limit, for arrays of q and of worst values."""
    q = np.atleast_1d(q)
    parts = []
    for kind, limit in problem.limits.items():
        if kind == "acceleration":
            products = [np.prod(problem.excitation(e)) * problem.excitation(e)[1] for e in q]
            parts.append(np.array(products) / limit - 1)
        else:
            parts.append((1.0 if kind == "power" else -1.0) * (np.atleast_1d(values[kind]) / limit - 1))
    return np.array(np.max(parts, axis=0))


def _least_excess(problem: QuenchProblem, stable: QuenchProblem) -> tuple[float, str]:
    """Return, among intensities with stable sliding, the one that exceeds the limits least, and its regime."""

    def excess(regime: str, q: float) -> float:
        values = {k: problem.speeds.worst(regime, q, k)[0].value for k in problem.limits if k != "acceleration"}
        return float(_excess(problem, q, values)[0])

    candidates = []
    for regime, ends in stable.speeds.regimes(*stable.intensities).items():
        q = grid_of(*ends)
        q = q[q > 0]
        slack = stable.conditions[0].slack(stable.speeds.scan(regime, q)["damping"])
        q, slack, _ = refined(stable, regime, q, slack, slack)
        good = slack >= 0
        edges = [
            edge(stable, regime, *((q[k], q[k + 1]) if good[k] else (q[k + 1], q[k])))
            for k in np.flatnonzero(good[1:] != good[:-1])
        ]
        q = np.unique(np.concatenate([q[good], edges]))
        if not q.size:
            continue
        rough = _excess(problem, q, stable.speeds.scan(regime, q))
        k = int(np.argmin(rough))
        candidates.append((excess(regime, float(q[k])), float(q[k]), regime))
        sides = q[max(k - 1, 0)], q[min(k + 1, q.size - 1)]
        if sides[0] < sides[1] and all(stable.slack(regime, float(e)) >= 0 for e in sides):
            best = minimum(partial(excess, regime), *sides, xatol=1e-10 * sides[1])
            candidates.append((best.value, best.place, regime))
    return min(candidates)[1:]
