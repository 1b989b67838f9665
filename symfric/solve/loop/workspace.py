"""Work arrays of the event loop, allocated once for a program and reused for every run."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from symfric.codegen.array_table import VECTOR, Matrix, Reals
from symfric.lower.automaton import Automaton
from symfric.lower.linear_modes import Matrices
from symfric.lower.mode_layout import backward, sign
from symfric.lower.structure_modes import StructureMatrices
from symfric.model.rows import Row
from symfric.solve.loop.codes import COUPLING, JUMP
from symfric.solve.loop.events.bernstein import DEPTH, bernstein_columns, bernstein_table
from symfric.solve.loop.events.direction_sizes import QUARTIC
from symfric.solve.loop.plane_arrays import foot_arrays, plane_arrays, start_arrays
from symfric.solve.loop.records import (
    Basis,
    Contacts,
    Feet,
    Guards,
    Impacts,
    Inputs,
    Kinds,
    LinearEquations,
    Openings,
    Pivots,
    Planes,
    Powers,
    Roots,
    Saltation,
    Selection,
    Starts,
    Step,
    Tables,
    Transition,
)
from symfric.solve.loop.run_arrays import Clock, Limits, RunArrays, common
from symfric.solve.loop.stepping.decay_weights import weights
from symfric.solve.loop.stepping.series import PROBED, Series

SHARED = frozenset(
    {"code", "limits", "times", "inputs", "contacts", "wanted", "tables", "matrices", "openings"}
)  # no run changes them


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
    varied: int  # number of columns of derivatives
    directions: int  # of these the first ones, by one direction each; the others are second derivatives
    followed: int  # number of first rows with derivatives, which are the last rows
    edges: int  # number of switches at which a profile jumps
    steps: int  # number of steps in time
    holds: int  # whether an input at which slips jump is not continuous
    planes: int  # number of contacts in the plane
    coupled: int  # n_q if the forces of one contact accelerate the slip of another, else 0
    first_load: int  # index of the first guard of loads; the guards of other contacts follow the loads
    first_other: int
    first_plane: int  # index of the first guard of the others that is none of a contact behind a spring
    first_opening: int  # index of the first guard of contacts that open, two each
    first_clock: int  # index of the first guard of clocks, which come last
    first_crossing: int  # of those the first of crossings, and of crossings of resets
    first_reset: int
    first_variable: int  # index in m of the first variable of other contacts; these start at zero
    exact: int  # order to which weighted steps are accurate, 0 without them; see `.stepping.decay_weights`
    apart: int  # whether a run pauses after every choice of its mode


class LoopClock(Clock):
    """Times and tolerances of a run."""

    tolerance: float  # tolerance of the run
    removed: float  # twice the energy of the largest single impulse that makes a slip zero before mode selection
    gained: float  # the same of the impulses that make all of them zero
    late: float  # time after the last event at which bounces that died out end
    doubt: float  # relative error of an acceleration in the decision to stick


@dataclass(frozen=True, eq=False, kw_only=True)
class LoopArrays(RunArrays):
    """Arrays of one run; n_r = n_x + n_g + n_e rows of order + 1 coefficients.

    What all parts of the loop share is here, and what one part works with in the record of its name.

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
    c: Matrix  # Taylor coefficients, (n_r, order + 1)
    probe: Matrix  # first coefficients, (n_r, PROBED + 1)
    scale: Reals  # largest variation (states, observables) or value (guards) so far, (n_r,)
    start: Reals  # first value of every row, (n_r,)
    gauge: Matrix  # slip, its scale, pull of static friction, load, static minus kinetic coefficient, all forces;
    # then the coupling J M^-1 J^T, the response M^-1 J^T of the velocities and, with the limit `coupled`, the
    # slopes J^T, (COUPLING + n_c + n_q + coupled, n_c), and the sizes at the edges, one after the other, see
    # `symfric.lower.cell_edges.Edges`, or, with contacts in the plane, static and kinetic bounds
    span: Matrix  # the same at the largest velocities so far
    inputs: Inputs
    contacts: Contacts
    wanted: Kinds
    tables: Tables
    matrices: LinearEquations
    powers: Powers
    step: Step
    roots: Roots
    guards: Guards
    selection: Selection
    basis: Basis
    saltation: Saltation
    transition: Transition
    openings: Openings
    impacts: Impacts
    pivots: Pivots
    planes: Planes
    starts: Starts
    feet: Feet


