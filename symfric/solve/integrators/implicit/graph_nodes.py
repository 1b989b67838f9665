"""Replace parts of CasADi graphs, not only their symbols, by other graphs."""

from collections.abc import Sequence

import casadi as ca

from symfric.scalars import applied


def nodes_given(places: ca.SX, graphs: ca.SX, out: Sequence[ca.SX]) -> list[ca.SX]:
    """Return expressions in which some parts are other graphs.

    Parameters
    ----------
    places : SX, shape (n,)
        The parts; equal parts of `out` are recognised if they were made in the same way.
    graphs : SX, shape (n,)
        What stands in their place; depends on none of them.
    out : sequence of SX

    Returns
    -------
    list of SX
    """
    whole = ca.cse(ca.densify(ca.vertcat(places, *(ca.vec(ca.densify(e)) for e in out))))
    free, n = ca.symvar(whole), places.numel()
    # a first pass finds which instruction makes each part, a second one makes everything again with the graphs
    program = ca.Function("whole", free, [whole])
    made, last = dict[int, int](), dict[int, int]()
    for k in range(program.n_instructions()):
        if program.instruction_id(k) == ca.OP_OUTPUT:
            place = program.instruction_output(k)[1]
            if place < n:
                made[last[program.instruction_input(k)[0]]] = place
        else:
            last[program.instruction_output(k)[0]] = k
    work, entries = dict[int, ca.SX](), [ca.SX(0)] * whole.numel()
    for k in range(program.n_instructions()):
        kind, into, of = program.instruction_id(k), program.instruction_output(k), program.instruction_input(k)
        if kind == ca.OP_OUTPUT:
            entries[into[1]] = work[of[0]]
            continue
        if k in made:
            work[into[0]] = graphs[made[k]]
        elif kind == ca.OP_INPUT:
            work[into[0]] = free[of[0]]
        elif kind == ca.OP_CONST:
            work[into[0]] = ca.SX(program.instruction_constant(k))
        else:
            work[into[0]] = applied(kind, [work[i] for i in of])
    result, first = [], n
    for e in out:
        result.append(ca.reshape(ca.vertcat(*entries[first : first + e.numel()]), e.shape) if e.numel() else ca.SX(e))
        first += e.numel()
    return result
