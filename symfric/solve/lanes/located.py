"""Steps without events, and steps that may end at one, in lanes."""

from symfric.codegen.elementwise import choose
from symfric.codegen.lane_values import Value, moves
from symfric.codegen.llvm_ir import Written
from symfric.solve.lanes.fields import MET, Plan
from symfric.solve.lanes.guards import excluded, first
from symfric.solve.lanes.kernel import Kernel
from symfric.solve.lanes.step import accept, advance, lengths


def smooth_step(plan: Plan, width: int, name: str = "smooth") -> Written:
    """Return the kernel of steps without events, in the one mode that there are series for or in that of slipping."""
    kernel = Kernel(plan, name, width)
    c, h, far, last = lengths(kernel, kernel.series())
    gains, totals = kernel.reaches(c, h, far)
    for i in range(plan.n_g):
        row = c[plan.n_x + i]
        if any(moves(e) or e != 0.0 for e in row[1:]):
            kernel.require(excluded(kernel, i, row, totals[i], far))
        elif moves(row[0]):
            kernel.require(row[0] > 0.0)
    accept(kernel, c, h, gains)
    advance(kernel, c, h, gains, last)
    return kernel.finish(last, {})


def located_step(plan: Plan, width: int, name: str, variant: int = 0) -> Written:
    """Return the kernel of a step that may end at an event; what follows from it the event loop decides."""
    kernel = Kernel(plan, name, width, variant, called=True)
    hit, kernel.v["which"], last = to_event(kernel)
    return kernel.finish(last, {MET: hit})


def to_event(kernel: Kernel) -> tuple[Value, Value, Value]:
    """Advance lanes; return where an event is reached and which guard has, and where the run or an input ends."""
    g, plan, layout = kernel.g, kernel.plan, kernel.plan.automaton.layout
    c, h, far, last = lengths(kernel, kernel.series())
    _, totals = kernel.reaches(c, h, far)
    tau, which = far, choose(kernel.called, 0.0, far - far)
    for i in range(plan.n_g):
        row = c[plan.n_x + i]
        if any(moves(e) or e != 0.0 for e in row[1:]):
            tau, which = first(kernel, row, i, totals[i], far, tau, which)
        elif moves(row[0]):
            kernel.require(row[0] > 0.0)
    hit = tau < far
    if layout.loads:  # the run ends there
        kernel.require(~hit | (which < float(layout.first_load)) | (which >= float(layout.first_other)))
    tau = choose(hit, tau, h)
    kernel.require(tau > 0.0)
    gains, _ = kernel.reaches(c, tau, tau)
    accept(kernel, c, tau, gains)
    last = last & ~hit
    advance(kernel, c, tau, gains, last)
    return g.logic("and", g.logic("and", hit, kernel.plain), kernel.called), which, last
