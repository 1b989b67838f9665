"""Least positioning error of a driven slide over a range of speeds, by the time in which its drive stops."""

from dataclasses import dataclass, field

import numpy as np

from symfric.design.comparison import Compared, Comparison
from symfric.design.positioning.slide import Slide
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.model import scenes
from symfric.model.scene import Scene
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare, simulate
from symfric.theory.drive import positioning_error

RAMPS, SPEEDS = 97, 17  # survey points
ZOOMS = 6  # times that the survey of the ramps is narrowed to the neighbours of its best point
FINEST = 129  # speeds at which the worst one is looked for in the end
NEIGHBOURS = (1e-4, 1e-3, 1e-2)  # distances of the neighbouring designs, relative to the bounds
TOLERANCE = 1e-10
BESIDE, JUMP = 1e-4, 1e-2  # distance from the ramp, relative to the bounds, and the change of the error that is a jump
SAME = 1e-6  # difference between the two solvers
STILL = 1e-9  # relative gain by a longer ramp that is not worth its time


@dataclass(frozen=True, eq=False)
class StoppingProblem:
    """Positioning errors of a slide that moves steadily until its drive stops, as functions of speed and ramp.

    Attributes
    ----------
    slide : Slide
    fc : float
        Kinetic friction at rest over ``m omega_n v*``.
    speeds : ndarray, shape (n,)
        Speeds over v* among which the worst one is sought.
    """

    slide: Slide
    fc: float
    speeds: np.ndarray
    _programs: list[Program] = field(default_factory=list)

    def scene(self, V: float, ramp: float) -> Scene:
        """Return the scene of the stop at a speed."""
        s = self.slide
        return scenes.drive_stop(
            mu1=s.mu1 + s.sigma,
            mu2=s.mu2 + s.sigma,
            lam=s.excess(V),
            epsilon=s.epsilon,
            fc=self.fc,
            speed=V,
            ramp=ramp,
            sigma=s.sigma if s.damper == "support" else 0.0,
        )

    def errors(self, ramps: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        """Return the errors, shape (ramps, speeds)."""
        errors = np.empty((ramps.size, speeds.size))
        abrupt = ramps <= 0
        errors[abrupt] = [self.abrupt(float(V)) for V in speeds]
        if np.all(abrupt):
            return errors
        if not self._programs:
            longest = self.scene(float(np.max(self.speeds)), float(ramps[-1]))
            self._programs.append(prepare(longest.wanting({"error": longest.outputs["error"]}), TOLERANCE))
        ramp, V = (e.ravel() for e in np.meshgrid(ramps[~abrupt], speeds, indexing="ij"))
        lam = np.array([self.slide.excess(v) for v in speeds])
        given = {"ramp": ramp, "speed": V, "drive": V, "lam": np.tile(lam, ramp.size // speeds.size)}
        errors[~abrupt] = self._programs[0].map(given).checked()["error"].reshape(-1, speeds.size)
        return errors

    def abrupt(self, V: float) -> float:
        """Return the error of an abrupt stop at a speed, in closed form."""
        s = self.slide
        mu1, mu2 = s.mu1 + s.sigma, s.mu2 + s.sigma
        return positioning_error(mu1, mu2, s.excess(V), slide="moving", damper=s.damper, sigma=s.sigma).value

    def worst(self, ramp: float, speeds: np.ndarray | None = None) -> tuple[float, float]:
        """Return the speed of the largest error in size, and the error."""
        speeds = self.speeds if speeds is None else speeds
        errors = self.errors(np.array([ramp]), speeds)[0]
        k = int(np.argmax(np.abs(errors)))
        return float(speeds[k]), float(errors[k])


def stopping_ramp(slide: Slide, fc: float, bounds: tuple[float, float], speeds: tuple[float, float]) -> Design:
    """Find the ramp of least error; see `symfric.design.positioning`, which has checked its arguments."""
    low, high = bounds
    ends = np.unique([*np.geomspace(*speeds, SPEEDS), *([1.0] if speeds[0] < 1 < speeds[1] else [])])
    problem = StoppingProblem(slide, fc, ends)
    fine = np.unique(np.append(np.geomspace(*speeds, FINEST), ends))
    ramp = 0.0
    for _ in range(3):
        ramp = _least(problem, low, high)
        V, error = problem.worst(ramp, fine)
        if abs(error) <= abs(problem.worst(ramp)[1]) * (1 + SAME) + SAME:
            break
        problem = StoppingProblem(slide, fc, np.unique(np.append(problem.speeds, V)), problem._programs)
    V, error = problem.worst(ramp, fine)
    inside = _off_the_jump(problem, V, ramp, bounds)
    active = [f"positioning error {error:.6g} at V = {V:.6g}"]
    active += [f"ramp at its {word} bound" for word, bound in (("lower", low), ("upper", high)) if ramp == bound]
    if inside != ramp:
        active.append(
            f"the error jumps with a ramp {'longer' if inside < ramp else 'shorter'} by {abs(inside - ramp):.2g}"
        )
    survey = np.unique(np.append(np.linspace(low, high, 201), ramp))
    curve = np.max(np.abs(problem.errors(survey, problem.speeds)), axis=1)
    return design(
        {"ramp": ramp},
        abs(error),
        active,
        problem.scene(V, ramp),
        Comparison(_verified(problem, V, inside)),
        Curve(survey, curve, abs(error), "time in which the drive stops, in 1/omega_n", "positioning error", (ramp,)),
        claim="optimal" if inside == ramp else "infimum",
        neighbours=_beside(problem, bounds, ramp, fine),
    )


def _least(problem: StoppingProblem, low: float, high: float) -> float:
    """Return the ramp of the least largest error, by a survey that narrows; of equal ones the shortest."""
    ramps = np.unique(np.linspace(low, high, RAMPS))
    best = (np.inf, low)
    for _ in range(ZOOMS):
        cost = np.max(np.abs(problem.errors(ramps, problem.speeds)), axis=1)
        k = int(np.flatnonzero(cost <= np.min(cost) + STILL * (1 + np.min(cost)))[0])
        if cost[k] < best[0]:
            best = (float(cost[k]), float(ramps[k]))
        ends = ramps[max(k - 1, 0)], ramps[min(k + 1, ramps.size - 1)]
        if not ends[1] > ends[0]:
            break
        ramps = np.unique(np.append(np.linspace(*ends, 25), best[1]))
    return best[1]


def _off_the_jump(problem: StoppingProblem, V: float, ramp: float, bounds: tuple[float, float]) -> float:
    """Return the ramp, or one beside it if the error jumps there: the other solver may fall on the other side."""
    step = BESIDE * (bounds[1] - bounds[0])
    sides = np.array([max(ramp - step, bounds[0]), min(ramp + step, bounds[1])])
    sizes = np.abs(problem.errors(sides, np.array([V]))[:, 0])
    if abs(sizes[1] - sizes[0]) < JUMP * (1 + np.min(sizes)):
        return ramp
    return float(sides[np.argmin(sizes)])


def _verified(problem: StoppingProblem, V: float, ramp: float) -> tuple[Compared, ...]:
    """Compare the error with another solver and, for the speed's abrupt stop, with the closed form."""
    scene = problem.scene(V, ramp)
    error = problem.worst(ramp, np.array([V]))[1]
    other = simulate(scene, 1e-8, route="integrators" if ramp > 0 else None)
    rows = [Compared(f"positioning error at V = {V:.6g}", error, float(other["error"]), SAME, size=1.0)]
    short = float(simulate(problem.scene(V, 1e-6), TOLERANCE)["error"])
    rows.append(Compared(f"with a ramp of 1e-6 at V = {V:.6g}", problem.abrupt(V), short, SAME, size=1.0))
    return tuple(rows)


def _beside(problem: StoppingProblem, bounds: tuple[float, float], ramp: float, fine: np.ndarray) -> list[Neighbour]:
    """Return the neighbouring designs within the bounds."""
    steps = [sign * share * (bounds[1] - bounds[0]) for share in NEIGHBOURS for sign in (-1, 1)]
    others = [ramp + step for step in steps if bounds[0] <= ramp + step <= bounds[1]]
    neighbours = [Neighbour(f"ramp = {e:.6g}", abs(problem.worst(e, fine)[1]), 0.0) for e in others if e != ramp]
    return neighbours or [Neighbour("the ramp has no other value within its bounds", np.nan, np.nan)]
