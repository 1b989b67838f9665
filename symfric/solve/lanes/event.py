"""A step that may end at an event, and the mode that follows, for lanes of scenes with one contact that can stick.

Where the forces leave a doubt, as at the bound of sticking, the lane is left to the event loop, which takes the whole
step again.
"""

import math
from collections.abc import Sequence

from symfric.codegen.llvm_ir import Written
from symfric.lower.constraint_forces import HOLDS
from symfric.lower.mode_layout import backward, forward
from symfric.solve.lanes.fields import HELD, Plan
from symfric.solve.lanes.located import LocatedStep
from symfric.solve.loop.model import joined_gauge
from symfric.solve.loop.precision import EPS, MOST_DOUBT, ROUNDING, TIE
from symfric.solve.loop.workspace import COUPLING, DROP, FORCES, LOAD, PULL, SLIP, TERMS

SLIPS, STICKS = 0, 1  # variants of the series


def event_step(plan: Plan, width: int, name: str, variant: int) -> Written:
    """Return the kernel of a step that may end at an event, of lanes that slip or of lanes that stick."""
    return _EventStep(plan, name, width, variant).written()


class _EventStep(LocatedStep):
    """Writes such a kernel."""

    def __init__(self, plan: Plan, name: str, width: int, variant: int):
        super().__init__(plan, name, width, variant)
        self.sticks = variant == STICKS
        if self.sticks:
            self.starting = ()  # the guards of forces

    def written(self) -> Written:
        g, v, old = self.g, self.v, dict(self.v)
        hit, which, last = self.to_event()
        names = [n for n in self.at if n.startswith(("y", "scale", "other", "aux"))]
        names += ["mode", "way", "fresh0", "little0", "rest", "events", "grazes"]

        def settle(olds: Sequence) -> list:
            before = dict(v)
            v.update(zip(names, olds[:-1], strict=True))
            self.plain = True
            self.settle(hit, which)
            news = [g.select(hit, v[n], o) for n, o in zip(names, olds, strict=False)]
            right = g.logic("or", self.plain, ~hit)
            self.v.update(before)
            return [*news, right]

        whole, self.plain = self.plain, True
        *news, right = g.branch(hit, [*(v[n] for n in names), True], settle)
        v.update(zip(names, news, strict=True))
        self.plain = g.logic("and", whole, right)
        self.finish(old, last, {HELD: g.equal(v["mode"], 0.0)})
        return g.written()

    # -- the mode that follows
    def settle(self, hit, which) -> None:
        """Choose the mode after an event as `symfric.solve.loop.mode_selection` does, where nothing is in doubt."""
        g, v, plan = self.g, self.v, self.plan
        at = self.gauge([v[f"y{r}"] for r in range(plan.n_x)])
        place, factor = plan.automaton.anchors[0]
        self.require((at[LOAD] >= 0.0) & (at[DROP] >= 0.0))
        self.require(v["events"] < v["mark_events"])
        v[f"y{place}"] = v[f"y{place}"] - g.rounded(at[SLIP] / factor)
        v["little0"] = g.max(TIE * at[PULL], ROUNDING * at[FORCES])
        old = v["mode"]
        aux = self.of("aux", plan.n_aux)
        if self.sticks:
            way, held, carries = g.select(g.equal(which, float(backward(0))), -1.0, 1.0), False, True
            guards, aux = self.release(at, way, hit, aux)
        else:
            found, aux = self.hold(old, aux)
            way, exceeds = self.excess(at, found, hit)
            held = carries = ~exceeds
            self.stay(found, hit & held)
            start = [row[0] for row in found[plan.n_x : plan.n_x + plan.n_g]]

            def let_go(olds: Sequence) -> list:
                rows, other = self.release(at, way, hit & exceeds, list(olds[plan.n_g : -1]))
                news = [g.select(exceeds, a, b) for a, b in zip([*rows, *other], olds, strict=False)]
                right, self.plain = self.plain, True
                return [*news, right]

            before, self.plain = self.plain, True
            *news, right = g.branch(hit & exceeds, [*start, *aux, True], let_go)
            self.plain = g.logic("and", before, right)
            guards, aux = news[: plan.n_g], news[plan.n_g :]
        v.update({f"aux{k}": a for k, a in enumerate(aux)})
        for k, value in enumerate(guards):  # guards of a slip and of a force have scales of their own
            scale, other = v[f"scale{plan.n_x + k}"], v[f"other{k}"]
            v[f"scale{plan.n_x + k}"] = g.select(carries, g.max(other, g.abs(value)), scale)
            v[f"other{k}"] = g.select(carries, scale, other)
        new = g.select(held, 0.0, way)
        changed = g.compare("one", new, old)
        v["events"] = g.select(changed, v["events"] + 1.0, v["events"])
        v["grazes"] = g.select(changed, v["grazes"], v["grazes"] + 1.0)
        v["mode"], v["way"] = new, g.select(held, v["way"], way)
        v["fresh0"] = g.select(held, 0.0, 1.0 + (v["t"] - v["t"]))
        self.rest(held)

    def gauge(self, y: list) -> list:
        """Return what slips and forces are compared with at a state."""
        given = [[*y, self.v["t"]], self.of("p", self.plan.n_p)]
        return self.g.graph(joined_gauge(self.plan.automaton.gauge), given)[0]

    def probe(self, variant: int, mode: list, aux: list) -> tuple[list[list], list]:
        """Return the first coefficients of all rows in a mode, and what depends on parameters and mode alone."""
        series = self.plan.variants[variant]
        (own,) = self.g.graph(series.prelude, [self.of("p", self.plan.n_p), mode])
        return self.coefficients(series.probe, own), [*own, *aux[len(own) :]]

    def hold(self, way, aux: list) -> tuple[list[list], list]:
        """Return the first coefficients while the contact sticks."""
        return self.probe(STICKS, [HOLDS, way], aux)

    def release(self, at: list, way, lanes, aux: list) -> tuple[list, list]:
        """Return the guards of a slip that begins; one that does not move off clearly is in doubt."""
        g, v, plan = self.g, self.v, self.plan
        found, aux = self.probe(SLIPS, [0.0, way], aux)
        _, first, second, third = found[plan.n_x + backward(0)]
        little = g.max(v["little0"], 4.0 * EPS * g.abs(v["t"]) * g.abs(second))
        backs = (first < -little) | ((first <= little) & (second * plan.horizon < -v["little0"]))
        idles = self.is_zero(first) & self.is_zero(second) & self.is_zero(third)
        self.require(~(lanes & (backs | idles)))
        return [row[0] for row in found[plan.n_x : plan.n_x + plan.n_g]], aux

    def is_zero(self, a):
        """Where a value is zero."""
        return self.g.equal(a, 0.0)

    def excess(self, at: list, found: list[list], lanes) -> tuple:
        """Return the direction in which a contact exceeds its bound if it sticks, and where it does."""
        g, plan = self.g, self.plan
        over, under = found[plan.n_x + backward(0)], found[plan.n_x + forward(0)]
        scale = self.stick_scale(found)
        back = over[0] < under[0]
        room, slope = g.select(back, over[0], under[0]), g.select(back, over[1], under[1])
        time = self.natural_time()
        instant = 4.0 * EPS * g.max(g.abs(self.v["t"]), time)
        exceeds = (room < -self.doubt(at, time)) & (-room > slope * instant)
        for side in (over, under):
            tie = (side[0] <= ROUNDING * scale) & (side[1] * plan.horizon < -TIE * scale)
            self.require(~(lanes & ~exceeds & tie))
        return g.select(back, -1.0, 1.0 + (time - time)), exceeds

    def stick_scale(self, found: list[list]):
        """Return the bound of a sticking contact plus the magnitude of its force."""
        over, under = found[self.plan.n_x + backward(0)][0], found[self.plan.n_x + forward(0)][0]
        return 0.5 * self.g.abs(over + under) + 0.5 * self.g.abs(over - under)

    def stay(self, found: list[list], lanes) -> None:
        """Leave a contact that begins to stick at its bound, or with hardly a bound, to the event loop."""
        scale = self.stick_scale(found)
        for k in (backward(0), forward(0)):
            room = found[self.plan.n_x + k][0]
            self.require(~lanes | ((room > ROUNDING * scale) & (scale > TIE * self.v[f"other{k}"])))

    def doubt(self, at: list, time):
        """Return the force by which the stick force may be wrong; see `symfric.solve.loop.tolerances.doubt_of`."""
        g, v, plan, n_q = self.g, self.v, self.plan, self.plan.automaton.n_q
        size = [g.abs(v[f"start{r}"]) + v[f"scale{r}"] if n_q <= r < 2 * n_q else v[f"y{r}"] for r in range(plan.n_x)]
        span = self.gauge(size)
        error = plan.doubt * (at[PULL] + span[TERMS] / time)
        least = g.max(v["little0"], g.min(MOST_DOUBT * at[PULL], error))
        return g.select(at[COUPLING] > 0.0, least / at[COUPLING], 0.0)

    def rest(self, held) -> None:
        """Note since when everything is at rest."""
        g, v, n = self.g, self.v, self.plan.automaton.n_q
        still = held
        for i in range(n, 2 * n):
            still = g.logic("and", still, g.abs(v[f"y{i}"]) <= 1e-13 * v[f"scale{i}"])
        since = g.select(v["rest"] >= 0.0, v["rest"], v["t"] + v["t_low"])
        v["rest"] = g.select(still, since, math.nan)
