"""Prepare the event loop of a scene: machine code of its series, and the initial arrays of a run."""

from collections.abc import Sequence

import casadi as ca

from symfric.codegen.columns import WithColumns
from symfric.codegen.functions import Code, compile_functions
from symfric.codegen.loop_loader import load_loop
from symfric.codegen.polynomial_sums import polynomial_sums
from symfric.lower.automaton import Automaton
from symfric.lower.structure_modes import StructureMatrices
from symfric.lower.variational_equations import Variations
from symfric.model.scene import Scene
from symfric.solve.input_segments import segments
from symfric.solve.loop.codes import STRUCTURE
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.run_arrays import limit
from symfric.solve.loop.stepping.decay_weights import exact_order
from symfric.solve.loop.stepping.series import Series
from symfric.solve.loop.workspace import SHARED, make_arrays
from symfric.solve.observables import Observables

_WRITTEN = 60  # states up to which their polynomials are evaluated by straight-line code; beyond, in a loop


def series_model(
    scene: Scene,
    automaton: Automaton,
    variants: Sequence[Series],
    wanted: Observables,
    budgets: tuple[int, int],
    tolerances: tuple[float, float],
    variations: Variations | None = None,
    n_x: int | None = None,
) -> CompiledModel:
    """Compile the machine code of a scene for the event loop.

    Parameters
    ----------
    scene : Scene
    automaton : Automaton
    variants : sequence of Series
        As for `make_arrays`; those without a series are linear equations.
    wanted : Observables
    budgets : (int, int)
        Most steps and events.
    tolerances : (float, float)
        Of a step, and the part of an acceleration by which errors may falsify a decision to stick.
    variations : Variations, optional
        From which the automaton was taken, if its states hold derivatives.
    n_x : int, optional
        States that results have; those of the scene unless given.
    """
    matrices = variants[0].matrices
    linear = matrices is not None
    series = [f for v in variants for f in (v.series, v.probe, v.unseen) if f]
    functions: list[Code] = [f.drafted() if isinstance(f, WithColumns) else f for f in series]
    rare = [f for v in variants for f in (v.prelude, v.terms) if f]
    if not linear and len(automaton.states) <= _WRITTEN:
        sums = polynomial_sums("reach", len(automaton.states), automaton.layout.n_guards, variants[0].order)
        functions.append(sums)
    jump = variations.jump if variations else None
    functions += [jump] if jump else []
    if automaton.transition:
        functions.append(_joined_transition(automaton))
    if automaton.impact:
        functions.append(_joined_impact(automaton, automaton.impact))
    code = compile_functions(functions, [*rare, joined_gauge(automaton.gauge)])
    pieces = segments([scene.inputs[i] for i in automaton.inputs], scene.horizon)
    first = make_arrays(automaton, variants, code.addresses, wanted.rows, pieces, jump)
    clock, limits = first.clock, first.limits
    clock.t_end, (clock.tolerance, clock.doubt) = scene.horizon, tolerances
    limit(limits, budgets, wanted)
    limits.n_q, limits.checked, limits.linear = automaton.n_q, first.tables.exposed.size > 0, linear
    limits.exact = exact_order(variants[0].order) if decays(scene) and not linear else 0
    if isinstance(matrices, StructureMatrices):
        limits.linear = STRUCTURE
        limits.along_q, limits.along_u, limits.felt, limits.pushes = matrices.sizes
    limits.sticker = automaton.sticks.index(True) if len(variants) > 1 else -1
    limits.edges, limits.coupled = len(automaton.at_edges), automaton.n_q * automaton.coupled
    limits.planes = len(automaton.planes)
    limits.steps, limits.holds = len(automaton.steps), _slips_jump(scene)
    limits.first_load, limits.first_other = automaton.layout.first_load, automaton.layout.first_other
    limits.first_variable, limits.first_clock = automaton.layout.first_variable, automaton.layout.first_clock
    limits.first_plane, limits.first_opening = automaton.layout.first_plane, automaton.layout.first_opening
    limits.first_crossing, limits.first_reset = automaton.layout.first_crossing, automaton.layout.first_reset
    if variations:
        limits.varied, limits.followed = variations.columns, variations.followed
        limits.directions = len(variations.directions)
        if automaton.impact:
            names = [s.name for s in automaton.parameters]
            of = [names.index(name) if name in names else -1 for name in variations.directions]
            first.openings.direction[: len(of)] = of
    loop = load_loop("symfric.solve.loop.entry", "the event loop")
    n_x = len(scene.system.states) if n_x is None else n_x
    return CompiledModel(loop, code, first, SHARED, wanted, n_x, scene.horizon)


def _slips_jump(scene: Scene) -> bool:
    """Whether an input that is not continuous moves the surface of a contact."""
    jumping = {s for s, signal in scene.inputs.items() if signal.hold or signal.samples[[0, -1]].any()}
    return any(jumping & c.slip.free_symbols for c in scene.contacts)


def decays(scene: Scene) -> bool:
    """Whether a scene may have fast decays: those of a friction law without a jump, or of a state of first order."""
    return len(scene.system.z) > scene.system.made or any(c.law.smooth for c in scene.contacts if c.along_line)


def _joined_transition(automaton: Automaton) -> ca.Function:
    """Return the transition as a function of ([y; ...; t], [p; m; hit; zero]) with one output."""
    transition = automaton.transition
    assert transition is not None
    state = ca.SX.sym("y", len(automaton.states) + 1)
    data = [ca.SX.sym(name, transition.size1_in(k)) for k, name in enumerate(transition.name_in()) if k > 1]
    out = transition(state[: transition.size1_in(0)], state[-1], *data)
    sizes = [automaton.n_y, automaton.layout.n_mode, automaton.layout.n_guards - automaton.layout.first_other]
    assert [e.numel() for e in out] == sizes, "what is written must fit the room"
    return ca.Function("transition", [state, ca.vertcat(*data)], [ca.densify(ca.vertcat(*out))])


def _joined_impact(automaton: Automaton, impact: ca.Function) -> ca.Function:
    """Return the impact as a function of ([y; ...; t], [p; data]) with one output."""
    state, p = ca.SX.sym("y", len(automaton.states) + 1), ca.SX.sym("p", impact.numel_in(2))
    data = ca.SX.sym("data", impact.numel_in(3))
    out = impact(state[: automaton.n_y], state[-1], p, data)[: automaton.impact_answers]
    return ca.Function("impact", [state, ca.vertcat(p, data)], [ca.densify(ca.vertcat(*out))], {"cse": True})


def joined_gauge(gauge: ca.Function) -> ca.Function:
    """Return the gauge as a function of ([y; t], p) with one output, the calling convention of the machine code."""
    state, p = ca.SX.sym("y", gauge.nnz_in(0) + 1), ca.SX.sym("p", gauge.nnz_in(2))
    return ca.Function("gauge", [state, p], [ca.vertcat(*gauge(state[:-1], state[-1], p))])