def make_arrays(
    automaton: Automaton,
    variants: Sequence[Series],
    addresses: dict[str, int],
    rows: Sequence[Row],
    segments: tuple[np.ndarray, np.ndarray],
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
    functions += [""] * (JUMP - len(functions)) + ["jump", "transition", "impact"]
    exposed = sorted({r for v in variants for r in v.exposed})
    n_h = n_r if exposed else 0
    gauged = COUPLING + n_c + n_q * (1 + automaton.coupled) + -(-3 * len(automaton.at_edges) // max(n_c, 1))
    gauged += 2 if automaton.planes else 0
    ranks = dict(zip(automaton.at_edges, range(1, n_switches + 1), strict=False))
    others, lines = n_g - layout.first_other, layout.lines_of_openings
    n_n, impact = len(lines), automaton.impact
    matrices, powers = _linear_equations(variants[0].matrices, n_x, n_q)
    return LoopArrays(
        **common(n_x, len(automaton.parameters), [r.times for r in rows], order, n_c + len(layout.shown)),
        clock=LoopClock.zeros(),
        limits=LoopLimits.zeros(),
        code=np.array([addresses.get(name, 0) for name in functions], dtype=np.int64),
        p=_room(n_p),
        m=_room(layout.n_mode),
        aux=_room(max(v.prelude.nnz_out(0) + v.room for v in variants)),
        c=_room(n_r, order + 1),
        probe=_room(n_r, PROBED + 1),
        scale=_room(n_r),
        start=_room(n_r),
        gauge=_room(gauged, n_c),
        span=_room(gauged, n_c),
        inputs=Inputs(times=segments[0], values=segments[1]),
        contacts=Contacts(
            sticks=_numbers(automaton.sticks),
            anchor=_numbers([a for a, _ in automaton.anchors]),
            factor=np.array([f for _, f in automaton.anchors], dtype=float),
            parallel=_numbers(automaton.parallels),
            depends=_numbers(automaton.dependent),
            loads=_numbers([layout.load(name) for name in layout.lines]),
            edge=_numbers([ranks.get(j, 0) for j in range(n_switches)]),
            step=_numbers([j in automaton.steps for j in range(n_switches)]),
            opens=_numbers([_opening(lines, automaton.planes, i) for i in range(n_c)]),
            partner=_numbers(layout.partners),
            shown=_numbers(layout.shown),
            other_guards=_numbers(layout.other_guards).reshape(-1, 2),
        ),
        wanted=Kinds(
            kind=_numbers([r.kind for r in rows]),
            follows=_numbers([r.follows for r in rows]),
            start=np.array([r.start for r in rows], dtype=float),
        ),
        tables=_tables(order, exposed),
        matrices=matrices,
        powers=powers,
        step=Step.zeros(
            lengths=2, reach=n_x + n_g, end=n_x + 1, unseen=n_h, terms=n_h, box=3 * n_x + 3, bend=n_x, base=(3, n_x)
        ),
        roots=Roots.zeros(
            poly=order + 5, slope=order + 2, places=order + 2, stack=(DEPTH + 4, max(order, QUARTIC) + 4)
        ),
        guards=Guards.zeros(hit=n_g, fresh=n_g, slack=n_g, other=backward(n_c), carries=n_c),
        selection=Selection.zeros(
            old=n_c,
            zero=n_c,
            rested=n_switches,
            turns=n_c + n_switches,
            tried=n_c,
            kept=sign(0, n_c),
            passes=n_c,
            entry_m=layout.n_mode,
            entry_y=n_x,
            impulse=n_c,
        ),
        basis=Basis.zeros(
            share=(n_c, n_c),
            order=n_c,
            weight=n_c,
            error=n_c,
            slips=n_c,
            slopes=(n_c, n_q),
            response=(n_c, n_q),
            facet=n_c,
            force=n_c,
            most=n_c,
        ),
        saltation=Saltation.zeros(
            before=jump.nnz_in(1) if jump else 0,
            after=jump.nnz_out(0) if jump else 0,
            tau=n_x,
            left=n_x + 1 if layout.others else 0,
            rise=(n_e, 2),
        ),
        transition=Transition.zeros(
            asked=n_p + layout.n_mode + 2 * others if layout.others else 0,
            answer=automaton.n_y + layout.n_mode + others if layout.others else 0,
        ),
        openings=Openings(
            variable=_numbers(layout.openings),
            line=_numbers(lines),
            number=_numbers(layout.shown_openings),
            direction=_numbers([-2] * n_x if impact else []),
        ),
        impacts=Impacts.zeros(
            asked=n_p + impact.numel_in(3) if impact else 0,
            answer=_answers(automaton),
            exact=_answers(automaton),
            best=n_p + impact.numel_in(3) if impact else 0,
            touches=n_n,
            rests=n_n,
            struck=n_n,
            before=n_n,
            entry_y=n_x if impact else 0,
            entry_m=layout.n_mode if impact else 0,
            options=n_n + n_c if impact else 0,
            tried=n_n + n_c if impact else 0,
            chosen=layout.n_mode if impact else 0,
            rates=n_q if impact else 0,
            factor=(n_n + n_c, n_n + n_c) if impact else (0, 0),
            held=n_n + n_c if impact else 0,
            flight_m=layout.n_mode if impact else 0,
            last_m=layout.n_mode if impact else 0,
            last_y=n_x if impact else 0,
            slope_y=n_x if impact else 0,
            late=n_x if impact else 0,
        ),
        pivots=_pivots(n_n, n_c if impact else 0),
        planes=plane_arrays(automaton),
        starts=start_arrays(automaton, n_e, order),
        feet=foot_arrays(automaton),
    )


def _tables(order: int, exposed: list[int]) -> Tables:
    return Tables(
        damping=weights(order),
        exposed=_numbers(exposed),
        bernstein=bernstein_table(max(order, QUARTIC)),
        columns=bernstein_columns(order, VECTOR),
    )


def _pivots(n_n: int, n_c: int) -> Pivots:
    """Return the arrays of many contacts that touch."""
    n, unknowns = n_n + n_c, n_n + 3 * n_c
    return Pivots.zeros(
        takes=n,
        place=n,
        free=n,
        static=n_c,
        kinetic=n_c,
        slides=n_c,
        drag=n_n,
        unit=n + 1,
        table=(unknowns, 2 * unknowns + 2),
        basis=unknowns,
        kind=n,
        force=n,
        target=n_n,
        apart=n_n,
        wrong=n,
        instead=n,
    )


def _answers(automaton: Automaton) -> int:
    """Return the size of what a run asks of an impact."""
    return sum(automaton.impact.numel_out(k) for k in range(automaton.impact_answers)) if automaton.impact else 0


def _opening(lines: list[int], planes: Sequence[int], i: int) -> int:
    """Return the contact that opens whose friction row i is, or a component of it; -1 if none."""
    first = i - 1 if i - 1 in planes else i
    return lines.index(first) if first in lines else -1


def _room(*shape: int) -> np.ndarray:
    return np.zeros(shape)


def _numbers(given: Sequence[Any]) -> np.ndarray:
    return np.array(given, dtype=np.int64)


def _linear_equations(equations: Matrices | None, n_x: int, n_q: int) -> tuple[LinearEquations, Powers]:
    """Return the arrays of linear equations, empty for any other scene; those of a structure in addition."""
    entries = list(zip(equations.rows, equations.columns, strict=True)) if equations else []
    structure = equations if isinstance(equations, StructureMatrices) else None
    along_q, along_u, felt, _ = structure.sizes if structure else (0, 0, 0, 0)
    operators = structure.operators if structure else _room(0, 0)
    matrices = LinearEquations(
        pattern=_numbers(entries).reshape(-1, 2),
        weights=structure.weights if structure else _room(0, 0),
        operators=operators,
        places=structure.places if structure else _numbers([]).reshape(0, 2),
        own=_numbers(structure.own if structure else []),
        joint=_numbers(structure.joint if structure else []),
    )
    n = len(entries)
    powers = Powers.zeros(
        filled=2,
        row=n,
        column=n,
        entry=n,
        newest=(2, n_x),
        combined=operators.shape[1],
        given=along_q + along_u + len(matrices.own) + felt,
        answers=structure.n_r if structure else 0,
        pushed=n_q if structure else 0,
    )
    if structure:
        powers.combined[:] = operators[0]
    return matrices, powers
