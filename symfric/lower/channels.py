"""The variational equations of a scene from matrices, split into a constant part and a few channels.

With the rows of a structure, through which alone its contacts and loads feel the motion, the slopes of the rates are

    A(t) = A0 + B D(t) R,      D(t) = d phi/d xi,   xi = R y,

where phi are the friction forces of the contacts that slip, the forces along rows, those on single coordinates and the
rates of first-order states; B is what they accelerate. Sticking contacts hold their slips at zero by forces
``-(J M^-1 J^T)^-1 J a`` with the accelerations a without them, which adds as many channels and no dynamics of its own.
A0, B and R are numbers; D is small.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symfric.errors import NoRoute
from symfric.lower.constraint_forces import HOLDS
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.constant_parameters import constants
from symfric.model.scene import Scene

_MOST = 0.5  # channels over states beyond which there is nothing to gain


@dataclass(frozen=True, eq=False)
class Channels:
    """The parts of ``A(t) = A0 + B D R`` for a mode.

    Attributes
    ----------
    n : int
        Number of coordinates.
    mass, stiffness, damping : ndarray, shape (n, n)
        Without what parameters multiply.
    scaled : tuple of ndarray
        What the factors multiply in the stiffness.
    factors : casadi.Function
        ``p -> factors``.
    rows : ndarray, shape (n_xi, n_x)
        R.
    pushes : ndarray, shape (n_x, n_phi)
        B while nothing sticks.
    slips, spread : ndarray, shape (n_c, n) and (n, n_c)
        J, and M^-1 J^T.
    slopes : casadi.Function
        ``(xi, y, t, p, m) -> D``, shape (n_phi, n_xi).
    """

    n: int
    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    scaled: tuple[np.ndarray, ...]
    factors: ca.Function
    rows: np.ndarray
    pushes: np.ndarray
    slips: np.ndarray
    spread: np.ndarray
    slopes: ca.Function

    def free(self, p: np.ndarray) -> np.ndarray:
        """Return A0 for parameters p, shape (n_x, n_x)."""
        n, n_x = self.n, self.rows.shape[1]
        K = self.stiffness.copy()
        for factor, matrix in zip(np.array(self.factors(p)).ravel(), self.scaled, strict=True):
            K += factor * matrix
        slopes = np.zeros((n_x, n_x))
        slopes[:n, n : 2 * n] = np.eye(n)
        slopes[n : 2 * n, : 2 * n] = -np.linalg.solve(self.mass, np.hstack([K, self.damping]))
        return slopes

    def held(self, m: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return B in a mode, and what sticking adds: columns and rows whose product adds to A0."""
        n, on = self.n, np.flatnonzero(m[: len(self.slips)] == HOLDS)
        if not on.size:
            return self.pushes, np.zeros((len(free), 0)), np.zeros((0, len(free)))
        J, back = self.slips[on], np.zeros((len(free), on.size))
        back[n : 2 * n] = self.spread[:, on]
        gain = np.linalg.lstsq(J @ self.spread[:, on], J, rcond=None)[0]  # forces by accelerations
        wide = np.hstack([np.zeros((on.size, n)), gain, np.zeros((on.size, len(free) - 2 * n))])
        return self.pushes - back @ (wide @ self.pushes), -back, wide @ free


def channels_of(scene: Scene, varied: frozenset[str] = frozenset()) -> Channels:
    """Return the channels of a scene.

    Raises
    ------
    NoRoute
        If its equations are not of this form; the message names what is not.
    """
    part = scene.system.linear
    if part is None or scene.system.mass is not None:
        raise NoRoute("the masses are expressions")
    if scene.contacts_that_open:
        raise NoRoute("a contact opens")
    fixed = constants(scene, varied)
    for c in scene.contacts:
        if c.law.steep or c.slip.free_symbols & {*scene.system.q, *(s for s, r in part.rows.items() if r.of == "q")}:
            raise NoRoute(f"contact {c.name!r} has a law without series, or a slip that depends on coordinates")
    feel = ca.SX.sym("xi", len(part.rows))
    rows = dict(zip(part.rows, ca.vertsplit(feel), strict=True))
    model = ContactDynamics(scene.system, scene.contacts, scene.parameters, tuple(scene.inputs), fixed, rows=rows)
    if any(ca.depends_on(s.moving_limit, ca.vertcat(model.y, model.t, feel)) for s in model.springs):
        raise NoRoute("the load of a contact behind a spring varies")
    system, n, n_x = model.system, model.q.numel(), model.y.numel()
    assert system.linear is not None
    names = list(system.linear.rows)
    weights = np.zeros((len(names), n_x))
    for k, s in enumerate(names):
        row = system.linear.rows[s]
        weights[k, slice(0, n) if row.of == "q" else slice(n, 2 * n)] = row.weights
    slips = np.array([system.slopes(c.slip) for c in model.contacts], dtype=float).reshape(-1, n)
    entries = [(i, e) for i, e in enumerate(system.force) if e != 0]
    sticks = model.s > 0.5
    phi = [ca.if_else(sticks[i], model.given(i), model.sliding[i]) for i in range(len(model.contacts))]
    phi += [model.read(e) for _, e in entries]
    phi += [model.read(e) for e, _ in system.linear.loads]
    along = [*slips, *(np.eye(n)[i] for i, _ in entries), *(r for _, r in system.linear.loads)]
    mass = system.linear.M.toarray()
    pushes = np.zeros((n_x, len(along) + n_x - 2 * n))
    pushes[n : 2 * n, : len(along)] = np.linalg.solve(mass, np.array(along, dtype=float).reshape(-1, n).T)
    pushes[2 * n :, len(along) :] = np.eye(n_x - 2 * n)
    out = ca.vertcat(*phi, model.z_rate)
    own = [k for k in range(n_x) if ca.depends_on(out, model.y[k])]
    xi = ca.vertcat(feel, *(model.y[k] for k in own))
    if xi.numel() > _MOST * n_x:
        raise NoRoute("the forces depend on too many of the states")
    mode = ca.vertcat(model.s, model.d, *model.switches.signs, *(s.variables for s in model.springs))
    slopes = ca.densify(ca.jacobian(out, xi))
    arguments = [feel, model.y, model.t, model.p, mode]
    scaled = [model.read(e) for e, _ in system.linear.scaled]
    zeros = np.zeros((n, n))
    return Channels(
        n=n,
        mass=mass,
        stiffness=system.linear.K.toarray(),
        damping=zeros if system.linear.C is None else system.linear.C.toarray(),
        scaled=tuple(A.toarray() for _, A in system.linear.scaled),
        factors=ca.Function("factors", [model.p], [ca.vertcat(*scaled) if scaled else ca.SX(0, 1)]),
        rows=np.vstack([weights, np.eye(n_x)[own]]),
        pushes=pushes,
        slips=slips,
        spread=np.linalg.solve(mass, slips.T),
        slopes=ca.Function("slopes", arguments, [slopes], ["xi", "y", "t", "p", "m"], ["D"]),
    )
