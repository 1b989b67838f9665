"""One step of the event loop in lanes: its length, its acceptance, and the state at its end."""

import math
from collections.abc import Sequence

import numpy as np

from symfric.codegen.elementwise import bits_of, choose, larger, smaller
from symfric.codegen.lane_values import Value, moves
from symfric.solve.lanes.kernel import Kernel, Row
from symfric.solve.lanes.wanted_rows import extended
from symfric.solve.loop import statements
from symfric.solve.loop.precision import EPS, STRETCH, TINY
from symfric.solve.loop.statements import CUT, INFINITE, NOTHING, ONE, PART, SLACK, logarithm
from symfric.solve.loop.stepping.decay_weights import LONGEST, PREFERRED, weights


def lengths(kernel: Kernel, c: Sequence[Row]) -> tuple[Sequence[Row], Value, Value, Value]:
    """Return the rows, how long a step is, how far guards are looked at, and whether the run ends with it."""
    v, n = kernel.v, kernel.plan.order
    limit = logarithm(kernel.plan.tolerance)
    h = _size(kernel, c, n, limit, limit)
    if kernel.plan.exact:
        c, h = _weighted(kernel, c, h)
    left = (v["end"] - v["t"]) - v["t_low"]
    last = h * STRETCH >= left
    far = choose(last, left, h * STRETCH)
    h = choose(last, left, h)
    kernel.require(last | (h > 2.0 * EPS * abs(v["t"])))
    kernel.require((v["t"] < v["end"]) & (v["steps"] < v["mark_steps"]))
    return c, h, far, last


def _weighted(kernel: Kernel, c: Sequence[Row], h: Value) -> tuple[Sequence[Row], Value]:
    """Return the rows and the length of a step with weighted coefficients in lanes where that is longer."""
    g, plan = kernel.g, kernel.plan
    last, damping = plan.exact + 2, weights(plan.order)
    limits = (logarithm(plan.tolerance / (1.0 - float(damping[k]))) for k in (last, last - 1))
    longer = _size(kernel, c, last, *limits)
    use = longer > PREFERRED * h
    weighted = lambda k, e: choose(use, g.rounded(g.mul(e, float(damping[k]))), e)  # noqa: E731
    c = [[*row[: last - 1], *(weighted(k, e) for k, e in enumerate(row) if k > plan.exact)] for row in c]
    return c, choose(use, smaller(longer, LONGEST * h), h)


def _size(kernel: Kernel, c: Sequence[Row], n: int, limit: int, limit_below: int) -> Value:
    """Return the step at which the terms of an order and of the one below are within their limits."""
    v, plan = kernel.v, kernel.plan
    grain = EPS / plan.tolerance
    top: Value = None
    worst: list[Value] = [None, None]
    for r, row in enumerate(c):
        ends = [row[n], row[n - 1]]
        if not any(moves(e) for e in ends):
            continue
        a = [bits_of(abs(e)) for e in ends if moves(e)]
        most = a[0] if len(a) == 1 else larger(*a)
        top = most if top is None else larger(top, most)
        scale = statements.largest_of_row(v[f"scale{r}"], row[1], v["h_last"], grain, abs(row[0]))
        if kernel.exposed and plan.n_x <= r < plan.n_x + plan.n_g:
            near = statements.largest_of_row(abs(row[0]), row[1], v["h_last"], grain, scale)
            scale = choose(kernel.fresh(r - plan.n_x), scale, near)
        ends_early = kernel.g.compare_whole("eq", most, 0)  # nothing to compare with the scale, which may be zero
        kernel.require((scale >= TINY) | ends_early)
        size = bits_of(choose(ends_early, 1.0, scale))
        for k, e in enumerate(ends):
            if moves(e):
                part = bits_of(abs(e)) - size
                worst[k] = part if worst[k] is None else larger(worst[k], part)
    least: Value = None
    for k, (order, within) in enumerate(((n, limit), (n - 1, limit_below))):
        if worst[k] is not None:
            kernel.require(worst[k] < 1024 * ONE)
            e = (within - (worst[k] >> CUT)) * int(PART / order)
            least = e if least is None else smaller(least, e)
    if least is None:  # nothing limits it
        return 2.0 * ((v["end"] - v["t"]) - v["t_low"])
    kernel.require(top < INFINITE)
    return statements.power_of_two(least >> 20)


