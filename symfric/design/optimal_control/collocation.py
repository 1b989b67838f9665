"""Optimal control with dry friction and an unknown order of events, by a homotopy on the complementarity."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

import casadi as ca
import numpy as np
import sympy as sp

from symfric.axes import axes_for
from symfric.design.comparison import Compared, Comparison
from symfric.design.optimal_control.transcription import (
    Dynamics,
    NonlinearProgram,
    TranscriptionSizes,
    dimensionless,
    dynamics,
    sizes_of,
)
from symfric.design.verification import Interrupted, Neighbour, judged
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.arguments import whole
from symfric.model.outputs import End, Integral
from symfric.model.results import Drawable, Result
from symfric.model.scene import Scene, check_given_loads, check_scene
from symfric.model.symbols import TIME, Key, expression, finite, mapped, name_of, pair
from symfric.solve.routes import simulate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# degree, bounds of the controls, values of states at the end, bounds of the duration
Task: TypeAlias = tuple[int, np.ndarray, dict[int, float], tuple[float, float]]
Solved: TypeAlias = tuple[NonlinearProgram, np.ndarray]  # and its variables
RELAX = 10.0 ** -np.arange(0.0, 9.0)  # relaxations of the complementarity, solved in turn
ROUGH, FINE = 1e-9, 1e-12  # tolerances of the programs with relaxed and with fixed modes
EMPTY = 1e-7  # length relative to the duration below which an element is removed
PARTS = 16  # most polynomials in an element; doubled until the event-driven model agrees
LESS, MISS = 1e-3, 1e-6  # relative gain of a cheaper neighbour; relative miss of the end state that counts as none
BUMPS = (1.0, 0.2)  # factors of the guessed velocity from which homotopies start
MORE_BUMPS = (0.5, 2.0, 0.05, 0.0)  # further factors, tried in turn if all of these fail


@dataclass(frozen=True, eq=False, repr=False)
class Profile(Result, Drawable):
    """An optimal control.

    Attributes
    ----------
    time, objective : float
    t : ndarray, shape (n + 1,)
        Where the elements begin and end.
    controls : dict of str to ndarray, shape (n, degree + 1)
        Values of each control at the start of each element, and at its end if the control is linear in between.
    x : ndarray, shape (n_x, n + 1)
        States at `t`.
    mode : ndarray of int, shape (n_contacts, n)
        Mode of each contact in each element.
    scene : Scene
        The given scene.
    check : Comparison or Interrupted
        What the event-driven model does with these controls.
    status : str
        "optimal": a local optimum of the order of events that the homotopy found; as `Design.status`.
    doubts : tuple of str
        Why the status is no better.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u, w = sp.symbols("x u w", real=True)
    >>> block = sf.Scene(
    ...     system=sf.System(q=[x], u=[u], mass=[[1]], force=[w]),
    ...     contacts=[sf.Contact("floor", slip=u, normal=0.3, law=sf.laws.coulomb(1))],
    ...     values={w: 0.0},
    ...     initial={x: 0.0, u: 0.0},
    ...     horizon=1.0,
    ... )
    >>> move = sf.design.collocation(block, {"w": (-1, 1)}, end={"x": 1, "u": 0}, time=(0.1, 10))
    >>> sorted(move.to_dict())[:2]
    ['check', 'controls']
    >>> ax = move.plot()
    """

    _told = ("time", "objective", "t", "controls", "x", "mode", "status", "doubts", "check")

    time: float
    objective: float
    t: np.ndarray
    controls: dict[str, np.ndarray]
    x: np.ndarray
    mode: np.ndarray
    scene: Scene
    check: Comparison | Interrupted
    status: str
    doubts: tuple[str, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """The duration, by the name "t"."""
        return {"t": self.time}

    @property
    def active(self) -> tuple[str, ...]:
        """Conditions and bounds that hold with equality; bounds of the controls are not listed."""
        return ()

    @property
    def corrected(self) -> None:
        """No model beside the full one plays a part."""
        return None

    def __repr__(self) -> str:
        doubts = f", but {'; '.join(self.doubts)}" if self.doubts else ""
        numbers = f"time {self.time:.8g}, objective {self.objective:.8g}, {self.t.size - 1} elements"
        return f"Profile({self.status}, {numbers}{doubts})"

    def _draw(self, ax: "Axes | None") -> "Axes":
        ax = axes_for(ax)
        for name, values in self.controls.items():
            t = np.column_stack([self.t[:-1], self.t[1:]]).ravel()
            ax.plot(t, np.column_stack([values[:, 0], values[:, -1]]).ravel(), label=name)
        ax.set_xlabel("time")
        ax.set_ylabel("controls")
        ax.legend()
        return ax


@logged
def collocation(
    scene: Scene,
    controls: Mapping[Key, tuple[float, float]],
    end: Mapping[Key, float],
    *,
    time: tuple[float, float],
    minimise: sp.Expr | str = "time",
    elements: int = 6,
    degree: int = 0,
) -> Profile:
    """Find the controls that bring a scene with dry friction to a state in least time or at least cost.

    Parameters
    ----------
    scene : Scene
        Autonomous, with smooth forces; each contact with one smooth law that begins at its static friction. Starts at
        its initial state; its horizon and outputs are not used.
    controls : mapping of parameter to (float, float)
        Parameters of the scene that become functions of time, with their bounds.
    end : mapping of state to float
        Values to reach.
    time : (float, float)
        Bounds of the duration; equal ones fix it.
    minimise : "time" or Expr
        The duration, or the integral of an expression of states, controls and parameters.
    elements : int
        Largest number of pieces of the controls, at least as many as there are changes of mode and of control.
    degree : {0, 1}
        Controls are constant in a piece, or linear.

    Returns
    -------
    Profile

    Raises
    ------
    SceneError
        If the scene or an argument is wrong.
    NotFound
        If no motion reaches the end within the bounds; says by how much the best one misses it.

    Notes
    -----
    See `symfric.design.optimal_control.transcription`. The order of stick and slip is found by a homotopy of relaxed
    complementarity; the modes it ends in are then fixed, and what is left is a smooth program without degeneracy. The
    optimum is local. Each piece is run once more by the event-driven solver.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u, w = sp.symbols("x u w", real=True)
    >>> block = sf.Scene(
    ...     system=sf.System(q=[x], u=[u], mass=[[1]], force=[w]),
    ...     contacts=[sf.Contact("floor", slip=u, normal=0.3, law=sf.laws.coulomb(1))],
    ...     values={w: 0.0},
    ...     initial={x: 0.0, u: 0.0},
    ...     horizon=1.0,
    ... )
    >>> move = sf.design.collocation(block, {"w": (-1, 1)}, end={"x": 1, "u": 0}, time=(0.1, 10))
    >>> round(round(move.time, 4), 6)
    2.0966
    """
    check_scene(scene)
    check_given_loads(scene, "optimal control by collocation")
    scene = scene.written_out()
    symbols = [scene.parameter(k) for k in mapped(controls, "controls", "{'name': (lower, upper)}")]
    mapped(end, "end", "{'x': 1.0}")
    names = [s.name for s in scene.system.states]
    ask = _asked(controls, end, time, elements, degree, names)
    cost = None if isinstance(minimise, str) and minimise == "time" else expression(minimise, "minimise")
    physical = dynamics(scene, symbols, cost)
    sizes = sizes_of(physical, *ask[1:])
    model, units, ask = dimensionless(physical, sizes), sizes, _in_sizes(ask, sizes)
    ways = (_homotopy(model, elements, ask, bump) for bump in BUMPS + MORE_BUMPS)
    solved: list[Solved] = []
    best: Profile | None = None
    written = partial(_profile, scene, symbols, cost, ask=ask, units=units)
    with until_interrupted("collocation"):
        for k, found in enumerate(ways):
            tell(f"the order of stick and slip, from guess {k + 2}")
            solved += [] if found is None else [found]
            if solved and k + 1 >= len(BUMPS):
                break
        if not solved:
            raise NotFound(_missing(model, elements, ask, names, units))
        program, z = min(solved, key=_cost_of)
        tell("verification by the event-driven solver")
        best = written(program=program, z=z)
        return _refined(model, program, z, best, ask, written)
    if not solved:
        raise KeyboardInterrupt
    program, z = min(solved, key=_cost_of)
    return best or written(program=program, z=z, verified=False)


def _cost_of(solved: Solved) -> float:
    program, z = solved
    return program.objective(z)


def _refined(
    model: Dynamics,
    program: NonlinearProgram,
    z: np.ndarray,
    best: Profile,
    ask: Task,
    written: Callable[..., Profile],
) -> Profile:
    """Return the profile with as many polynomials in an element as the event-driven model agrees with."""
    degree, bounds, target, between = ask
    while not best.check.agrees and program.parts < PARTS:
        finer = NonlinearProgram(
            model, program.elements, degree, bounds, target, between, program.modes, 2 * program.parts
        )
        finer.measure_by(program.objective(z))
        z, content = finer.solve(finer.solver(FINE), finer.restart(program, z, np.arange(program.elements)), 0.0)
        if not content:
            break
        program = finer
        best = written(program=program, z=z)
    return best


def _in_sizes(ask: Task, sizes: TranscriptionSizes) -> Task:
    """Return bounds and end values in units of the problem's sizes."""
    degree, bounds, target, (low, high) = ask
    ends = {k: v / sizes.x[k] for k, v in target.items()}
    return degree, bounds / sizes.w[:, None], ends, (low / sizes.time, high / sizes.time)


