"""Results of a benchmark: measured points, curves of solvers, and their table."""

import math
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class BenchAnswer:
    """Result of one run: final values, number of events, and the part of the problem that was run."""

    values: tuple[float, ...]
    events: int
    every: int = 1  # step between the speeds of a sweep that were run


@dataclass(frozen=True)
class ErrorPoint:
    """One solver at one tolerance.

    Attributes
    ----------
    tolerance : float
    seconds : float
        CPU time of one run, median over the rounds.
    spread : float
        Largest over smallest round.
    error : float
        Largest difference from the reference.
    events : int
        Events found.
    """

    tolerance: float
    seconds: float
    spread: float
    error: float
    events: int


@dataclass(frozen=True)
class ErrorCurve:
    """One solver on one problem.

    Attributes
    ----------
    problem, solver : str
    points : tuple of ErrorPoint
    prepared : float
        Seconds to prepare it the first time and run it once: model, compilation, load.
    events : int or None
        True number of events.
    failure : str
        Why there are no points, or fewer.
    stopped : bool
        Finer tolerances were not tried, as a quick benchmark does with slow solvers.
    """

    problem: str
    solver: str
    points: tuple[ErrorPoint, ...]
    prepared: float
    events: int | None
    failure: str = ""
    stopped: bool = False

    def time_to(self, error: float) -> float:
        """Return the CPU time in s for an error, by log-log interpolation; NaN if it was not reached.

        Notes
        -----
        On the Pareto front: the points that no other beats in both time and error. An error larger than that of the
        cheapest point costs what the cheapest point costs.
        """
        front = self.front()
        if not front or front[-1].error > error:
            return math.nan
        if front[0].error <= error:
            return front[0].seconds
        k = next(i for i, p in enumerate(front) if p.error <= error)
        left, right = front[k - 1], front[k]
        if right.error <= 0:
            return right.seconds
        part = math.log(left.error / error) / math.log(left.error / right.error)
        return float(left.seconds * (right.seconds / left.seconds) ** part)

    def front(self) -> tuple[ErrorPoint, ...]:
        """Return the Pareto front, cheapest first."""
        front: list[ErrorPoint] = []
        for point in sorted(self.points, key=lambda p: (p.seconds, p.error)):
            if not front or point.error < front[-1].error:
                front.append(point)
        return tuple(front)

    @property
    def missed(self) -> int | None:
        """Largest difference between the events found and the true ones, over the points."""
        if self.events is None or not self.points:
            return None
        return max(abs(p.events - self.events) for p in self.points)


@dataclass(frozen=True)
class Benchmark:
    """The measured curves of several solvers on several problems.

    Attributes
    ----------
    curves : tuple of ErrorCurve
    rounds : int
    machine : dict
        Processor, Python and package versions.
    workarounds : dict
        Per peer, what was done so that it does its best.
    absent : dict
        Peers that were left out, and what they need.
    titles : dict
        Of the problems.
    """

    curves: tuple[ErrorCurve, ...]
    rounds: int
    machine: dict[str, str]
    workarounds: dict[str, tuple[str, ...]]
    absent: dict[str, str]
    titles: dict[str, str]

    def curve(self, problem: str, solver: str) -> ErrorCurve:
        """Return one curve; raise KeyError if it was not measured."""
        for curve in self.curves:
            if (curve.problem, curve.solver) == (problem, solver):
                return curve
        raise KeyError(f"{solver} was not measured on {problem}")

    def ratio(self, problem: str, slow: str, fast: str, error: float = 1e-10) -> float:
        """Return the ratio of the times of two solvers for an error."""
        return self.curve(problem, slow).time_to(error) / self.curve(problem, fast).time_to(error)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, texts and lists; times in seconds, None for errors that were not reached."""
        result = asdict(self)
        for plain, curve in zip(result["curves"], self.curves, strict=True):
            times = {f"{error:g}": curve.time_to(error) for error in (1e-6, 1e-10)}
            plain["seconds_to"] = {k: None if math.isnan(v) else v for k, v in times.items()}
        return result

    def plot(self, ax: Any = None) -> Any:
        """Draw CPU time against achieved error, one panel a problem.

        Parameters
        ----------
        ax : Axes or sequence of Axes, optional
            One for each problem; new ones unless given.

        Returns
        -------
        Axes or ndarray of Axes
        """
        from symfric_evidence.bench.picture import work_precision

        return work_precision(self, ax)
