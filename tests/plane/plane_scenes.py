"""Random bodies in the plane with one to three planar contacts, for the package and for the reference.

`drawn(seed)` returns a `PlaneScene`: arrays and numbers. `.problem()` is what `plane_reference` takes, `.scene()` the scene
of the package. The seed alone decides all: 1 to 3 masses, contacts on the ground, on moving tables or between masses,
springs, gyroscopic and damping forces, harmonic forces, Coulomb laws with mu_s > mu_k or mu_s = mu_k, Stribeck laws, loads
constant or harmonic in time, masses constant or dependent on the position.
"""

import math
from dataclasses import dataclass

import numpy as np
import sympy as sp
from scipy.optimize import minimize_scalar

from tests.plane.plane_reference import Planar, Problem


@dataclass(frozen=True)
class Table:
    """A contact: rows (2, n); load ``N0 (1 + swell cos(w t))``; table velocity ``belt + shake cos(w t)``; law numbers."""

    rows: np.ndarray
    load: float
    swell: float
    belt: np.ndarray
    shake: np.ndarray
    mu_s: float
    mu_k: float
    v_s: float | None  # of Stribeck's law; None for Coulomb friction

    def kinetic(self, v):
        return self.mu_k + (self.mu_s - self.mu_k) * math.exp(-v / self.v_s) if self.v_s else self.mu_k


@dataclass(frozen=True)
class PlaneScene:
    """``(M + swing diag(M) sin(q_0)) u' = -K q - (D + G) u + f cos(w t) + pull + friction``, G skew-symmetric."""

    M: np.ndarray
    swing: float
    K: np.ndarray
    D: np.ndarray
    G: np.ndarray
    f: np.ndarray
    pull: np.ndarray
    w: float
    tables: tuple[Table, ...]
    start: np.ndarray
    horizon: float

    @property
    def n(self):
        return len(self.pull)

    def problem(self):
        """Return the scene for `plane_reference.Simulator` and `regularised`."""

        def contact(c):
            return Planar(
                c.rows,
                lambda t, q, u: c.load * (1 + c.swell * math.cos(self.w * t)),
                c.mu_s,
                c.kinetic,
                lambda t: c.belt + c.shake * math.cos(self.w * t),
                lambda t: -self.w * c.shake * math.sin(self.w * t),
            )

        def force(t, q, u):
            return -self.K @ q - (self.D + self.G) @ u + self.f * math.cos(self.w * t) + self.pull

        def mass(q):
            return self.M + self.swing * np.diag(np.diag(self.M)) * math.sin(q[0])

        contacts = tuple(contact(c) for c in self.tables)
        return Problem(mass, force, contacts, self.start, self.horizon)

    def scene(self):
        """Return the scene of the package; contacts are "c0", "c1", ..., states x0, ..., u0, ..."""
        import symfric as sf

        q = sp.symbols(f"x:{self.n}", real=True)
        u = sp.symbols(f"u:{self.n}", real=True)
        wave = sp.cos(self.w * sf.TIME)
        K, damping = sp.Matrix(self.K), sp.Matrix(self.D + self.G)
        force = -K * sp.Matrix(q) - damping * sp.Matrix(u) + sp.Matrix(self.f) * wave + sp.Matrix(self.pull)
        mass = sp.Matrix(self.M)
        if self.swing:
            mass += self.swing * sp.sin(q[0]) * sp.diag(*map(sp.Float, np.diag(self.M)))
        contacts = []
        for k, c in enumerate(self.tables):
            moved = [
                sp.Float(b) + sp.Float(s) * wave if s else sp.Float(b) for b, s in zip(c.belt, c.shake, strict=True)
            ]
            slip = tuple((sp.Matrix([r]) * sp.Matrix(u))[0] - m for r, m in zip(c.rows, moved, strict=True))
            law = sf.laws.stribeck(c.mu_s, c.mu_k, c.v_s) if c.v_s else sf.laws.coulomb(c.mu_s, c.mu_k)
            contacts.append(sf.Contact(f"c{k}", slip, c.load * (1 + c.swell * wave) if c.swell else c.load, law))
        initial = dict(zip([*q, *u], map(float, self.start), strict=True))
        return sf.Scene(sf.System(list(q), list(u), mass.tolist(), list(force)), contacts, {}, initial, self.horizon)


def _definite(rng, n, low, high):
    """Return a symmetric positive definite matrix with eigenvalues between two numbers."""
    Q = np.linalg.qr(rng.normal(size=(n, n)))[0]
    A = Q @ np.diag(rng.uniform(low, high, n)) @ Q.T
    return (A + A.T) / 2


def _rows(rng, masses, kind, taken):
    """Return rows of a contact that is not yet there: of a mass on a table, or between two masses."""
    places = [(i, None) for i in range(masses)]
    if kind:
        places += [(i, j) for i in range(masses) for j in range(i)]
    free = [p for p in places if p not in taken]
    place = free[rng.integers(len(free))]
    taken.append(place)
    rows = np.zeros((2, 2 * masses))
    rows[:, 2 * place[0] : 2 * place[0] + 2] = np.eye(2)
    if place[1] is not None:
        rows[:, 2 * place[1] : 2 * place[1] + 2] = -np.eye(2)
    return rows


def _independent(tables, new):
    stacked = np.vstack([*(c.rows for c in tables), new])
    return np.linalg.matrix_rank(stacked) == len(stacked)


