"""Scenes from matrices that are linear between events: what costs a product with every coordinate, and a small rest.

With a_0 = -M^-1 (K q + C u + sum_k s_k A_k q) the accelerations of the structure alone,

    u' = a_0 + B phi,    (phi, z', guards, rows) = D (xi, y_own, b) + d_1 t + d_0,    xi = (R_q q, R_u u),   b = F a_0,

where xi is what contacts, loads and outputs feel of the motion, b what the contacts feel of the accelerations, and phi
the forces of contacts and loads; see `symfric.lower.contact_space`. The mode enters D and d alone, which have as many
entries as contacts and outputs need. A sticking contact therefore costs no more than its rows, whatever the structure.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.automaton import observed
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.lower.contact_space import ContactSpace, contact_space
from symfric.lower.held_velocities import HeldVelocities, held_velocities
from symfric.lower.linear_modes import Matrices, matrices_of
from symfric.model.constant_parameters import constants
from symfric.model.linear_part import LinearPart
from symfric.model.scene import Scene

_DENSE = 0.25  # part of the entries of M^-1 K beyond which a product takes all of them


class OtherForm(NoRoute):
    """Equations that are not those of a structure with contacts along constant rows; they may still be linear."""


@dataclass(frozen=True, eq=False)
class StructureMatrices(Matrices):
    """The equations of a structure in every mode; the arrays are numbers.

    The data are ``(p, m) -> (entries of D, d_1, d_0, factors s_k)``, the columns of D as above, the rows: phi, rates of
    first-order states, rates that contacts hold which depend on one velocity alone, for each of `joint` whether
    contacts hold it together and its rate then, guards, observables.

    Attributes
    ----------
    weights : ndarray, shape (k, n)
        R_q, R_u, F and the transposed B, one below the other.
    sizes : (int, int, int, int)
        Numbers of their rows.
    joint : tuple of int
        The velocities that several contacts can hold together.
    own : tuple of int
        The states that are felt one by one.
    operators : ndarray, shape (1 + n_s, n_o)
        Entries of -M^-1 (K, C), and of what each factor multiplies: (2 n, n), or (n, n) without damping, the effect of
        one state after the other if they are dense, else those at `places`.
    places : ndarray, shape (n_o, 2) or (0, 2)
        Acceleration and state of every entry.
    """

    weights: np.ndarray
    sizes: tuple[int, int, int, int]
    joint: tuple[int, ...]
    own: tuple[int, ...]
    operators: np.ndarray
    places: np.ndarray


def structure_matrices(
    scene: Scene, rows: Sequence[sp.Expr], varied: frozenset[str] = frozenset()
) -> StructureMatrices:
    """Return the equations of a scene from matrices, and of the observables.

    Raises
    ------
    OtherForm
        If the equations are not of this form; the message names what is not.
    NoRoute
        If they are not linear between events.
    """
    part = scene.system.linear
    if part is None or scene.system.mass is not None:
        raise OtherForm("the masses are expressions")
    if scene.contacts_that_open:
        raise OtherForm("a contact opens")
    moved = {*scene.system.q, *(s for s, r in part.rows.items() if r.of == "q")}
    for c in scene.contacts:
        if c.slip.free_symbols & moved:
            raise OtherForm(f"the slip of contact {c.name!r} depends on coordinates")
    feel = ca.SX.sym("xi", len(part.rows))
    known = dict(zip(part.rows, ca.vertsplit(feel), strict=True))
    fixed = constants(scene, varied)
    model = ContactDynamics(scene.system, scene.contacts, scene.parameters, tuple(scene.inputs), fixed, rows=known)
    if any(ca.depends_on(s.moving_limit, ca.vertcat(model.y, feel)) for s in model.springs):
        raise OtherForm("the load of a contact behind a spring depends on the motion")
    n, part = model.q.numel(), model.system.linear
    assert part is not None
    unheld = model.friction_unless_held(tested=False)  # first, because this order is that of the switches
    pushes, loads = _loads(model, part)
    mass, slips = part.M.toarray(), _slips(model)
    space = contact_space(ca.SX(ca.DM(mass)), ca.SX(ca.DM(slips))) if len(slips) else None
    spread = np.linalg.solve(mass, pushes.T).T
    felt = ca.SX.sym("b", 0 if space is None else space.felt.rows())
    phi, friction, together = _forces(model, space, unheld, felt, spread, slips, loads)
    guards, observables, _ = observed(model, friction, rows)
    held = [-model.drift[i] / factor if place >= 0 else ca.SX(0) for i, (place, factor) in _anchors(model)]
    held += [e for pair in zip(together.held, together.rates, strict=True) for e in pair]
    forces = ca.vertcat(phi, model.z_rate, *held)
    out = ca.vertcat(forces, guards, observables)
    own = tuple(k for k in range(model.y.numel()) if ca.depends_on(out, model.y[k]))
    order = [k for of in ("q", "u") for k, s in enumerate(part.rows) if part.rows[s].of == of]
    given = ca.vertcat(feel[order], model.y[list(own)], felt)
    mode = ca.vertcat(model.s, model.d, *model.switches.signs, *(s.variables for s in model.springs))
    factors = ca.vertcat(*(model.read(e) for e, _ in part.scaled))
    words = "the forces or a friction law are", "a guard is", "a wanted output is"
    parts = list(zip((forces, guards, observables), words, strict=True))
    small = matrices_of(parts, given, model.t, model.p, mode, factors)
    response = np.zeros((0, n)) if space is None else space.response.full().T
    rows_of = {of: [r.weights for r in part.rows.values() if r.of == of] for of in ("q", "u")}
    stack = [rows_of["q"], rows_of["u"], [] if space is None else space.felt.full(), [*response, *spread]]
    operators, places = _operators(part)
    return StructureMatrices(
        **vars(small),
        weights=np.array([row for rows in stack for row in rows], dtype=float).reshape(-1, n),
        sizes=(len(stack[0]), len(stack[1]), len(stack[2]), len(stack[3])),
        joint=tuple(together.places),
        own=own,
        operators=operators,
        places=places,
    )


def _slips(model: ContactDynamics) -> np.ndarray:
    rows = [model.system.slopes(c.slip) for c in model.contacts]
    if not all(isinstance(row, np.ndarray) for row in rows):
        raise OtherForm("a slip depends on parameters other than by a speed")
    return np.array(rows, dtype=float).reshape(-1, model.q.numel())


def _anchors(model: ContactDynamics) -> list[tuple[int, tuple[int, float]]]:
    return [(i, model.anchor(i)) for i in range(len(model.contacts))]


def _loads(model: ContactDynamics, part: LinearPart) -> tuple[np.ndarray, ca.SX]:
    """Return the rows along which forces act, and the forces."""
    n = model.q.numel()
    entries = [(np.eye(n)[i], e) for i, e in enumerate(model.system.force) if e != 0]
    pairs = [*entries, *((row, e) for e, row in part.loads)]
    return np.array([row for row, _ in pairs], dtype=float).reshape(-1, n), model.vector([e for _, e in pairs])


def _forces(
    model: ContactDynamics,
    space: ContactSpace | None,
    unheld: ca.SX,
    felt: ca.SX,
    spread: np.ndarray,
    slips: np.ndarray,
    loads: ca.SX,
) -> tuple[ca.SX, ca.SX, HeldVelocities]:
    """Return the effect of contacts in their directions and the loads, the friction forces, and what contacts hold."""
    if space is None:
        return loads, ca.SX(0, 1), HeldVelocities([], [], [])
    friction, pulled = ca.SX(unheld), space.factor @ unheld
    sticking, drift, holds = model.held_by_sticking
    if not sticking:
        return ca.vertcat(pulled, loads), friction, HeldVelocities([], [], [])
    applied = felt + ca.sparsify(space.felt @ ca.DM(spread.T)) @ loads + pulled
    basis = space.basis(sticking, holds, tested=False)
    held, gain = basis.forces(applied, drift)
    rows, moving = ca.SX(ca.DM(slips[sticking])), ca.vertcat(model.y, model.t)
    together = held_velocities(rows, model.mass, basis, drift, moving, space)
    for k, i in enumerate(sticking):
        friction[i] += held[k]
    return ca.vertcat(pulled + gain, loads), friction, together


def _operators(part: LinearPart) -> tuple[np.ndarray, np.ndarray]:
    """Return the entries of -M^-1 (K, C) and of what factors multiply, and where they are."""
    import scipy.sparse as sps  # slow to import

    n = part.M.shape[0]
    own = [part.K] if part.C is None else [part.K, part.C]
    empty = [sps.csr_array((n, n))] * (len(own) - 1)
    stacks = [sps.hstack(e) for e in (own, *([A, *empty] for _, A in part.scaled))]
    operators = [-_accelerations(part.M, e) for e in stacks]
    filled = sum((abs(e) for e in operators[1:]), start=abs(operators[0])).tocoo()
    if filled.nnz > _DENSE * filled.shape[0] * filled.shape[1]:
        return np.array([e.toarray().T.ravel() for e in operators]), np.zeros((0, 2), dtype=np.int64)
    order = np.argsort(filled.coords[1], kind="stable")  # one sum does not wait for its own last term
    rows, columns = (e[order] for e in filled.coords)
    entries = np.array([e.tocsr()[rows, columns] for e in operators]).reshape(len(operators), -1)
    return entries, np.column_stack([rows, columns]).astype(np.int64)


def _accelerations(mass: Any, forces: Any) -> Any:
    """Return M^-1 forces, sparse."""
    import scipy.sparse as sps

    diagonal = mass.diagonal()
    if mass.nnz == np.count_nonzero(diagonal):
        return sps.csr_array(sps.diags_array(1 / diagonal) @ forces)
    return sps.csr_array(np.linalg.solve(mass.toarray(), forces.toarray()))
