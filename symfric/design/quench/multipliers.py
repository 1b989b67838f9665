"""Floquet multipliers of the full event-driven model near an optimum, from its stroboscopic map."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite, nan, pi
from typing import Any, TypeAlias

import numpy as np

from symfric.design.comparison import Compared
from symfric.design.quench.belt_scene import AMPLITUDE, FREQUENCY, SPEED_NAME, Belt
from symfric.model.excitation import forcing_period
from symfric.model.outputs import Output, Trajectory
from symfric.model.results import Result
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare
from symfric.solve.run import Run

Strobe: TypeAlias = Callable[[np.ndarray], np.ndarray]  # state after one map
TOLERANCE = 1e-12  # tolerance of the runs, so that disturbances of 1e-6 resolve growth rates of 1e-6
BALANCE = 1e-8  # largest energy residual of a valid run
MAPS = 40  # half slow periods over which a disturbance is followed
PERIODS = 200  # most forcing periods of one map


@dataclass(frozen=True)
class MultiplierProbe(Result):
    """Decay of a small disturbance of the forced vibration of the full model.

    Attributes
    ----------
    v_b, a, Omega : float
    decay_rate : float
        Of the slow motion, 1/time, from the largest Floquet multiplier of the full model; negative: self-excited.
    averaged_rate : float
        The same in the averaged model, with the fast amplitude at this frequency.
    multiplier : float
        Largest absolute value over `duration`.
    amplitude_start, amplitude_end : float
        Stroboscopic distance from the forced vibration, as a displacement, at the start and after `duration * MAPS`.
    duration : float
        Time of one map: whole forcing periods, about half a slow one.
    energy_residual : float
    status : str
        "OK", or why there is no answer.
    """

    v_b: float
    a: float
    Omega: float
    decay_rate: float
    averaged_rate: float
    multiplier: float
    amplitude_start: float
    amplitude_end: float
    duration: float
    energy_residual: float
    status: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain Python data."""
        return {**super().to_dict(), "self_excited": self.self_excited}

    @property
    def self_excited(self) -> bool:
        """Whether the disturbance grows; False without an answer."""
        return self.decay_rate < 0


@dataclass(frozen=True)
class MultiplierCheck(Result):
    """Verification: the full model with slightly more and less excitation than the optimum.

    Attributes
    ----------
    step : float
        Relative change of a; the optimum itself lies at the limit.
    above, below : tuple of MultiplierProbe
        At the worst belt speeds of the averaged model; `below` is empty where no excitation is needed.
    limits : tuple of Compared
        Limited quantities, on the forced vibration at the optimum and at the worst belt speed of each.
    others : tuple of MultiplierProbe
        With the larger excitation at further belt speeds, local minima of the averaged damping.
    """

    _told = ("step", "agrees", "above", "others", "below", "limits")

    step: float
    above: tuple[MultiplierProbe, ...]
    below: tuple[MultiplierProbe, ...]
    limits: tuple[Compared, ...] = ()
    others: tuple[MultiplierProbe, ...] = ()

    @property
    def agrees(self) -> bool:
        """Whether the full model is stable above, self-excited below, and within the limits like the averaged one."""
        return not self.disagreements

    @property
    def disagreements(self) -> tuple[str, ...]:
        """Disagreements of the full model, as lines of text."""
        # with less excitation a probe without a result is no contradiction: the motion may stick and slip
        silent = {id(p) for p in self.below if p.status != "OK"}
        wrong = [
            words
            for p, words in self._probes()
            if id(p) not in silent and (p.status != "OK" or p.self_excited != (p.averaged_rate < 0))
        ]
        return (*wrong, *(_limit_words(row) for row in self.limits if not row.agrees))

    def _probes(self) -> list[tuple[MultiplierProbe, str]]:
        """Return every probe and its description."""
        return [
            (p, _probe_words(p, f"{100 * self.step:.3g} % {word}"))
            for probes, word in ((self.above, "more"), (self.others, "more"), (self.below, "less"))
            for p in probes
        ]

    def __str__(self) -> str:
        return "; ".join([*(words for _, words in self._probes()), *map(_limit_words, self.limits)])


def _probe_words(p: MultiplierProbe, share: str) -> str:
    state = "self-excited" if p.self_excited else "stable"
    state = state if p.status == "OK" else f"no answer ({p.status})"
    rates = f"decay rate {p.decay_rate:.4g}, averaged model {p.averaged_rate:.4g}"
    return f"with {share} excitation at v_b = {p.v_b:.5g} {state} ({rates})"


def _limit_words(row: Compared) -> str:
    seen = f"{row.computed:.4g}" if isfinite(row.computed) else "no answer"
    return f"{row.quantity}: {seen}, averaged model {row.predicted:.4g}"


