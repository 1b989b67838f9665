"""A step that may end at an event, and the mode that follows, for lanes of scenes with one contact that can stick.

The mode is chosen as by `symfric.solve.loop.modes.mode_selection`. Where the forces leave a doubt, as at the bound of
sticking, the lane is left to the event loop, which takes the whole step again.
"""

import math
from collections.abc import Sequence

from symfric.codegen.elementwise import choose, larger
from symfric.codegen.lane_values import Value
from symfric.codegen.llvm_ir import Written
from symfric.lower.constraint_forces import HOLDS
from symfric.lower.mode_layout import backward, forward
from symfric.solve.lanes.fields import HELD, Plan
from symfric.solve.lanes.guards import natural_time
from symfric.solve.lanes.kernel import Kernel, Row
from symfric.solve.lanes.located import to_event
from symfric.solve.loop import statements
from symfric.solve.loop.codes import COUPLING, DROP, FORCES, LOAD, PULL, SLIP, TERMS
from symfric.solve.loop.model import joined_gauge
from symfric.solve.loop.precision import ROUNDING, TIE

SLIPS, STICKS = 0, 1  # variants of the series


def event_step(plan: Plan, width: int, name: str, variant: int) -> Written:
    """Return the kernel of a step that may end at an event, of lanes that slip or of lanes that stick."""
    kernel = Kernel(plan, name, width, variant, called=True)
    if variant == STICKS:
        kernel.starting = ()  # the guards of forces
    g, v = kernel.g, kernel.v
    hit, which, last = to_event(kernel)
    names = [n for n in kernel.at if n.startswith(("y", "scale", "other", "aux"))]
    names += ["mode", "way", "fresh0", "little0", "rest", "events", "grazes"]

    def selected(olds: Row) -> Row:
        before = dict(v)
        v.update(zip(names, olds[:-1], strict=True))
        kernel.plain = True
        _select_mode(kernel, hit, which, variant == STICKS)
        news = [choose(hit, v[n], o) for n, o in zip(names, olds, strict=False)]
        right = g.logic("or", kernel.plain, ~hit)
        v.update(before)
        return [*news, right]

    whole, kernel.plain = kernel.plain, True
    *news, right = g.branch(hit, [*(v[n] for n in names), True], selected)
    v.update(zip(names, news, strict=True))
    kernel.plain = g.logic("and", whole, right)
    return kernel.finish(last, {HELD: g.equal(v["mode"], 0.0)})


def _select_mode(kernel: Kernel, hit: Value, which: Value, sticks: bool) -> None:
    """Choose the mode after an event, where nothing is in doubt."""
    g, v, plan = kernel.g, kernel.v, kernel.plan
    at = _gauge(kernel, kernel.of("y", plan.n_x))
    place, factor = plan.automaton.anchors[0]
    kernel.require((at[LOAD] >= 0.0) & (at[DROP] >= 0.0))
    kernel.require(v["events"] < v["mark_events"])
    v[f"y{place}"] = v[f"y{place}"] - g.rounded(at[SLIP] / factor)
    v["little0"] = statements.little_acceleration(at[PULL], at[FORCES])
    old = v["mode"]
    aux = kernel.of("aux", plan.n_aux)
    if sticks:
        way, held, carries = choose(g.equal(which, float(backward(0))), -1.0, 1.0), False, True
        guards, aux = _release(kernel, way, hit, aux)
    else:
        probed, aux = _probe(kernel, STICKS, [HOLDS, old], aux)
        way, exceeds = _excess(kernel, at, probed, hit)
        held = carries = ~exceeds
        _stay(kernel, probed, hit & held)
        start = _guards(kernel, probed)

        def let_go(olds: Row) -> Row:
            rows, other = _release(kernel, way, hit & exceeds, olds[plan.n_g : -1])
            news = [choose(exceeds, a, b) for a, b in zip([*rows, *other], olds, strict=False)]
            right, kernel.plain = kernel.plain, True
            return [*news, right]

        before, kernel.plain = kernel.plain, True
        *news, right = g.branch(hit & exceeds, [*start, *aux, True], let_go)
        kernel.plain = g.logic("and", before, right)
        guards, aux = news[: plan.n_g], news[plan.n_g :]
    v.update({f"aux{k}": a for k, a in enumerate(aux)})
    for k, value in enumerate(guards):  # guards of a slip and of a force have scales of their own
        scale, other = v[f"scale{plan.n_x + k}"], v[f"other{k}"]
        v[f"scale{plan.n_x + k}"] = choose(carries, larger(other, abs(value)), scale)
        v[f"other{k}"] = choose(carries, scale, other)
    new = choose(held, 0.0, way)
    changed = g.compare("one", new, old)
    v["events"] = choose(changed, v["events"] + 1.0, v["events"])
    v["grazes"] = choose(changed, v["grazes"], v["grazes"] + 1.0)
    v["mode"], v["way"] = new, choose(held, v["way"], way)
    v["fresh0"] = choose(held, 0.0, 1.0 + (v["t"] - v["t"]))
    _rest(kernel, held)


