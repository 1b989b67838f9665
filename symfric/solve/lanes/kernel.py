"""What a kernel is written with: a scene, the fields of its lanes, and which lanes are left to the event loop.

A kernel makes one step in all lanes at once, as straight-line code. Its arithmetic is that of the event loop, by the
same functions, see `symfric.solve.loop.statements`; where that branches, a kernel chooses lane by lane. A lane in which
a step is anything but plain is left as it was, and said so in the masks: the event loop makes that step.
"""

from collections.abc import Sequence

import casadi as ca

from symfric.codegen.columns import WithColumns
from symfric.codegen.lane_ir import LaneCode
from symfric.codegen.lane_values import Value
from symfric.codegen.llvm_ir import Written
from symfric.solve.lanes.fields import CALLED, LEFT, OWED, OWED_OF, Plan
from symfric.solve.loop.stepping.series import Series, reach

Row = Sequence[Value]  # coefficients


class Kernel:
    """A kernel that is being written.

    Parameters
    ----------
    plan : Plan
    name : str
    width : int
        Number of lanes.
    variant : int
        Of the series.
    called : bool
        Whether it is for some lanes only.

    Attributes
    ----------
    g : LaneCode
    v : dict
        Present values of the fields, by name.
    plain, called : mask or bool
        Lanes in which nothing is left to the event loop, and lanes that the kernel is for.
    owed : dict of int to mask
        Lanes in which a wanted row is left to the loop over lanes, which has the code of the event loop for that.
    starting : tuple of int
        Guards that may start at zero.
    """

    def __init__(self, plan: Plan, name: str, width: int, variant: int = 0, called: bool = False):
        self.plan, self.variant = plan, plan.variants[variant]
        self.g = LaneCode(name, width)
        self.at = plan.names()
        self.v: dict[str, Value] = {n: self.g.load(k) for n, k in self.at.items()}
        self.called: Value = self.g.load_mask(CALLED) if called else True
        self.exposed = sorted({r for v in plan.variants for r in v.exposed})
        self.starting = plan.starting if called or plan.selects_mode else ()
        self.plain: Value = True
        self.owed: dict[int, Value] = {}
        self._old = dict(self.v)

    def of(self, name: str, n: int) -> list[Value]:
        """Return some fields of one kind."""
        return [self.v[f"{name}{i}"] for i in range(n)]

    def fresh(self, i: int) -> Value:
        """Return where guard i starts its mode at zero; False if it never does so here."""
        return self.v[f"fresh{i}"] > 0.0 if i in self.starting else False

    def require(self, mask: Value) -> None:
        """Leave lanes that are not in the mask to the event loop."""
        self.plain = self.g.logic("and", self.plain, mask)

    def finish(self, last: Value, masks: dict[int, Value]) -> Written:
        """Store the fields that changed, and the masks; `last` says where the run or the slope of an input ends."""
        g, kept = self.g, self.g.logic("and", self.plain, self.called)
        for name, k in self.at.items():
            if self.v[name] is not self._old[name]:
                g.store(k, g.select(kept, self.v[name], self._old[name]))
        g.store_mask(LEFT, g.logic("or", g.opposite(self.plain), last))
        owed: Value = False
        for e in range(len(self.plan.rows)):
            lanes = g.logic("and", kept, self.owed.get(e, False))
            owed = g.logic("or", owed, lanes)
            g.store_mask(OWED_OF + e, lanes)
        g.store_mask(OWED, owed)
        for k, mask in masks.items():
            g.store_mask(k, g.logic("and", kept, mask))
        return g.written()

    def coefficients(
        self, f: ca.Function | Written | WithColumns | None, aux: Row, state: Row | None = None
    ) -> list[list[Value]]:
        """Return the rows of a series or a short one, at the present state and time unless given."""
        assert isinstance(f, ca.Function | WithColumns), "see plan_of"
        state = [*self.of("y", self.plan.n_x), self.v["t"]] if state is None else state
        flat = f.of(self.g.graph, state, aux) if isinstance(f, WithColumns) else self.g.graph(f, [state, aux])[0]
        n = len(flat) // self.plan.n_r
        return [flat[i : i + n] for i in range(0, len(flat), n)]

    def aux(self, series: Series) -> list[Value]:
        """Return what depends on parameters and mode alone."""
        return self.of("aux", series.prelude.nnz_out(0))

    def series(self) -> list[list[Value]]:
        """Return the coefficients of all rows."""
        return self.coefficients(self.variant.series, self.aux(self.variant))

    def reaches(self, c: Sequence[Row], h: Value, far: Value) -> tuple[list[Value], list[Value]]:
        """Return what a step h adds to the states, and by how much one of length `far` can change the guards."""
        plan = self.plan
        flat = [e for row in c[: plan.n_x + plan.n_g] for e in row]
        (bounds,) = self.g.graph(reach(plan.n_x, plan.n_g, plan.order), [[h, far], flat])
        return bounds[: plan.n_x], bounds[plan.n_x :]
