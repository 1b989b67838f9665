"""Data of the figures of driven slides: maps, positioning errors, motions of two slides, limits of stability."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.model.scene import Scene
from symfric.theory import drive

MAP_SLOPES = (-0.1, -0.3, -0.6, -0.9)  # mu1 of the curves of figure 5
MAP_CORNERS = (-0.1, -0.2, -0.3, -0.4, -0.5, -0.6, -0.7, -0.8)  # p* of its panels
ERROR_SLOPES = {"guida-10": (-0.1, -0.25, -0.5, -0.75), "guida-11": (-1.0, -1.5, -3.0, -5.0)}  # mu1 of the diagrams
SECOND_SLOPES = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0)  # mu2 of their curves; chosen here, the source does not print them
PAIR: dict[str, Any] = {"r": 0.5, "zeta": 2.0, "s1": 0.2, "s2": 0.3, "fc1": 1.0}  # of figure 14
# changed parameters and time range of figures 14 to 16
MOTIONS: dict[str, tuple[dict[str, Any], tuple[float, float]]] = {
    "guida-14": ({"fs1": 7.4}, (0.0, 80.0)),
    "guida-15": ({"fs1": 7.8}, (60.0, 140.0)),
    # from the text; with s1 = 1.3 of the caption there is no vibration
    "guida-16": ({"fs1": 7.4, "s2": 1.3}, (40.0, 140.0)),
}
SAID = {"guida-14": False, "guida-15": True}  # whether the source's figure shows a lasting vibration


@dataclass(frozen=True, eq=False)
class StabilityMap:
    """One panel of figure 5.

    Attributes
    ----------
    p_star : float
    curves : dict of mu1 to (mu2, epsilon), each (n,)
        eps_crit, v*-scaled, from the mu2 on below which any difference of friction suffices, or from .05 on.
    """

    p_star: float
    curves: dict[float, tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class Surface:
    """One surface of figure 4: eps_crit over both slopes.

    Attributes
    ----------
    p_star : float
    mu1, mu2 : ndarray, shapes (n1,) and (n2,)
    epsilon : ndarray, shape (n2, n1)
    edge : ndarray, shape (n1,)
        mu2 below which eps_crit is 0.
    """

    p_star: float
    mu1: np.ndarray
    mu2: np.ndarray
    epsilon: np.ndarray
    edge: np.ndarray


@dataclass(frozen=True, eq=False)
class ErrorDiagram:
    """One diagram of figures 10 and 11.

    Attributes
    ----------
    mu1, limit : float
        Slope, and the lambda up to which the error is of type a.
    lam : ndarray, shape (n,)
    error : dict of mu2 to ndarray, shape (n,)
        Delta S_lambda, the error less lambda.
    """

    mu1: float
    limit: float
    lam: np.ndarray
    error: dict[float, np.ndarray]


@dataclass(frozen=True, eq=False)
class SlidesMotion:
    """A motion of two slides, figures 14 to 16.

    Attributes
    ----------
    values : dict of str to float
        Of the scene.
    t : ndarray, shape (n,)
    eta1, eta2, u1, u2 : ndarray, shape (n,)
        Places and speeds.
    sticking : ndarray of bool, shape (n,)
    """

    values: dict[str, float]
    t: np.ndarray
    eta1: np.ndarray
    eta2: np.ndarray
    u1: np.ndarray
    u2: np.ndarray
    sticking: np.ndarray


@dataclass(frozen=True, eq=False)
class Readings:
    """Comparison of both interpretations of s2.

    Attributes
    ----------
    s2 : ndarray, shape (n,)
    fs1 : dict of reading to ndarray, shape (n,)
        Smallest static friction of a limit cycle.
    threshold : dict of reading to float
        The same for the source's s2.
    cycles : dict of reading to dict of figure to bool
        Whether the event-driven solver finds a lasting vibration where the source draws one, or none.
    """

    s2: np.ndarray
    fs1: dict[str, np.ndarray]
    threshold: dict[str, float]
    cycles: dict[str, dict[str, bool]]

    @property
    def fitting(self) -> tuple[str, ...]:
        """The interpretations that reproduce every figure of the source."""
        return tuple(name for name, answers in self.cycles.items() if answers == SAID)

    def statement(self) -> str:
        """Return as text which interpretation fits the figures of the source."""
        meaning = {"omega1": "d2 = s2, as (24) is printed", "omega2": "d2 = s2/zeta, as (23) defines s2"}
        lines = []
        for name, answers in self.cycles.items():
            drawn = ", ".join(f"figure {f[6:]} {'vibrates' if answers[f] else 'does not vibrate'}" for f in SAID)
            lines.append(f"With {meaning[name]}, vibration lasts above fs1 = {self.threshold[name]:.6g}: {drawn}.")
        fit = " and ".join(meaning[name] for name in self.fitting) or "neither reading"
        return " ".join([*lines, f"The source's figures fit {fit}."])


@dataclass(frozen=True, eq=False)
class StabilityGap:
    """Sufficient and exact limits of the falling slope of friction of two slides.

    Attributes
    ----------
    zeta : ndarray, shape (n,)
        Ratio of the frequencies.
    definite, exact : ndarray, shape (n,)
        -mu up to which the damping is positive definite, and up to which steady sliding is stable.
    """

    zeta: np.ndarray
    definite: np.ndarray
    exact: np.ndarray


def stability_maps(number: int = 60) -> tuple[StabilityMap, ...]:
    """Return the eight panels of figure 5, so many points a curve."""
    return tuple(StabilityMap(p, {m: _map_curve(m, p, number) for m in MAP_SLOPES}) for p in MAP_CORNERS)


def _map_curve(mu1: float, p_star: float, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Return mu2 and eps_crit; the points are dense where the curve leaves its horizontal start."""
    low = max(zero_edge(mu1, p_star), 0.05)
    mu2 = low + (0.995 - low) * np.linspace(0.0, 1.0, number + 1)[1:] ** 2.5
    mu2[0] = low * (1 + 1e-6)
    return mu2, np.array([drive.threshold(mu1, b, p_star) for b in mu2])