def _gauge(kernel: Kernel, y: Row) -> list[Value]:
    """Return what slips and forces are compared with at a state."""
    given = [[*y, kernel.v["t"]], kernel.of("p", kernel.plan.n_p)]
    return kernel.g.graph(joined_gauge(kernel.plan.automaton.gauge), given)[0]


def _probe(kernel: Kernel, variant: int, mode: Row, aux: Row) -> tuple[list[list[Value]], list[Value]]:
    """Return the first coefficients of all rows in a mode, and what depends on parameters and mode alone."""
    series = kernel.plan.variants[variant]
    (own,) = kernel.g.graph(series.prelude, [kernel.of("p", kernel.plan.n_p), mode])
    return kernel.coefficients(series.probe, own), [*own, *aux[len(own) :]]


def _guards(kernel: Kernel, probed: Sequence[Row]) -> list[Value]:
    plan = kernel.plan
    return [row[0] for row in probed[plan.n_x : plan.n_x + plan.n_g]]


def _release(kernel: Kernel, way: Value, lanes: Value, aux: Row) -> tuple[list[Value], list[Value]]:
    """Return the guards of a slip that begins; one that does not move off clearly is in doubt."""
    g, v, plan = kernel.g, kernel.v, kernel.plan
    probed, aux = _probe(kernel, SLIPS, [0.0, way], aux)
    _, first, second, third = probed[plan.n_x + backward(0)]
    little = statements.no_acceleration(v["little0"], v["t"], second)
    backs = (first < -little) | ((first <= little) & (second * plan.horizon < -v["little0"]))
    idles = g.equal(first, 0.0) & g.equal(second, 0.0) & g.equal(third, 0.0)
    kernel.require(~(lanes & (backs | idles)))
    return _guards(kernel, probed), aux


def _sides(kernel: Kernel, probed: Sequence[Row]) -> tuple[Row, Row, Value]:
    """Return the two guards of a sticking contact, and what rounding of them is relative to."""
    over, under = probed[kernel.plan.n_x + backward(0)], probed[kernel.plan.n_x + forward(0)]
    return over, under, statements.stick_scale(over[0], under[0])


def _excess(kernel: Kernel, at: Row, probed: Sequence[Row], lanes: Value) -> tuple[Value, Value]:
    """Return the direction in which a contact exceeds its bound if it sticks, and where it does."""
    over, under, scale = _sides(kernel, probed)
    back = over[0] < under[0]
    room, slope = choose(back, over[0], under[0]), choose(back, over[1], under[1])
    time = natural_time(kernel)
    instant = statements.instant(kernel.v["t"], time)
    exceeds = (room < -_doubt(kernel, at, time)) & (-room > slope * instant)
    for side in (over, under):
        tie = (side[0] <= ROUNDING * scale) & (side[1] * kernel.plan.horizon < -TIE * scale)
        kernel.require(~(lanes & ~exceeds & tie))
    return choose(back, -1.0, 1.0 + (time - time)), exceeds


def _stay(kernel: Kernel, probed: Sequence[Row], lanes: Value) -> None:
    """Leave a contact that begins to stick at its bound, or with hardly a bound, to the event loop."""
    *sides, scale = _sides(kernel, probed)
    for k, side in zip((backward(0), forward(0)), sides, strict=True):
        kernel.require(~lanes | ((side[0] > ROUNDING * scale) & (scale > TIE * kernel.v[f"other{k}"])))


def _doubt(kernel: Kernel, at: Row, time: Value) -> Value:
    """Return the force by which the stick force may be wrong; see `doubt_of` of the event loop."""
    v, plan, n_q = kernel.v, kernel.plan, kernel.plan.automaton.n_q
    size = [abs(v[f"start{r}"]) + v[f"scale{r}"] if n_q <= r < 2 * n_q else v[f"y{r}"] for r in range(plan.n_x)]
    span = _gauge(kernel, size)
    least = statements.doubted_force(v["little0"], at[PULL], span[TERMS], time, plan.doubt)
    return choose(at[COUPLING] > 0.0, least / at[COUPLING], 0.0)


def _rest(kernel: Kernel, held: Value) -> None:
    """Note since when everything is at rest."""
    v, n = kernel.v, kernel.plan.automaton.n_q
    still = held
    for i in range(n, 2 * n):
        still = kernel.g.logic("and", still, statements.is_at_rest(v[f"y{i}"], v[f"scale{i}"]))
    since = choose(v["rest"] >= 0.0, v["rest"], v["t"] + v["t_low"])
    v["rest"] = choose(still, since, math.nan)