def _asked(
    controls: Mapping[Key, tuple[float, float]],
    end: Mapping[Key, float],
    time: tuple[float, float],
    elements: int,
    degree: int,
    names: list[str],
) -> Task:
    """Check and return degree, bounds of the controls, values at the end and bounds of the duration."""
    bounds = np.array(
        [
            [finite(e, f"a bound of {name_of(k)}") for e in pair(b, f"the bounds of {name_of(k)}")]
            for k, b in controls.items()
        ]
    )
    if not bounds.size or np.any(bounds[:, 0] > bounds[:, 1]):
        raise SceneError("controls holds the parameters to choose, each with (smallest, largest)")
    unknown = next((name_of(k) for k in end if name_of(k) not in names), None)
    if unknown or not end:
        raise SceneError(f"end names {unknown or 'nothing'}; it gives values of the states {', '.join(names)}")
    low, high = (finite(e, "a bound of time") for e in pair(time, "time"))
    if not 0 <= low <= high or high <= 0:
        raise SceneError(f"time is ({low:g}, {high:g}); give the shortest and the longest duration")
    whole(degree, "degree", 0, 1)
    whole(elements, "elements")
    target = {names.index(name_of(k)): finite(v, f"the end of {name_of(k)}") for k, v in end.items()}
    return degree, bounds, target, (low, high)


