"""Least positioning error of a driven slide without stick-slip over a range of speeds, by one parameter."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symfric.design.comparison import Compared, Comparison
from symfric.design.positioning.slide import Slide
from symfric.design.positioning.stopping_ramp import stopping_ramp
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell
from symfric.model import scenes
from symfric.model.scene import Scene
from symfric.model.symbols import Key, finite, name_of, pair
from symfric.search import Function, minimum_near, valleys, zero
from symfric.solve.routes import simulate
from symfric.solve.run import finished

VARIED = ("sigma", "mu1", "mu2", "epsilon")
RAMP = "ramp"  # time of the stop, which is no value of the drawn slide
COARSE, FINE, VALUES = 13, 97, 65  # survey points of speeds (coarse, fine) and of parameter values
BESIDE = 1e-3  # distance within the threshold at which the full model is run, relative to epsilon or the bounds
SHARES = (1e-6, 1e-4, 1e-2)  # distances of the neighbouring designs, relative to the bounds
CHECKED = 5  # speeds over the range at which the full model is run, besides the critical ones
STRONG = 1e6  # friction difference that counts as unbounded


@dataclass(frozen=True, eq=False)
class PositioningProblem:
    """A design parameter of a slide, the range of speeds, and the number of survey speeds."""

    numbers: dict[str, Any]
    name: str
    speeds: tuple[float, float]
    survey: int = COARSE

    def at(self, value: float) -> Slide:
        """Return the slide for a value of the parameter."""
        return Slide(**{**self.numbers, self.name: float(value)})

    def nearest(self, value: float) -> tuple[float, float]:
        """Return the speed of least slack, and the slack."""
        slide, V = self.at(value), np.geomspace(*self.speeds, self.survey)
        if self.speeds[0] < 1 < self.speeds[1]:
            V = np.union1d(V, [1.0, 1 + 1e-12])  # the equilibrium changes its branch
        y = np.array([slide.slack(e) for e in V])
        slacks = [(float(y[k]), float(V[k])) for k in (0, V.size - 1, int(np.argmin(y)))]
        low = [k for k in valleys(y) if y[k] < 1]
        slacks += [minimum_near(slide.slack, V, k, xatol=1e-10)[::-1] for k in low[:3]]
        return min(slacks)[::-1]

    def slack(self, value: float) -> float:
        """Return the least slack over the speeds."""
        return self.nearest(value)[1]

    def furthest(self, value: float) -> float:
        """Return the speed of the largest lambda, where the error is largest too.

        lambda is linear in V below and above 1, and a stronger push carries the slide further: paths do not cross.
        """
        low, high = self.speeds
        slide = self.at(value)
        return max([low, high, *([1.0] if low < 1 < high else [])], key=slide.excess)

    def push(self, value: float) -> float:
        """Return the largest lambda over the speeds, less the static excess epsilon."""
        slide = self.at(value)
        return slide.excess(self.furthest(value)) - slide.epsilon

    def error(self, value: float) -> float:
        """Return the largest positioning error over the speeds."""
        return self.at(value).error(self.furthest(value))


@logged
def positioning(scene: Scene, parameter: Key, bounds: tuple[float, float], speeds: tuple[float, float]) -> Design:
    """Find the least positioning error of a driven slide without stick-slip at any speed of a range.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.drive_slide`; its damper sits on the ground or on the support (to ground if it has none), and
        p_star is not used.
    parameter : Symbol or str
        "sigma", the damper, or "mu1", "mu2", "epsilon". The value stored in the scene is ignored. Or "ramp", the time
        in units of 1/omega_n in which the speed of the drive falls evenly to zero, see `symfric.scenes.drive_stop`.
    bounds : (float, float)
        Of the parameter.
    speeds : (float, float)
        Lowest and highest speed of the drive over v*, positive.

    Returns
    -------
    Design
        The objective is the largest ``|Delta S|`` over v*/omega_n. Where several values reach it, the smallest of them.

    Raises
    ------
    SceneError
        If the scene is another one or an argument is wrong.
    NotFound
        If the slide sticks and slips with every value; says at which speed, and by how much the friction is too strong.

    Notes
    -----
    No stick-slip: ``epsilon <= eps_crit(V)`` for every V, Guida (4). The error, Guida (20), is that of a slide which
    rests when the drive stops, with the spring's force of steady sliding; it jumps from zero where lambda exceeds
    epsilon. Both worst speeds are found: that of the error is an end of the range or v*, that of stick-slip a polished
    minimum of the threshold. A damper to ground helps against stick-slip and adds to the push at the stop, so that the
    two conditions can be at odds; one on the support does not add to it.

    With "ramp" the slide moves steadily when the drive begins to stop, since there is no stick-slip; the error is
    counted from where it would rest with the spring's force of steady sliding, and negative errors, of a slide that
    stops short, count by their size. It is that of the event-driven model, at many speeds and by a survey of the ramps.

    Examples
    --------
    >>> import symfric as sf
    >>> slide = sf.scenes.drive_slide(mu1=0.1, mu2=0.1, p_star=1.0, epsilon=0.05)
    >>> best = sf.design.positioning(slide, "ramp", (0.0, 10.0), speeds=(0.5, 0.5))
    >>> f"{best.values['ramp']:.1f}: {best.objective:.4f}"
    '6.4: 0.1361'
    """
    problem = _problem(scene, parameter, speeds)
    low, high = (finite(e, f"a bound of {problem.name}") for e in pair(bounds, "bounds"))
    if low > high:
        raise SceneError(f"bounds is ({low:g}, {high:g}); the lower bound comes first")
    if problem.name in ("sigma", "epsilon", RAMP) and low < 0:
        raise SceneError(f"the lower bound of {problem.name} is {low:g}; it must not be negative")
    if problem.name == RAMP:
        fine = replace(problem, name="sigma", survey=FINE)
        _refuse_stick_slip(fine)
        return stopping_ramp(fine.at(fine.numbers["sigma"]), _read(scene)["fc"], (low, high), problem.speeds)
    tell("the least error without stick-slip")
    value = _best(problem, low, high)
    fine = replace(problem, survey=FINE)
    if fine.slack(value) < problem.slack(value) - 1e-9:  # the coarse survey missed a speed
        problem, value = fine, _best(fine, low, high)
    return _design(scene, problem, (low, high), value)


def _best(problem: PositioningProblem, low: float, high: float) -> float:
    """Return the value of the least error among those without stick-slip."""
    grid = np.unique(np.linspace(low, high, VALUES))
    slacks = np.array([problem.slack(e) for e in grid])
    pieces = _positive_pieces(problem.slack, grid, slacks)
    if not pieces:
        raise NotFound(_missing(problem, float(grid[::-1][np.argmax(slacks[::-1])])))
    return min((_least(problem, *piece) for piece in pieces), key=lambda f: (f[1], f[0]))[0]


def _problem(scene: Scene, parameter: Key, speeds: tuple[float, float]) -> PositioningProblem:
    name = name_of(parameter)
    if name not in (*VARIED, RAMP):
        known = ", ".join((*VARIED, RAMP))
        raise SceneError(f"{name} is not a parameter that positioning can vary; give one of {known}")
    low, high = (finite(e, "a speed") for e in pair(speeds, "speeds"))
    if not 0 < low <= high:
        raise SceneError(f"speeds is ({low:g}, {high:g}); give speeds over v*, the lower one first and positive")
    numbers = _read(scene)
    missing = next((k for k in VARIED if numbers[k] is None and k != name), None)
    if missing:
        raise SceneError(f"no value for {missing}; add it to Scene.values")
    return PositioningProblem({k: numbers[k] for k in (*VARIED, "damper")}, name, (low, high))


def _read(scene: Scene) -> dict[str, Any]:
    """Return the arguments of `symfric.scenes.drive_slide` of a scene; a damper of 0 to ground if it has none."""
    models: list[dict[str, Any]] = [{}, *({"sigma": 0.0, "damper": damper} for damper in ("ground", "support"))]
    for kind in models:
        model = scenes.drive_slide(mu1=0.0, mu2=0.0, p_star=0.0, epsilon=0.0, **kind)
        if isinstance(scene, Scene) and (scene.system, scene.contacts) == (model.system, model.contacts):
            return {"sigma": 0.0, "damper": "ground", **kind, **{s.name: v for s, v in scene.values.items()}}
    raise SceneError("positioning takes sf.scenes.drive_slide; this scene has other equations")


def _positive_pieces(function: Function, grid: np.ndarray, y: np.ndarray) -> list[tuple[float, float]]:
    """Return the intervals of the grid on which a continuous function is not negative, their ends polished.

    A local maximum that just misses zero on the grid is polished first.
    """
    inner, beside = y[1:-1], (y[:-2], y[2:])
    peaks = np.flatnonzero((inner < 0) & (inner >= np.maximum(*beside)) & (inner > np.minimum(*beside))) + 1
    for k in peaks.tolist():
        best = minimum_near(lambda s: -function(s), grid, k)
        grid, y = np.append(grid, best.place), np.append(y, -best.value)
    order = np.argsort(grid)
    grid, y = grid[order], y[order]
    pieces, start = [], None
    for k in range(grid.size):
        inside = y[k] >= 0
        if inside and start is None:
            start = grid[0] if k == 0 else _inner(function, grid[k - 1], grid[k])
        if not inside and start is not None:
            pieces.append((float(start), float(_inner(function, grid[k], grid[k - 1]))))
            start = None
    return pieces if start is None else [*pieces, (float(start), float(grid[-1]))]


def _inner(function: Function, outside: float, inside: float) -> float:
    """Bisect a zero or a jump of a function; return the end at which it is not negative."""
    root = zero(function, outside, inside, xtol=1e-15)
    if function(root) >= 0:
        return root
    step = np.spacing(abs(root))
    while step < abs(inside - root):
        then = root + np.copysign(step, inside - root)
        if function(then) >= 0:
            return float(then)
        step *= 2
    return inside


def _least(problem: PositioningProblem, low: float, high: float) -> tuple[float, float]:
    """Return the value of the least error on an interval, and the error."""
    grid = np.unique(np.linspace(low, high, VALUES))
    still = _positive_pieces(lambda e: -problem.push(e), grid, np.array([-problem.push(e) for e in grid]))
    if still:
        return still[0][0], problem.error(still[0][0])
    y = np.array([problem.error(e) for e in grid])
    k = int(np.argmin(y))
    best = (float(grid[k]), float(y[k]))
    if 0 < k < grid.size - 1:
        best = min(best, minimum_near(problem.error, grid, k), key=lambda f: f[1])
    return best


def _refuse_stick_slip(problem: PositioningProblem) -> None:
    """Raise if the slide sticks and slips at a speed of the range, whatever the ramp."""
    V, slack = problem.nearest(problem.numbers["sigma"])
    if slack < 0:
        limit = problem.at(problem.numbers["sigma"]).threshold(V)
        raise NotFound(
            f"stick-slip before the stop, whatever the ramp: at V = {V:.6g} the slide's epsilon = "
            f"{problem.numbers['epsilon']:.6g} exceeds the threshold {limit:.6g}"
        )


def _missing(problem: PositioningProblem, value: float) -> str:
    V, _ = problem.nearest(value)
    slide = problem.at(value)
    limit = slide.threshold(V)
    if limit == 0:
        return (
            f"stick-slip for every {problem.name} within its bounds: {problem.name} = {value:.6g} comes "
            f"closest, and at V = {V:.6g} the slide sticks again after every release, for any epsilon > 0"
        )
    return (
        f"stick-slip for every {problem.name} within its bounds: {problem.name} = {value:.6g} comes "
        f"closest, and at V = {V:.6g} its epsilon = {slide.epsilon:.6g} exceeds the threshold {limit:.6g} by "
        f"{slide.epsilon - limit:.6g}"
    )


def _design(scene: Scene, problem: PositioningProblem, bounds: tuple[float, float], value: float) -> Design:
    slide, name = problem.at(value), problem.name
    V, slack = problem.nearest(value)
    worst = problem.furthest(value)
    beside = _beside(problem, bounds, value)
    active = [f"no stick-slip at V = {V:.6g}"] if abs(slack) < 1e-9 or _on_jump(problem, bounds, value) else []
    if abs(problem.push(value)) <= 1e-9 * max(1.0, slide.epsilon):
        active.append(f"the static friction just holds at V = {worst:.6g}")
    active += [f"{name} at its {w} bound" for w, b in zip(("lower", "upper"), bounds, strict=True) if value == b]
    full = scenes.drive_slide(**{**_read(scene), name: value, "p_star": 1 / V - 1}, horizon=scene.horizon)
    speeds = np.unique(np.append(np.geomspace(*problem.speeds, 201), V))
    limits = np.array([slide.threshold(e) for e in speeds])
    limits[~np.isfinite(limits) | (limits > STRONG)] = np.nan
    curve = Curve(speeds, limits, slide.epsilon, "speed V = v/v*", "threshold of stick-slip", (V,) if active else ())
    check = Comparison((*_sticking(full, problem, bounds, value), _stopped(slide, worst)))
    objective = problem.error(value)
    return design({name: value}, objective, active, full, check, curve, claim="optimal", neighbours=beside)


def _beside(problem: PositioningProblem, bounds: tuple[float, float], value: float) -> list[Neighbour]:
    """Return the neighbouring designs within the bounds."""
    neighbours = []
    for word, sign in (("smaller", -1), ("larger", 1)):
        for share in SHARES:
            other = value + sign * share * (bounds[1] - bounds[0])
            if bounds[0] <= other <= bounds[1] and other != value:
                change = f"{problem.name} {word} by {share:g} of its bounds"
                neighbours.append(Neighbour(change, problem.error(other), -problem.slack(other)))
    return neighbours or [Neighbour(f"{problem.name} has no other value within its bounds", np.nan, np.nan)]


def _on_jump(problem: PositioningProblem, bounds: tuple[float, float], value: float) -> bool:
    """Whether stick-slip begins right beside a value, although there is slack at the value."""
    step = 1e-9 * (bounds[1] - bounds[0])
    return any(problem.slack(e) < 0 for e in (value - step, value + step) if bounds[0] <= e <= bounds[1])


def _sticking(scene: Scene, problem: PositioningProblem, bounds: tuple[float, float], value: float) -> list[Compared]:
    """Verify on the full model, over the speeds, that the slide does not stick again after its release from rest.

    The runs are slightly within the threshold: with less static friction or, without any, slightly away from the value
    at which stick-slip begins.
    """
    slide, name = problem.at(value), problem.name
    changes, within = {}, ""
    if slide.epsilon > 0:
        changes = {"epsilon": slide.epsilon * (1 - BESIDE)}
        within = f", epsilon smaller by {100 * BESIDE:g} %"
    elif _on_jump(problem, bounds, value):
        step = BESIDE * (bounds[1] - bounds[0])
        other = max((value - step, value + step), key=lambda e: problem.slack(float(np.clip(e, *bounds))))
        changes, within = {name: float(np.clip(other, *bounds))}, f", {name} = {other:.6g}"
    rows = []
    for V in np.unique([*np.geomspace(*problem.speeds, CHECKED), problem.nearest(value)[0]]):
        run = finished(simulate(scene.where({**changes, "p_star": 1 / V - 1}), 1e-11))
        again = float(any(e.kind == "stick" for e in run.events))
        rows.append(Compared(f"sticks again at V = {V:.6g}{within}", 0.0, again, 0.0))
    return rows


def _stopped(slide: Slide, V: float) -> Compared:
    """Verify the positioning error on the full model, after a stop of the drive."""
    mu1, mu2 = slide.mu1 + slide.sigma, slide.mu2 + slide.sigma
    lam = slide.excess(V)
    computed = 0.0
    # otherwise the spring pulls back, and the friction of the ready scene holds the slide
    if lam > -4 * max(1.0, -mu1):
        computed = simulate(scenes.drive_stop(mu1=mu1, mu2=mu2, lam=lam, epsilon=slide.epsilon), 1e-12)["error"]
    return Compared(f"positioning error at V = {V:.6g}", slide.error(V), float(computed), 1e-8, size=1.0)