def accept(kernel: Kernel, c: Sequence[Row], h: Value, gains: Row) -> None:
    """Leave a step to the event loop that may miss something; see `symfric.solve.loop.stepping.step_acceptance`."""
    if not kernel.exposed:
        return
    v, plan = kernel.v, kernel.plan
    aux = kernel.aux(kernel.variant)
    _hide_nothing(kernel, c, h, aux)
    end = [*(row[0] + e for row, e in zip(c, gains, strict=False)), v["t"] + (v["t_low"] + h)]
    probed = kernel.coefficients(kernel.variant.probe, aux, end)
    fine = SLACK * plan.tolerance
    for r in range(plan.automaton.n_q, plan.n_x):
        truth, rate = probed[r][1], statements.slope(c[r], h)
        allowed = statements.defect_of_rate(v[f"scale{r}"], abs(c[r][1]), truth, h, fine)
        kernel.require(abs(rate - truth) * h <= allowed)
    for r in kernel.exposed:
        if r >= plan.n_x:
            truth, found_value = probed[r][0], statements.value(c[r], plan.order, h)
            allowed = statements.defect_of_value(_size_of(kernel, c, r, h), truth, fine)
            kernel.require(abs(found_value - truth) <= allowed)


def _hide_nothing(kernel: Kernel, c: Sequence[Row], h: Value, aux: Row) -> None:
    """Require that what may be unseen on the whole step stays below the tolerance."""
    if kernel.variant.unseen is None:
        return
    v, plan = kernel.v, kernel.plan
    boxes = [statements.box_of_step(row, plan.order, h) for row in c[: plan.n_x]]
    half = 0.5 * h
    box = [*(middle for middle, _ in boxes), v["t"] + (v["t_low"] + half), *(radius for _, radius in boxes), half]
    box += [*(row[1] * half for row in c[: plan.n_x]), half]
    (bound,) = kernel.g.graph(kernel.variant.unseen, [box, aux])
    for r in kernel.exposed:
        if r < plan.n_x:
            allowed = plan.tolerance * larger(v[f"scale{r}"], abs(c[r][1]) * h) / h + NOTHING
        else:
            allowed = plan.tolerance * _size_of(kernel, c, r, h) + NOTHING
        kernel.require(allowed >= bound[r])


def _size_of(kernel: Kernel, c: Sequence[Row], r: int, h: Value) -> Value:
    return statements.size_of_row(kernel.v[f"scale{r}"], c[r][0], c[r][1], h)


def advance(kernel: Kernel, c: Sequence[Row], h: Value, gains: Row, last: Value) -> None:
    """Move states, time, scales and what is wanted to the end of a step."""
    v, plan = kernel.v, kernel.plan
    new: dict[str, Value] = {}
    for r, row in enumerate(c):
        scale = v[f"scale{r}"]
        if r < plan.n_x:
            new[f"y{r}"] = y = row[0] + gains[r]
            kernel.require(abs(y) < np.inf)
            new[f"scale{r}"] = statements.scale_of_state(scale, y, v[f"start{r}"], row[1], h)
        elif r < plan.n_x + plan.n_g:
            new[f"scale{r}"] = larger(scale, abs(row[0]))
        else:
            e = r - plan.n_x - plan.n_g
            new[f"first{e}"], new[f"second{e}"] = extended(kernel, e, c[plan.n_x + plan.n_g :], h)
            new[f"scale{r}"] = larger(scale, abs(row[1]) * h)
    t, t_low = statements.summed(v["t"], v["t_low"], h)
    new["t"], new["t_low"] = choose(last, v["end"], t), choose(last, 0.0, t_low)
    new["h_last"] = larger(h, 0.1 * v["h_last"])
    new["steps"] = v["steps"] + 1.0
    new |= {f"fresh{i}": v[f"fresh{i}"] - v[f"fresh{i}"] for i in kernel.starting}
    v.update(new)
    n_q = plan.automaton.n_q
    if "rest" in v and n_q > 1:  # a contact may leave some of them free
        scales = kernel.of("scale", 2 * n_q)
        drifts = statements.drifts(kernel.of("y", plan.n_x), scales, n_q, plan.horizon, plan.tolerance)
        v["rest"] = choose(drifts, math.nan, v["rest"])
