"""Nonlinear program of optimal control with dry friction: finite elements of variable length, one mode in each.

Within an element every contact slips in one direction or sticks, because the complementarity of slip and friction is
imposed across all its collocation points. Modes therefore change between elements only, whose lengths are variables, so
that event times are not limited by a step size. Radau collocation. A. Nurkanovic, M. Sperl, S. Albrecht, M. Diehl,
Finite elements with switch detection, Numer. Math. 156 (2024); the friction is in step form, ``-N mu(|s|)(2 a - 1)``
with ``s = p - n``, ``0 <= n, 0 <= a`` and ``0 <= p, 0 <= 1 - a`` complementary.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import OPTIMISER, SYMBOLIC, alone
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.excitation import is_excited
from symfric.model.in_plane import refuse_planes
from symfric.model.laws.law import refuse_memory
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.model.system import Contact

FIRST, LAST = 3, 7  # collocation points in an element: while modes are unknown, and with fixed modes
SLIDE = 1e-6  # slip relative to the largest one below which an element sticks


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Rates, slips and cost of a scene as CasADi functions.

    Attributes
    ----------
    rate : Function ``(x, w, a, speed) -> x'``
    slip : Function ``(x, w) -> s``
    cost : Function ``(x, w) -> integrand``, or None where the time is minimised
    n_q, n_x, n_w, n_c : int
        Coordinates, states, controls and contacts.
    start : ndarray, shape (n_x,)
    """

    rate: ca.Function
    slip: ca.Function
    cost: ca.Function | None
    n_q: int
    n_x: int
    n_w: int
    n_c: int
    start: np.ndarray


@alone(SYMBOLIC)
def dynamics(scene: Scene, controls: Sequence[sp.Symbol], cost: sp.Expr | None) -> Dynamics:
    """Lower a scene whose controls are parameters.

    Raises
    ------
    SceneError
        If the scene depends on time or on inputs, has kinks, or a law whose static friction is not its kinetic one.
    """
    system = scene.system
    numbers = scene.where(dict.fromkeys(controls, 0.0)).numbers()
    if is_excited(scene, frozenset(s.name for s in controls)):
        raise SceneError("the scene depends on time or on a sampled input; optimal control takes what is autonomous")
    refuse_planes(scene.contacts, "optimal control")
    for contact in scene.contacts:
        _check_law(contact, numbers)
    w = ca.SX.sym("w", len(controls))
    a, speed = ca.SX.sym("a", len(scene.contacts)), ca.SX.sym("speed", len(scene.contacts))
    fixed = {s: sp.Float(numbers[s]) for s in scene.parameters if s not in controls}
    free = dict(zip(controls, ca.vertsplit(w), strict=True))
    model = ContactDynamics(system, scene.contacts, scene.parameters, (), fixed, free)
    mu = ca.vertcat(*(model.kinetic(k, speed[k]) for k in range(a.numel())))
    friction = -model.load * mu * (2 * a - 1)  # in step form
    acceleration = model.solve(model.force + model.slopes.T @ friction)
    rates = ca.vertcat(model.u, acceleration, model.z_rate)
    integrand = None if cost is None else model.read(cost)
    if model.switches.signs:
        raise SceneError("a force or a law of the scene has a kink; optimal control takes smooth ones")
    return Dynamics(
        ca.Function("rate", [model.y, w, a, speed], [rates]),
        ca.Function("slip", [model.y, w], [model.slip]),
        None if integrand is None else ca.Function("cost", [model.y, w], [integrand]),
        len(system.q),
        len(system.states),
        len(controls),
        len(scene.contacts),
        np.array([numbers[s] for s in system.states]),
    )


@dataclass(frozen=True)
class TranscriptionSizes:
    """Units of the program: sizes of states, controls, time, slips and cost.

    Attributes
    ----------
    x, w, slip : ndarray
        Of every state, control and contact.
    time, cost : float
    """

    x: np.ndarray
    w: np.ndarray
    slip: np.ndarray
    time: float
    cost: float