def zero_edge(mu1: float, p_star: float) -> float:
    """Return the mu2 below which any difference of friction suffices for stick-slip, eps_crit = 0, by bisection."""
    low, high = 0.0, 1.0 - 1e-6
    if drive.threshold(mu1, low, p_star) > 0:
        return low
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if drive.threshold(mu1, middle, p_star) > 0 else (middle, high)
    return high


def threshold_surfaces(number: int = 41) -> tuple[Surface, ...]:
    """Return the two surfaces of figure 4, p* = -.1 and -.9."""
    mu1, mu2 = np.linspace(-1.0, 0.0, number), np.linspace(0.0, 0.98, number)
    surfaces = []
    for p in (-0.1, -0.9):
        epsilon = np.array([[drive.threshold(m, b, p) for m in mu1] for b in mu2])
        surfaces.append(Surface(p, mu1, mu2, epsilon, np.array([zero_edge(m, p) for m in mu1])))
    return tuple(surfaces)


def error_diagrams(figure: str, number: int = 60) -> tuple[ErrorDiagram, ...]:
    """Return the diagrams of "guida-10" or "guida-11"."""
    lam = np.linspace(0.0, 6.0, number + 1)[1:]
    return tuple(
        ErrorDiagram(m, drive.type_limit(m), lam, {b: _beyond(m, b, lam) for b in SECOND_SLOPES})
        for m in ERROR_SLOPES[figure]
    )


def _beyond(mu1: float, mu2: float, lam: np.ndarray) -> np.ndarray:
    return np.array([drive.positioning_error(mu1, mu2, e).value - e for e in lam])


def slides_motion(figure: str, damping: str = "omega1", number: int = 4000) -> SlidesMotion:
    """Return the motion of "guida-14", "guida-15" or "guida-16" by the event-driven solver."""
    from symfric.solve.routes import simulate

    change, (start, end) = MOTIONS[figure]
    run = simulate(_scene({**PAIR, **change}, damping, end), tolerance=1e-11).checked()
    t = np.union1d(np.linspace(start, end, number), run.t[(run.t >= start) & (run.t <= end)])
    at = np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, run.t.size - 1)
    eta1, eta2, u1, u2 = run(t)
    return SlidesMotion({**PAIR, **change}, t, eta1, eta2, u1, u2, run.mode[0, at] == 0)


def _scene(values: dict[str, Any], damping: Any, horizon: float) -> Scene:
    from symfric.model.scenes import two_slides

    return two_slides(**values, damping=damping, horizon=horizon)


def vibrates(figure: str, damping: str) -> bool:
    """Return whether the motion of a figure goes on sticking and slipping after a long time."""
    from symfric.model.outputs import Events
    from symfric.solve.routes import simulate

    horizon = 2000.0
    scene = _scene({**PAIR, **MOTIONS[figure][0]}, damping, horizon)
    events = simulate(scene.wanting({"events": Events()}), tolerance=1e-11).checked().events
    return events[-1].t > 0.9 * horizon


def slides_cycle_of(change: dict[str, float]) -> float:
    """Return the static friction above which a cycle exists, with some values of figure 14 changed."""
    given: dict[str, Any] = {k: v for k, v in {**PAIR, **change}.items() if k != "fs1"}
    return drive.two_slides_threshold(**given)


def readings(number: int = 60) -> Readings:
    """Evaluate both interpretations of s2 for figures 14 and 15."""
    s2 = np.geomspace(0.05, 3.0, number)
    rest = {k: v for k, v in PAIR.items() if k != "s2"}
    names = ("omega1", "omega2")
    return Readings(
        s2,
        {name: drive.two_slides_thresholds("s2", s2, **rest, damping=name) for name in names},
        {name: drive.two_slides_threshold(**PAIR, damping=name) for name in names},
        {name: {figure: vibrates(figure, name) for figure in SAID} for name in names},
    )


def stability_gap(number: int = 121) -> StabilityGap:
    """Return the limits on the slope of the friction over the ratio of frequencies, with the values of figure 14."""
    zeta = np.geomspace(0.25, 4.0, number)
    limits = [drive.slope_limits(r=PAIR["r"], s1=PAIR["s1"], s2=PAIR["s2"], zeta=z) for z in zeta]
    return StabilityGap(zeta, -np.array([e.definite for e in limits]), -np.array([e.exact for e in limits]))