def drawn(seed, masses=None, contacts=None, forced=None):
    """Return the scene of a seed; the number of masses, of contacts and whether it is forced may be given.

    Contacts never depend on each other, so that their forces at rest are unique.
    """
    rng = np.random.default_rng(seed)
    masses = int(rng.integers(1, 4)) if masses is None else masses
    contacts = int(rng.integers(1, masses + 1)) if contacts is None else contacts
    forced = bool(rng.random() < 0.6) if forced is None else forced
    n = 2 * masses
    M = _definite(rng, n, 0.5, 2.0)
    K, D = _definite(rng, n, 0.3, 3.0), _definite(rng, n, 0.0, 0.15)
    A = rng.normal(size=(n, n)) * (0.3 if rng.random() < 0.5 else 0.0)
    w = rng.uniform(0.4, 2.5)
    tables, taken = [], []
    while len(tables) < contacts:
        rows = _rows(rng, masses, rng.random() < 0.4, taken)
        if not _independent(tables, rows):
            continue
        on_ground = np.all(rows.sum(axis=1) == 1)
        belt = rng.normal(size=2) * 0.3 * (on_ground and rng.random() < 0.4)
        shake = rng.normal(size=2) * 0.3 * (on_ground and forced and rng.random() < 0.3)
        mu_s = rng.uniform(0.2, 0.6)
        mu_k = mu_s * (1.0 if rng.random() < 0.3 else rng.uniform(0.5, 0.95))
        v_s = rng.uniform(0.1, 0.5) if mu_k < mu_s and rng.random() < 0.4 else None
        swell = 0.3 * (forced and rng.random() < 0.3)
        tables.append(Table(rows, rng.uniform(1.0, 3.5), swell, belt, shake, mu_s, mu_k, v_s))
    swing = 0.2 * (rng.random() < 0.3)
    pull, f = rng.normal(size=n) * 0.2, rng.normal(size=n) * (0.8 if forced else 0.0)
    start = np.concatenate([rng.normal(size=n), rng.normal(size=n)])
    return PlaneScene(M, swing, K, D, A - A.T, f, pull, w, tuple(tables), start, 8.0)


def drawn_bodies(seed, bodies=None):
    """Return bodies on two to four feet each, which turn by small angles; at rest the forces of the feet are not unique.

    Friction does not drop from rest to slip: feet that creep under a regularised law reach such a drop one after the
    other, and start earlier than those whose forces may be any that hold.
    """
    rng = np.random.default_rng(seed)
    bodies = int(rng.integers(1, 3)) if bodies is None else bodies
    n = 3 * bodies
    M = np.diag(np.concatenate([[m, m, m * rng.uniform(0.15, 0.6)] for m in rng.uniform(0.6, 1.6, bodies)]))
    w = rng.uniform(0.5, 2.5)
    K, D = _definite(rng, n, 0.2, 1.5), _definite(rng, n, 0.0, 0.1)
    tables = []
    for body in range(bodies):
        feet, turn = int(rng.integers(2, 5)), rng.uniform(0, 2 * np.pi)
        for k in range(feet):
            angle, radius = turn + 2 * np.pi * k / feet + rng.uniform(-0.3, 0.3), rng.uniform(0.5, 1.1)
            rows = np.zeros((2, n))
            rows[:, 3 * body : 3 * body + 2] = np.eye(2)
            rows[:, 3 * body + 2] = radius * np.array([-math.sin(angle), math.cos(angle)])
            mu, swell = rng.uniform(0.2, 0.5), 0.3 * (rng.random() < 0.3)
            tables.append(Table(rows, rng.uniform(0.3, 1.2), swell, np.zeros(2), np.zeros(2), mu, mu, None))
    f, pull = rng.normal(size=n) * rng.uniform(0.3, 0.9), rng.normal(size=n) * 0.1
    start = np.concatenate([rng.normal(size=n) * 0.4, rng.normal(size=n) * 0.6])
    return PlaneScene(M, 0.0, K, D, np.zeros((n, n)), f, pull, w, tuple(tables), start, 8.0)


def before_a_fast_turn(scene, motion, eps):
    """Return a time before any contact whose friction drops turns at a speed at which one regularised over eps holds it.

    `motion` is one of `plane_reference.Simulator`.
    """
    end = scene.horizon
    for c in scene.tables:
        if c.mu_s == c.mu_k or c.v_s:
            continue

        def speed(t, c=c):
            u = motion.at(t)[scene.n :]
            return math.hypot(*(c.rows @ u - c.belt - c.shake * math.cos(scene.w * t)))

        times = np.linspace(0, scene.horizon, 2001)
        speeds = np.array([speed(t) for t in times])
        for k in np.flatnonzero((speeds[1:-1] < speeds[:-2]) & (speeds[1:-1] <= speeds[2:])) + 1:
            low = minimize_scalar(speed, bounds=(times[k - 1], times[k + 1]), method="bounded", options={"xatol": 1e-9})
            if 1e-13 < low.fun < 20 * eps and speed(min(low.x + 1e-5, scene.horizon)) > 1e-13:  # it does not stop
                end = min(end, times[k] - 0.1)
    return end


def before_a_near_coincidence(scene, motion, apart):
    """Return a time before two events that are so little apart that regularised friction may exchange them."""
    times = [t for t, _, _ in motion.events]
    near = [a for a, b in zip(times, times[1:], strict=False) if 1e-9 < b - a < apart]
    return min(near, default=scene.horizon + 0.1) - 0.1