def sizes_of(
    model: Dynamics, bounds: np.ndarray, end: dict[int, float], time: tuple[float, float]
) -> TranscriptionSizes:
    """Return the natural sizes of a problem, from its distances and the accelerations of its controls.

    The program in these sizes does not depend on the units of mass, length and time.
    """
    n, goal = model.n_q, model.start.copy()
    for k, value in end.items():
        goal[k] = value
    shares, still = np.full(model.n_c, 0.5), np.zeros(model.n_c)  # without friction
    corners = [np.array(c) for c in itertools.product(*bounds)]
    rates = np.array([np.array(model.rate(x, w, shares, still)).ravel() for x in (model.start, goal) for w in corners])
    rate, moved = np.max(np.abs(rates), axis=0), np.abs(goal - model.start)
    fastest = rate[n : 2 * n]
    able = fastest > 0
    natural = [*np.sqrt(moved[:n][able] / fastest[able]), *(moved[n : 2 * n][able] / fastest[able])]
    low, high = time
    middle = float(np.sqrt(low * high)) if low > 0 else 0.3 * high
    duration = float(np.clip(max(natural, default=0.0) or middle, low, high))
    length = np.where(moved[:n] > 0, moved[:n], np.maximum(fastest * duration**2, moved[n : 2 * n] * duration))
    length = np.where(length > 0, length, np.max(length) or 1.0)
    others = np.maximum(np.maximum(np.abs(goal), np.abs(model.start)), rate * duration)[2 * n :]
    x = np.concatenate([length, length / duration, np.where(others > 0, others, 1.0)])
    slips = [np.abs(np.array(model.slip(x * e, np.zeros(model.n_w))).ravel()) for e in np.eye(x.size)]
    slip = np.sum(slips, axis=0) if model.n_c else np.zeros(0)
    w = np.max(np.abs(bounds), axis=1)
    cost = 1.0
    if model.cost is not None:
        cost = max((abs(float(model.cost(e, c))) for e in (model.start, goal) for c in corners), default=0.0) or 1.0
    return TranscriptionSizes(x, np.where(w > 0, w, 1.0), np.where(slip > 0, slip, 1.0), duration, cost * duration)


def dimensionless(model: Dynamics, sizes: TranscriptionSizes) -> Dynamics:
    """Return a model whose states, controls, slips, time and cost are in the given sizes."""
    x, w = ca.SX.sym("x", model.n_x), ca.SX.sym("w", model.n_w)
    a, speed = ca.SX.sym("a", model.n_c), ca.SX.sym("speed", model.n_c)
    state, control = x * sizes.x, w * sizes.w
    cost = None
    if model.cost is not None:
        cost = ca.Function("cost", [x, w], [model.cost(state, control) * (sizes.time / sizes.cost)])
    return replace(
        model,
        rate=ca.Function(
            "rate", [x, w, a, speed], [model.rate(state, control, a, speed * sizes.slip) * sizes.time / sizes.x]
        ),
        slip=ca.Function("slip", [x, w], [model.slip(state, control) / sizes.slip]),
        cost=cost,
        start=model.start / sizes.x,
    )


def _check_law(contact: Contact, numbers: Mapping[sp.Symbol, float]) -> None:
    law = contact.law
    refuse_memory(law, "optimal control")
    rest = law.kinetic.subs(SPEED, 0).subs(numbers)
    if law.breaks or abs(float(rest) - float(sp.sympify(law.stick).subs(numbers))) > 1e-12 * abs(float(rest)):
        raise SceneError(
            f"the law of contact {contact.name!r} has a static friction above the kinetic one, or breaks; optimal "
            "control takes one smooth branch that begins at the static friction"
        )


