"""Steps without events, and steps that may end at one, for all lanes at once."""

from symfric.codegen.lane_values import moves
from symfric.codegen.llvm_ir import Written
from symfric.solve.lanes.fields import MET, Plan
from symfric.solve.lanes.guards import GuardedStep


def smooth_step(plan: Plan, width: int, name: str = "smooth") -> Written:
    """Return the kernel of steps without events, in the one mode that there are series for or in that of slipping."""
    k = GuardedStep(plan, name, width)
    g, old, n_x = k.g, dict(k.v), plan.n_x
    c = k.series()
    c, h, far, last = k.lengths(c)
    gains, totals = k.reaches(c, h, far)
    for i in range(plan.n_g):
        row = c[n_x + i]
        if any(moves(e) for e in row[1:]):
            k.require(k.excluded(i, row, totals[i], far))
        elif moves(row[0]):
            k.require(row[0] > 0.0)
    k.accept(c, h, gains)
    k.advance(c, h, gains, last)
    k.finish(old, last, {})
    return g.written()


def located_step(plan: Plan, width: int, name: str, variant: int = 0) -> Written:
    """Return the kernel of a step that may end at an event; what follows from it the event loop decides."""
    k = LocatedStep(plan, name, width, variant)
    old = dict(k.v)
    hit, which, last = k.to_event()
    k.v["which"] = which
    k.finish(old, last, {MET: hit})
    return k.g.written()


class LocatedStep(GuardedStep):
    """Writes a step that may end at an event."""

    def __init__(self, plan: Plan, name: str, width: int, variant: int):
        super().__init__(plan, name, width, variant, called=True)

    def to_event(self) -> tuple:
        """Advance lanes; return where an event is reached and which guard has, and where the run or an input ends."""
        g, plan, n_x, layout = self.g, self.plan, self.plan.n_x, self.plan.automaton.layout
        c = self.series()
        c, h, far, last = self.lengths(c)
        _, totals = self.reaches(c, h, far)
        tau, which = far, g.select(self.called, 0.0, far - far)
        for i in range(plan.n_g):
            row = c[n_x + i]
            if any(moves(e) for e in row[1:]):
                tau, which = self.first(row, i, totals[i], far, tau, which)
            elif moves(row[0]):
                self.require(row[0] > 0.0)
        hit = tau < far
        if layout.loads:  # the run ends there
            self.require(~hit | (which < float(layout.first_load)) | (which >= float(layout.first_other)))
        tau = g.select(hit, tau, h)
        self.require(tau > 0.0)
        gains, _ = self.reaches(c, tau, tau)
        self.accept(c, tau, gains)
        last = last & ~hit
        self.advance(c, tau, gains, last)
        return g.logic("and", g.logic("and", hit, self.plain), self.called), which, last