def _guess(program: NonlinearProgram, target: dict[int, float], duration: float, bump: float) -> np.ndarray:
    """Return an initial guess: elements of equal length, states on a straight line, and matching velocities."""
    model, n, n_q = program.model, program.elements, program.model.n_q
    z = np.zeros(program.count)
    goal = model.start.copy()
    for k, value in target.items():
        goal[k] = value
    for s in program.places["h"]:
        z[s] = duration / n
    points = program.places["x"]
    for j, s in enumerate(points):
        share = (j + 1) / len(points)
        x = model.start + share * (goal - model.start)
        x[n_q : 2 * n_q] += bump * 6 * share * (1 - share) * (goal - model.start)[:n_q] / duration
        z[s] = x
        slip = np.array(model.slip(x, np.zeros(model.n_w))).ravel()
        z[program.places["p"][j + 1]], z[program.places["n"][j + 1]] = np.maximum(slip, 0), np.maximum(-slip, 0)
        z[program.places["a"][j]] = 0.5
    return z


def _homotopy(model: Dynamics, elements: int, ask: Task, bump: float) -> Solved | None:
    """Solve the relaxed programs in turn; return the program with fixed modes and its solution, None if one fails."""
    degree, bounds, target, time = ask
    program = NonlinearProgram(model, elements, degree, bounds, target, time)
    z = _guess(program, target, 0.5 * sum(time) if time[0] > 0 else 0.3 * time[1], bump)
    solver, content = program.solver(ROUGH), False
    for relax in RELAX:
        z, content = program.solve(solver, z, float(relax))
    if not content:
        return None
    return _fixed(model, program, z, ask)


def _fixed(model: Dynamics, program: NonlinearProgram, z: np.ndarray, ask: Task) -> Solved | None:
    """Solve with the modes found by the homotopy, removing empty elements until none is left."""
    degree, bounds, target, time = ask
    modes, keep = program.modes_of(z), _lasting(program, z)
    while True:
        modes = modes[keep]
        fixed = NonlinearProgram(model, keep.size, degree, bounds, target, time, modes)
        fixed.measure_by(program.objective(z))
        z, content = fixed.solve(fixed.solver(FINE), fixed.restart(program, z, keep), 0.0)
        if not content:
            return None
        program, keep = fixed, _lasting(fixed, z)
        if keep.size == program.elements:
            return program, z


def _lasting(program: NonlinearProgram, z: np.ndarray) -> np.ndarray:
    """Return the indices of the elements that are not empty."""
    h = program.values(z, "h").ravel()
    return np.flatnonzero(h > EMPTY * np.sum(h))