class NonlinearProgram:
    """The nonlinear program of a sequence of elements.

    Parameters
    ----------
    model : Dynamics
    elements : int
    degree : int
        Degree of the controls in an element, 0 or 1.
    bounds : ndarray, shape (n_w, 2)
    end : dict of int to float
        Values of states at the end.
    time : (float, float)
    modes : ndarray of int, shape (elements, n_c), optional
        Of every contact in every element; without them the complementarity is relaxed by the parameter ``relax``.
    parts : int
        Polynomials of equal length in an element: a law that is steep needs several.
    """

    def __init__(
        self,
        model: Dynamics,
        elements: int,
        degree: int,
        bounds: np.ndarray,
        end: Mapping[int, float],
        time: tuple[float, float],
        modes: np.ndarray | None = None,
        parts: int = 1,
    ):
        self.model, self.elements, self.degree, self.modes, self.parts = model, elements, degree, modes, parts
        self.tau = ca.collocation_points(FIRST if modes is None else LAST, "radau")
        self.slope, _, self.weight = ca.collocation_coeff(self.tau)
        # collocation points on an element, 0 to 1
        self.grid = [(part + tau) / parts for part in range(parts) for tau in self.tau]
        self.variables: list[ca.SX] = []
        self.low: list[float] = []
        self.high: list[float] = []
        self.rules: list[ca.SX] = []
        self.least: list[float] = []
        self.most: list[float] = []
        self.relax = ca.SX.sym("relax")
        self.places: dict[str, list[slice]] = {}
        self.count, self.cost = 0, ca.SX(0)
        h = [self._new("h", 1, 0.0, time[1]) for _ in range(elements)]
        x = ca.SX(model.start)
        left = self._split(None, x)
        for i in range(elements):
            x, left = self._element(i, h[i], x, left, bounds)
        self._rule(sum(h), *time)
        for k, value in end.items():
            self._rule(x[k], value, value)
        self.total = sum(h, ca.SX(0))
        self.spent = self.total if model.cost is None else self.cost
        variables, rules = ca.vertcat(*self.variables), ca.vertcat(*self.rules)
        self.nlp: dict[str, ca.SX] = {"x": variables, "f": self.spent, "g": rules, "p": self.relax}

    def _new(self, name: str, size: int, low: float | np.ndarray, high: float | np.ndarray) -> ca.SX:
        symbol = ca.SX.sym(f"{name}_{self.count}", size)
        self.places.setdefault(name, []).append(slice(self.count, self.count + size))
        self.variables.append(symbol)
        self.low += np.broadcast_to(low, size).tolist()
        self.high += np.broadcast_to(high, size).tolist()
        self.count += size
        return symbol

    def _rule(self, expr: Any, low: float, high: float) -> None:
        size = expr.numel() if isinstance(expr, ca.SX) else 1
        self.rules.append(expr)
        self.least += [low] * size
        self.most += [high] * size

    def _split(self, i: int | None, x: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return the positive and negative parts of the slip of a state, each >= 0."""
        p, n = (self._new(name, self.model.n_c, 0.0, np.inf) for name in ("p", "n"))
        self._rule(p - n - self.model.slip(x, ca.SX.zeros(self.model.n_w)), 0.0, 0.0)
        if i is not None and self.modes is not None:
            for k, mode in enumerate(self.modes[i]):
                for side, sign in ((p, 1), (n, -1)):
                    if mode != sign:
                        self._rule(side[k], 0.0, 0.0)
        return p, n

    def _element(
        self, i: int, h: ca.SX, x: ca.SX, left: tuple[ca.SX, ca.SX], bounds: np.ndarray
    ) -> tuple[ca.SX, tuple[ca.SX, ca.SX]]:
        model = self.model
        knots = [self._new("w", model.n_w, bounds[:, 0], bounds[:, 1]) for _ in range(self.degree + 1)]
        shares, slips = [], [left]
        for part in range(self.parts):
            states = [x]
            for _ in self.tau:
                states.append(self._new("x", model.n_x, -np.inf, np.inf))
                shares.append(self._new("a", model.n_c, 0.0, 1.0))
                slips.append(self._split(i, states[-1]))
            x = states[-1]
            for j in range(len(self.tau)):
                k = part * len(self.tau) + j
                w = knots[0] if self.degree == 0 else knots[0] * (1 - self.grid[k]) + knots[1] * self.grid[k]
                p, n = slips[k + 1]
                slope = sum(float(self.slope[r, j]) * state for r, state in enumerate(states))
                step = h / self.parts
                self._rule(slope - step * model.rate(states[j + 1], w, shares[k], p + n), 0.0, 0.0)
                if model.cost is not None:
                    self.cost += step * float(self.weight[j]) * model.cost(states[j + 1], w)
        if self.modes is None:
            forward, backward = (sum(e[k] for e in slips) for k in (0, 1))
            above, below = sum(1 - a for a in shares), sum(shares)
            self._rule(forward * above - self.relax, -np.inf, 0.0)
            self._rule(backward * below - self.relax, -np.inf, 0.0)
        else:
            for k, mode in enumerate(self.modes[i]):
                if mode != 0:
                    for a in shares:
                        self._rule(a[k], 0.5 * (1 + mode), 0.5 * (1 + mode))
        return x, slips[-1]

    @alone(SYMBOLIC)
    def solver(self, tolerance: float) -> ca.Function:
        """Return a solver of the program."""
        quiet: dict[str, float | str] = {
            "print_level": 0,
            "sb": "yes",
            "tol": tolerance,
            "max_iter": 500,
            "mu_strategy": "adaptive",
            "bound_relax_factor": 0.0,
            "honor_original_bounds": "yes",
        }
        return ca.nlpsol("control", "ipopt", self.nlp, {"ipopt": quiet, "print_time": False})

    @alone(OPTIMISER)
    def solve(self, solver: ca.Function, guess: np.ndarray, relax: float) -> tuple[np.ndarray, bool]:
        """Return the variables and whether the solver succeeded."""
        solution = solver(x0=guess, p=relax, lbx=self.low, ubx=self.high, lbg=self.least, ubg=self.most)
        return np.array(solution["x"]).ravel(), bool(solver.stats()["success"])

    def values(self, z: np.ndarray, name: str) -> np.ndarray:
        """Return the variables of one name, shape (n, size)."""
        return np.array([z[s] for s in self.places[name]])

    def restart(self, coarse: "NonlinearProgram", z: np.ndarray, keep: np.ndarray) -> np.ndarray:
        """Return a start from some elements of another program with fewer points, linear between them."""
        start = np.zeros(self.count)
        for name in ("h", "w"):
            rows = coarse.values(z, name).reshape(coarse.elements, -1)[keep]
            start[np.concatenate([np.r_[s] for s in self.places[name]])] = rows.ravel()
        first = {"x": coarse.model.start, "a": None, "p": coarse.values(z, "p")[0], "n": coarse.values(z, "n")[0]}
        for name, left in first.items():
            values = coarse.values(z, name)[-coarse.elements * len(coarse.grid) :]
            values = values.reshape(coarse.elements, len(coarse.grid), -1)
            fine = [self._between(coarse.grid, values, k, left) for k in keep]
            skip = len(self.places[name]) - self.elements * len(self.grid)  # skip the slip at the start
            rows = np.concatenate([[left] * skip, *fine]) if skip else np.concatenate(fine)
            for slot, row in zip(self.places[name], rows, strict=True):
                start[slot] = row
        return start

    def _between(self, tau: list[float], values: np.ndarray, k: int, left: np.ndarray | None) -> np.ndarray:
        """Return the values of element k at the points of this program, shape (n, size)."""
        before = values[k, 0] if left is None else left if k == 0 else values[k - 1, -1]
        known = np.vstack([before, values[k]])
        columns = [np.interp(self.grid, [0.0, *tau], column) for column in known.T]
        return np.array(columns).reshape(len(columns), len(self.grid)).T

    @alone(SYMBOLIC)
    def objective(self, z: np.ndarray) -> float:
        """Return the duration, or the cost."""
        return float(ca.Function("f", [self.nlp["x"]], [self.spent])(z))

    def measure_by(self, value: float) -> None:
        """Scale the objective by a value of it, so that tolerances are relative."""
        self.nlp["f"] = self.spent / (abs(value) or 1.0)

    def most_costly(self, value: float) -> None:
        """Constrain the duration, or the cost, by an upper bound."""
        self._rule(self.spent, -np.inf, value)
        self.nlp["g"] = ca.vertcat(*self.rules)

    def modes_of(self, z: np.ndarray) -> np.ndarray:
        """Return the mode of every contact in every element, shape (elements, n_c)."""
        p, n = (self.values(z, name)[1:].reshape(self.elements, len(self.grid), -1).max(axis=1) for name in ("p", "n"))
        largest = max(float(np.max(p, initial=0.0)), float(np.max(n, initial=0.0)), 1e-300)
        return np.where(p > np.maximum(n, SLIDE * largest), 1, np.where(n > SLIDE * largest, -1, 0))
