"""Work arrays of the event loop, allocated once for a program and reused for every run."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symfric.codegen.array_table import Cube, IntegerMatrix, Integers, Matrix, Reals
from symfric.lower.automaton import Automaton
from symfric.lower.mode_layout import backward, sign
from symfric.lower.structure_modes import StructureMatrices
from symfric.model.outputs import Row
from symfric.solve.loop.bernstein import DEPTH, bernstein_table
from symfric.solve.loop.decay_weights import weights
from symfric.solve.loop.run_arrays import Clock, Limits, RunArrays, common
from symfric.solve.loop.series import PROBED, Series

FUNCTIONS = 5  # entries of `code` for one variant, after two
STRUCTURE = 2  # value of `LoopLimits.linear`
JUMP, TRANSITION = 2 + 2 * FUNCTIONS, 3 + 2 * FUNCTIONS
# rows of `gauge`; those of the coupling and of the response follow
SLIP, TERMS, PULL, LOAD, DROP, FORCES, COUPLING = range(7)

# constant arrays, shared by all runs
SHARED = frozenset(
    {
        "code",
        "pattern",
        "sticks",
        "anchor",
        "factor",
        "parallel",
        "depends",
        "kind",
        "table",
        "limits",
        "follows",
        "damping",
        "due",
        "first_due",
    }
)
SHARED |= {
    "segment_t",
    "segment_p",
    "exposed",
    "other_guards",
    "shown",
    "weights",
    "operators",
    "places",
    "own",
    "joint",
}


class LoopLimits(Limits, kind=int):
    """Budgets of a run and constants of its scene."""

    n_q: int  # number of coordinates
    checked: int  # whether features may be unseen in the coefficients of a step
    sticker: int  # the only contact that can stick if it has series of its own for that, else -1
    linear: int  # 1 if the equations are matrices, STRUCTURE if they are those of a structure, else 0
    along_q: int  # of a structure, numbers of the rows of coordinates, of velocities, of directions of the contacts,
    along_u: int  # and of those of forces, see `symfric.lower.structure_modes`
    felt: int
    pushes: int
    varied: int  # number of directions of differentiation
    followed: int  # number of first rows with derivatives, which are the last rows
    edges: int  # number of switches at which a profile jumps
    coupled: int  # n_q if the forces of one contact accelerate the slip of another, else 0
    first_load: int  # index of the first guard of loads; the guards of other contacts follow the loads
    first_other: int
    first_variable: int  # index in m of the first variable of other contacts; these start at zero
    exact: int  # order to which weighted steps are accurate, 0 without them; see `symfric.solve.loop.decay_weights`
    apart: int  # whether a run pauses after every choice of its mode


class LoopClock(Clock):
    """Times and tolerances of a run."""

    tolerance: float  # tolerance of the run
    removed: float  # twice the energy of the largest single impulse that makes a slip zero before mode selection
    gained: float  # the same of the impulses that make all of them zero
    doubt: float  # relative error of an acceleration in the decision to stick


@dataclass(frozen=True, eq=False, kw_only=True)
class LoopArrays(RunArrays):
    """Arrays of one run; n_r = n_x + n_g + n_e rows of order + 1 coefficients.

    `code` has the addresses of gauge and reach, then of prelude, series, probe, unseen and terms; if one contact alone
    can stick these are for its slipping, and five more are for its sticking; of linear equations, the prelude computes
    the matrices, and that is all; last the jump of the derivatives at events and the
    transition of contacts of other kinds. Behind the parameters, `p` has start,
    value and slope of every input.
    """

    clock: LoopClock
    limits: LoopLimits
    m: Reals  # stick flags, directions, switch signs, variables of other contacts
    aux: Reals  # results of the prelude, and memory of series that are tables
    newest: Matrix  # coefficients of the states of one order and of the next, (2, n_x)
    pattern: IntegerMatrix  # rows and columns of the entries of the matrices that are not zero in every mode, (n, 2)
    filled: Integers  # number of nonzero entries in the current mode: of the rates, and of all, (2,)
    row: Integers  # rows of these entries, (n,)
    column: Integers
    entry: Reals
    damping: Reals  # weights of the coefficients in such steps, (order + 1,)
    weights: Matrix  # of a structure, see `symfric.lower.structure_modes`; also operators, places, own and joint
    operators: Matrix
    combined: Reals  # the operators in one with the present factors
    places: IntegerMatrix
    own: Integers
    joint: Integers
    given: Reals  # what is felt of one coefficient, the columns of D
    answers: Reals  # what follows from it, the rows of D
    pushed: Reals  # the accelerations, (n_q,)
    c: Matrix  # Taylor coefficients, (n_r, order + 1)
    probe: Matrix  # first coefficients, (n_r, PROBED + 1)
    gauge: Matrix  # slip, its scale, pull of static friction, load, static minus kinetic coefficient, all forces;
    # then the coupling J M^-1 J^T, the response M^-1 J^T of the velocities and, with the limit `coupled`, the
    # slopes J^T, (COUPLING + n_c + n_q + coupled, n_c), and the sizes at the edges, one after the other, see
    # `symfric.lower.cell_edges.Edges`
    span: Matrix  # the same at the largest velocities so far
    share: Matrix  # Cholesky factor of the coupling of the sticking contacts, (n_c, n_c)
    order: Integers  # order of the contacts in this factorisation, (n_c,)
    weight: Reals  # coefficients of a slip row in the basis, (n_c,)
    slips: Reals  # directions of contacts that slip together, (n_c,)
    facet: Reals  # directions of the contacts that have to slip, (n_c,)
    force: Reals  # sum of the forces of parallel contacts, at their representative; next, sum of the bounds, (n_c,)
    most: Reals
    tried: Integers  # contacts already tried as sticking, (n_c,)
    kept: Reals  # marks and directions saved before a trial, (2 n_c,)
    passes: Integers  # contacts that pass through zero slip, (n_c,)
    entry_m: Reals  # modes and state before mode selection
    entry_y: Reals
    slopes: Matrix  # orthogonalised slip rows of the sticking contacts, (n_c, n_q)
    response: Matrix  # response of the velocities to these, (n_c, n_q)
    impulse: Reals  # impulse of each contact that makes its slip exactly zero, (n_c,)
    scale: Reals  # largest variation (states, observables) or value (guards) so far, (n_r,)
    other: Reals  # scales of the guards of contacts while they were slips, of those that carry forces, or the reverse
    carries: Integers  # contacts whose guards are forces, (n_c,)
    trial: Reals  # state and time at the end of the trial step, (n_x + 1,)
    exposed: Integers  # rows whose coefficients may miss features, (n_h,)
    unseen: Reals  # bounds of such features in a part of the step; next, sizes of terms; (n_r,) if any row is exposed
    terms: Reals
    box: Reals  # middles and radii of states and time in a part of the step, (2 n_x + 2,)
    bend: Reals  # largest second derivative of the states over the step, (n_x,)
    base: Matrix  # state before a singular start, and its first two coefficients, (3, n_x)
    start: Reals  # first value of every row, (n_r,)
    sticks: Integers  # whether a contact can stick, (n_c,)
    anchor: Integers  # index of the only velocity in a contact's slip, or -1, (n_c,)
    factor: Reals  # factor of this velocity, (n_c,)
    parallel: Integers  # first contact whose slip is a multiple of that of a contact, (n_c,)
    depends: Integers  # whether the slip may depend on those of others that are not parallel, (n_c,)
    loads: Integers  # index of the guard of a contact's load, or -1, (n_c,)
    old: Integers  # modes before an event, (n_c,)
    zero: Integers  # contacts whose slip is zero now, (n_c,)
    edge: Integers  # 1, 2, ... for the switches at which a profile jumps, 0 for the others, (n_s,)
    rested: Integers  # whether a switch had no sign before the event, (n_s,)
    turns: Integers  # number of changes of a contact or switch during mode selection, (n_c + n_s,)
    hit: Integers  # guards that have just reached zero, (n_g,)
    fresh: Integers  # guards that start their mode at zero, (n_g,)
    slack: Reals  # shift of a guard so that it starts its mode at zero, and of a load for its rounding, (n_g,)
    kind: Integers  # RANGE, INTEGRAL or VALUES of every observable, (n_e,)
    step: Reals  # length of the trial step, and time over which guards are followed, (2,)
    reach: Reals  # change of the states over the step, and bounds of the change of guards, (n_x + n_g,)
    poly: Reals  # copy of a polynomial, (order + 5,)
    slope: Reals  # derivative of this polynomial
    found: Reals  # roots found
    stack: Matrix  # stack of the subdivision
    table: Cube  # table of Bernstein coefficients
    segment_t: Reals  # times at which inputs change their slope, increasing, the last one infinite
    segment_p: Matrix  # start, value and slope of every input from there on
    follows: Integers  # the row that a derivative follows, or -1, (n_e,)
    before: Reals  # inputs of the saltation: parameters, modes before and after an event, guards hit
    after: Reals  # outputs of the saltation; see `symfric.lower.variational_equations`
    tau: Reals  # derivatives of the time of the event at which this step begins, (n_s,)
    left: Reals  # state and time before an event, (n_x + 1,) if there are contacts of other kinds
    asked: Reals  # inputs of a transition: parameters, mode, guards hit, guards at zero; next, its outputs: state,
    answer: Reals  # mode, guards at zero
    shown: Integers  # index in m of what a trajectory keeps of each of them
    other_guards: IntegerMatrix  # contact of each of their guards, and its first variable in m or -1
    rise: Matrix  # slopes of rows with their lowest or highest value at the end of the last step, (n_e, 2)


def make_arrays(
    automaton: Automaton,
    variants: Sequence[Series],
    addresses: dict[str, int],
    rows: Sequence[Row],
    segments,
    jump: ca.Function | None = None,
) -> LoopArrays:
    """Allocate the arrays of a program.

    Parameters
    ----------
    automaton : Automaton
    variants : sequence of Series
        One for all modes, or two, as described at `LoopArrays`.
    addresses : dict of str to int
        By function name.
    rows : sequence of Row
        What is wanted.
    segments : tuple of arrays
        Times at which inputs change their slope, and what they are from there on.
    jump : casadi.Function, optional
        Of the derivatives at events.
    """
    layout, n_switches = automaton.layout, automaton.layout.switches
    n_x, n_c, n_g = len(automaton.states), len(layout.lines), layout.n_guards
    n_e, order, n_q = len(rows), variants[0].order, automaton.n_q
    n_r, n_p = n_x + n_g + n_e, variants[0].prelude.nnz_in(0)
    functions = ["gauge", "reach"]
    functions += [f.name() if f else "" for v in variants for f in (v.prelude, v.series, v.probe, v.unseen, v.terms)]
    functions += [""] * (JUMP - len(functions)) + ["jump", "transition"]
    exposed = sorted({r for v in variants for r in v.exposed})
    matrices = variants[0].matrices
    entries = list(zip(matrices.rows, matrices.columns, strict=True)) if matrices else []
    pattern = np.array(entries, dtype=np.int64).reshape(-1, 2)
    structure = matrices if isinstance(matrices, StructureMatrices) else None
    gauged = COUPLING + n_c + n_q * (1 + automaton.coupled) + -(-3 * len(automaton.at_edges) // max(n_c, 1))
    ranks = dict(zip(automaton.at_edges, range(1, n_switches + 1), strict=False))
    room = lambda *shape: np.zeros(shape)  # noqa: E731
    flags = lambda n: np.zeros(n, dtype=np.int64)  # noqa: E731
    return LoopArrays(
        **{
            **common(n_x, len(automaton.parameters), [r.times for r in rows], order, n_c + len(layout.shown)),
            "clock": LoopClock.zeros(),
        },
        limits=LoopLimits.zeros(),
        code=np.array([addresses.get(name, 0) for name in functions], dtype=np.int64),
        p=room(n_p),
        m=room(layout.n_mode),
        aux=room(max(v.prelude.nnz_out(0) + v.room for v in variants)),
        newest=room(2, n_x),
        pattern=pattern,
        **_structure_arrays(structure, n_q),
        filled=flags(2),
        row=flags(len(pattern)),
        column=flags(len(pattern)),
        entry=room(len(pattern)),
        damping=weights(order),
        c=room(n_r, order + 1),
        probe=room(n_r, PROBED + 1),
        gauge=room(gauged, n_c),
        span=room(gauged, n_c),
        share=room(n_c, n_c),
        order=flags(n_c),
        weight=room(n_c),
        slips=room(n_c),
        facet=room(n_c),
        force=room(n_c),
        most=room(n_c),
        tried=flags(n_c),
        kept=room(sign(0, n_c)),
        passes=flags(n_c),
        entry_m=room(layout.n_mode),
        entry_y=room(n_x),
        slopes=room(n_c, n_q),
        response=room(n_c, n_q),
        impulse=room(n_c),
        scale=room(n_r),
        other=room(backward(n_c)),
        carries=flags(n_c),
        trial=room(n_x + 1),
        exposed=np.array(exposed, dtype=np.int64),
        unseen=room(n_r if exposed else 0),
        terms=room(n_r if exposed else 0),
        box=room(2 * n_x + 2),
        bend=room(n_x),
        base=room(3, n_x),
        start=room(n_r),
        sticks=np.array(automaton.sticks, dtype=np.int64),
        anchor=np.array([a for a, _ in automaton.anchors], dtype=np.int64),
        factor=np.array([f for _, f in automaton.anchors], dtype=float),
        parallel=np.array(automaton.parallels, dtype=np.int64),
        depends=np.array(automaton.dependent, dtype=np.int64),
        loads=np.array([layout.load(name) for name in layout.lines], dtype=np.int64),
        old=flags(n_c),
        zero=flags(n_c),
        edge=np.array([ranks.get(j, 0) for j in range(n_switches)], dtype=np.int64),
        rested=flags(n_switches),
        turns=flags(n_c + n_switches),
        hit=flags(n_g),
        fresh=flags(n_g),
        slack=room(n_g),
        kind=np.array([r.kind for r in rows], dtype=np.int64),
        step=room(2),
        reach=room(n_x + n_g),
        poly=room(order + 5),
        slope=room(order + 2),
        found=room(order + 2),
        stack=room(DEPTH + 4, order + 4),
        table=bernstein_table(order),
        segment_t=segments[0],
        segment_p=segments[1],
        follows=np.array([r.follows for r in rows], dtype=np.int64),
        before=room(jump.nnz_in(1) if jump else 0),
        after=room(jump.nnz_out(0) if jump else 0),
        tau=room(n_x),
        left=room(n_x + 1 if layout.others else 0),
        asked=room(n_p + layout.n_mode + 2 * (n_g - layout.first_other) if layout.others else 0),
        answer=room(automaton.n_y + layout.n_mode + n_g - layout.first_other if layout.others else 0),
        shown=np.array(layout.shown, dtype=np.int64),
        other_guards=np.array(layout.other_guards, dtype=np.int64).reshape(-1, 2),
        rise=room(n_e, 2),
    )


def _structure_arrays(matrices: StructureMatrices | None, n_q: int) -> dict[str, Any]:
    """Return the arrays of a structure, empty for any other scene."""
    nothing, none = np.zeros((0, 0)), np.zeros(0, dtype=np.int64)
    if matrices is None:
        return {
            **dict.fromkeys(("weights", "operators"), nothing),
            **dict.fromkeys(("combined", "given", "answers", "pushed"), nothing.ravel()),
            "places": none.reshape(0, 2),
            "own": none,
            "joint": none,
        }
    along_q, along_u, felt, _ = matrices.sizes
    return {
        "weights": matrices.weights,
        "operators": matrices.operators,
        "combined": matrices.operators[0].copy(),
        "places": matrices.places,
        "own": np.array(matrices.own, dtype=np.int64),
        "joint": np.array(matrices.joint, dtype=np.int64),
        "given": np.zeros(along_q + along_u + len(matrices.own) + felt),
        "answers": np.zeros(matrices.n_r),
        "pushed": np.zeros(n_q),
    }