def _missing(model: Dynamics, elements: int, ask: Task, names: list[str], units: TranscriptionSizes) -> str:
    """Return a message: the state nearest to the end that can be reached, by minimising the squared distance."""
    degree, bounds, target, time = ask
    program = NonlinearProgram(model, elements, degree, bounds, {}, time)
    last = program.nlp["x"][program.places["x"][-1]]
    program.nlp["f"] = sum(((last[k] - v) ** 2 for k, v in target.items()), ca.SX(0))
    z = _guess(program, target, sum(time) / 2, BUMPS[0])
    solver = program.solver(ROUGH)
    for relax in RELAX:
        z, _ = program.solve(solver, z, float(relax))
    reached = z[program.places["x"][-1]] * units.x
    words = ", ".join(f"{names[k]} = {reached[k]:.6g} instead of {v * units.x[k]:.6g}" for k, v in target.items())
    return f"no motion found that reaches the end within the bounds; the nearest has {words}"


def _profile(
    scene: Scene,
    symbols: list[sp.Symbol],
    cost: sp.Expr | None,
    program: NonlinearProgram,
    z: np.ndarray,
    ask: Task,
    units: TranscriptionSizes,
    verified: bool = True,
) -> Profile:
    n, size = program.elements, program.degree + 1
    h = program.values(z, "h").ravel() * units.time
    knots = program.values(z, "w").reshape(n, size, -1) * units.w
    nodes = program.values(z, "x").reshape(n, len(program.grid), -1)
    sizes = np.max(np.abs(np.vstack([program.model.start, *nodes])), axis=0) * units.x
    x = np.vstack([program.model.start, nodes[:, -1]]).T * units.x[:, None]
    controls = {s.name: knots[:, :, k] for k, s in enumerate(symbols)}
    t = np.concatenate([[0.0], np.cumsum(h)])
    unit = units.time if cost is None else units.cost
    objective = float(t[-1]) if cost is None else program.objective(z) * unit
    target = {k: v * units.x[k] for k, v in ask[2].items()}
    replayed = partial(_replayed, scene, symbols, cost, h, knots, objective, target, sizes)
    check: Comparison | Interrupted = replayed() if verified else Interrupted()
    assert program.modes is not None
    status, doubts = judged("optimal", check, _cheaper(program, z, ask, unit) if verified else (), objective)
    return Profile(float(t[-1]), objective, t, controls, x, program.modes.T.copy(), scene, check, status, doubts)


def _cheaper(program: NonlinearProgram, z: np.ndarray, ask: Task, unit: float) -> list[Neighbour]:
    """Return the neighbour of slightly smaller objective that misses the end by least, with the same modes."""
    degree, bounds, target, time = ask
    best = program.objective(z)
    free = NonlinearProgram(program.model, program.elements, degree, bounds, {}, time, program.modes, program.parts)
    last = free.nlp["x"][free.places["x"][-1]]
    free.most_costly((1 - LESS) * best)
    free.nlp["f"] = sum(((last[k] - v) ** 2 for k, v in target.items()), ca.SX(0))
    variables, _ = free.solve(free.solver(FINE), z, 0.0)
    miss = max(abs(variables[free.places["x"][-1]][k] - v) for k, v in target.items())
    reached = free.objective(variables)
    feasible = miss <= MISS and reached <= best
    return [Neighbour(f"a control of {100 * LESS:g} % less", reached * unit, 0.0 if feasible else max(miss, MISS))]


def _replayed(
    scene: Scene,
    symbols: list[sp.Symbol],
    cost: sp.Expr | None,
    h: np.ndarray,
    knots: np.ndarray,
    objective: float,
    target: dict[int, float],
    sizes: np.ndarray,
) -> Comparison:
    """Simulate the controls with the event-driven solver, element after element."""
    states, names = scene.system.states, [s.name for s in scene.system.states]
    numbers = scene.where(dict.fromkeys(symbols, 0.0)).numbers()
    start, spent = {s: numbers[s] for s in states}, 0.0
    values = {s: v for s, v in scene.values.items() if s not in symbols}
    for length, piece in zip(h.tolist(), knots, strict=True):
        moving = {s: float(w[0]) + float(w[-1] - w[0]) / length * TIME for s, w in zip(symbols, piece.T, strict=True)}
        system = replace(scene.system, force=[e.subs(moving) for e in scene.system.force])
        outputs = {"end": End()} | ({} if cost is None else {"cost": Integral(cost.subs(moving))})
        run = simulate(Scene(system, scene.contacts, values, start, length, outputs), 1e-13).checked()
        start = dict(zip(states, run.final.tolist(), strict=True))
        spent += length if cost is None else run["cost"]
    final = list(start.values())
    rows = [Compared(f"{names[k]} at the end", value, final[k], 1e-7, sizes[k]) for k, value in target.items()]
    return Comparison((*rows, Compared("objective", objective, float(spent), 1e-7)))