def probe(
    belt: Belt, program: Program, duration: float, excitation: tuple[float, float], v_b: float, rest: float, rate: float
) -> MultiplierProbe:
    """Run the full model about the quasi-equilibrium `rest` of the slow position; see `MultiplierProbe`.

    Parameters
    ----------
    belt : Belt
    program : Program
        Of the scene until `duration`.
    excitation : (float, float)
        a and Omega.
    rate : float
        Decay rate of the averaged model.
    """
    a, Omega = excitation
    runs: list[Run] = []
    strobe, size = _strobe(belt, program, excitation, v_b, runs)
    start = np.array([rest, 0.0]) + belt.fast_start(a, Omega)
    x, slopes = _fixed_point(strobe, start, size)
    vibrates = bool(np.all(np.isfinite(slopes)))
    largest = float(np.max(np.abs(np.linalg.eigvals(slopes)))) if vibrates else nan
    first = 1e-4 * float(size[0])
    last = _followed(strobe, x, first, size) if vibrates else nan
    failed = next((r for r in runs if r.status != 0), None)
    residual = nan if failed else runs[-1].energy_residual()
    if failed:
        status = f"{failed.status.name}: {failed.advice}"
    elif residual > BALANCE:
        status = f"the energy residual of the run is {residual:.1g}, so its result is not valid"
    else:
        status = "OK" if vibrates else "no forced vibration of the forcing's period was found"
    decay = -float(np.log(max(largest, 1e-300))) / duration
    return MultiplierProbe(v_b, a, Omega, decay, rate, largest, first, last, duration, residual, status)


def forced(belt: Belt, program: Program, excitation: tuple[float, float], v_b: float, rest: float) -> dict[str, float]:
    """Return the initial state of the forced vibration about `rest`, by name; NaN if it is not found."""
    strobe, size = _strobe(belt, program, excitation, v_b, [])
    x, slopes = _fixed_point(strobe, np.array([rest, 0.0]) + belt.fast_start(*excitation), size)
    names = [s.name for s in belt.scene.system.states]
    return dict(zip(names, (x if np.all(np.isfinite(slopes)) else np.full(2, np.nan)).tolist(), strict=True))


def _strobe(
    belt: Belt, program: Program, excitation: tuple[float, float], v_b: float, runs: list[Run]
) -> tuple[Strobe, np.ndarray]:
    """Return the stroboscopic map of a program, which appends its runs to a list, and the sizes of its two states."""
    a, Omega = excitation
    names = [s.name for s in belt.scene.system.states]
    values = {SPEED_NAME: v_b, AMPLITUDE: a, FREQUENCY: Omega}
    speed = belt.gain * a * Omega or v_b

    def strobe(x: np.ndarray) -> np.ndarray:
        if runs and runs[-1].status != 0:  # stop after a failure
            return np.full(2, np.nan)
        runs.append(program.run(values=values, initial=dict(zip(names, x.tolist(), strict=True))))
        return runs[-1].final if runs[-1].status == 0 else np.full(2, np.nan)

    return strobe, np.array([speed / belt.frequency, speed])


def _followed(strobe: Strobe, x: np.ndarray, first: float, size: np.ndarray) -> float:
    """Return what remains of a displacement `first` from the forced vibration x after `MAPS` maps."""
    y = x + np.array([first, 0.0])
    for _ in range(MAPS):
        y = strobe(y)
    return float(np.hypot(*((y - x) / size)) * size[0])


def _fixed_point(strobe: Strobe, x: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the fixed point of the map and its derivatives there by Newton's method; NaN if it is not found."""
    for _ in range(12):
        slopes = _jacobian(strobe, x, size)
        gap = strobe(x) - x
        if not np.all(np.isfinite(slopes)) or not np.all(np.isfinite(gap)):
            break
        if np.max(np.abs(gap) / size) < 1e-9:
            return x, slopes
        x = x - np.linalg.solve(slopes - np.eye(2), gap)
    return x, np.full((2, 2), np.nan)


def _jacobian(strobe: Strobe, x: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return central differences of the map, scaled to equal units; eigenvalues do not depend on the scale."""
    step = 1e-6 * np.diag(size)
    return np.column_stack([(strobe(x + d) - strobe(x - d)) / (2e-6 * s) for d, s in zip(step, size, strict=True)])


def prepare_map(
    belt: Belt, excitation: tuple[float, float], v_b: float, meters: Mapping[str, Output] | None = None
) -> tuple[Program, float]:
    """Compile the scene over whole forcing periods that last about half a slow period; return it and their time.

    `meters` are outputs in addition to the trajectory.
    """
    a, Omega = excitation
    half = pi / belt.frequency
    scene = belt.scene.where({SPEED_NAME: v_b, AMPLITUDE: a, FREQUENCY: Omega})
    if forcing := forcing_period(scene):
        half = forcing * min(max(1, round(half / forcing)), PERIODS)
    return prepare(scene.until(half, {"path": Trajectory(), **(meters or {})}), TOLERANCE), half
