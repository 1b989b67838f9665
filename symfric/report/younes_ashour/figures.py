"""Figures 3-7 and 10 of Younes and Ashour as data: each function computes one, nothing is drawn."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from symfric.report.data import plain
from symfric.report.younes_ashour.decays import FALLING, LAWS, START, decays, run_of, start_of
from symfric.theory.transient import averaged_decay_time

FREQUENCIES = (3.5, 5.0, 10.0, 20.0)  # Hz; the text names 3.5 and 10
FRICTION = (0.02, 0.05, 0.1, 0.2)
DAMPING = (0.0, 0.005, 0.01, 0.02, 0.05)
RODS = {"steel": {"mu_m": 0.19, "m": 0.679}, "aluminium": {"mu_m": 0.3, "m": 0.357}}  # fitted and weighed by the source
RIG = {"f_n": 5.3, "zeta": 0.009}  # measured by the source
DECAY_TIME, ENERGY = "decay time [s]", "initial energy [J]"
SAMPLES, POINTS = 3000, 120
ASSUMED = f"r = 1, g = 9.81 m/s$^2$, start at {1000 * START:g} mm"


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve.

    Attributes
    ----------
    label : str
    x, y : ndarray, shape (n,)
    group : int
        Curves of one group share a colour.
    closest : ndarray, shape (n,), or None
        Margin of the closest decision of each decay; where it is near 0 the decay time jumps.
    dash : str
        "solid", "dashed", or "dotted" for the averaged law.
    steps : bool
        Whether the curve is constant between jumps, as the time of a decay by half cycles is.
    """

    label: str
    x: np.ndarray
    y: np.ndarray
    group: int = 0
    closest: np.ndarray | None = None
    dash: str = "solid"
    steps: bool = False


@dataclass(frozen=True)
class Panel:
    """Curves over common axes.

    Attributes
    ----------
    title, x_label, y_label : str
    curves : tuple of Curve
    log : bool
        Whether the vertical axis is logarithmic.
    """

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    log: bool = False


@dataclass(frozen=True)
class FigureData:
    """One figure of the source.

    Attributes
    ----------
    name, caption : str
    panels : tuple of Panel
    columns : int
        Panels side by side.
    """

    name: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = 2

    def to_dict(self) -> dict[str, object]:
        """Return plain numbers and lists."""
        panels = [
            {
                "title": p.title,
                "x": p.x_label,
                "y": p.y_label,
                "curves": [{"label": c.label, "x": c.x, "y": c.y, "closest": c.closest} for c in p.curves],
            }
            for p in self.panels
        ]
        return plain({"figure": self.name, "caption": self.caption, "panels": panels})

    def __repr__(self) -> str:
        return f"FigureData({self.name}, {len(self.panels)} panels)"


def figure_3() -> FigureData:
    """Transients of supports of different stiffness."""
    panels = tuple(_transient(f"$f_n$ = {f:g} Hz", f_n=f, mu_m=0.1) for f in FREQUENCIES)
    return FigureData("3", rf"Transients without damping, $\mu_m$ = 0.1 (not said in the source); {ASSUMED}.", panels)


def figure_4() -> FigureData:
    """Transients of a soft support with different friction."""
    panels = tuple(_transient(rf"$\mu_m$ = {mu:g}", f_n=3.5, mu_m=mu) for mu in FRICTION)
    return FigureData("4", f"Transients at 3.5 Hz without damping; {ASSUMED}.", panels)


def figure_5() -> FigureData:
    """Decay time against friction."""
    friction = np.geomspace(0.02, 0.3, POINTS)

    def curves(law: str) -> list[Curve]:
        found = [
            _curve(f"{f:g} Hz", friction, decays(law, "mu_m", friction, f_n=f), "time", k)
            for k, f in enumerate(FREQUENCIES)
        ]
        if law == FALLING:
            found += [
                _averaged(friction, [averaged_decay_time(f, mu) for mu in friction], k)
                for k, f in enumerate(FREQUENCIES)
            ]
        return found

    caption = f"Decay time without damping; {ASSUMED}."
    return FigureData("5", caption, _by_law(curves, r"$\mu_m$", DECAY_TIME, log=True))


def figure_6() -> FigureData:
    """Decay time against the initial energy, given as displacement or as impulse."""
    energy = np.linspace(0.004, 0.2, POINTS)

    def curves(law: str) -> list[Curve]:
        found = []
        for k, f, impulse in ((k, f, i) for k, f in enumerate((3.5, 10.0, 20.0)) for i in (False, True)):
            word, fixed = ("impulse", {"x0": 0.0}) if impulse else ("displacement", {"v0": 0.0})
            starts = start_of(energy, f_n=f, m=0.5, impulse=impulse)
            runs = decays(law, "v0" if impulse else "x0", starts, f_n=f, mu_m=0.1, **fixed)
            curve = _curve(f"{f:g} Hz, {word}", energy, runs, "time", k)
            found.append(replace(curve, dash="dashed") if impulse else curve)
        return found

    caption = rf"Decay time without damping, $\mu_m$ = 0.1, m = 0.5 kg; {ASSUMED.split(', start')[0]}."
    return FigureData("6", caption, _by_law(curves, ENERGY, DECAY_TIME))


def figure_7() -> FigureData:
    """Dissipation ratio and decay time against the initial energy, for different damping."""
    energy = np.linspace(0.004, 0.4, POINTS)
    starts = start_of(energy, f_n=10.0, m=0.5)
    runs = {(law, z): decays(law, "x0", starts, f_n=10.0, mu_m=0.1, zeta=z) for law in LAWS for z in DAMPING}

    def of(what: str) -> Callable[[str], list[Curve]]:
        damping = DAMPING[1:] if what == "ratio" else DAMPING  # without damping the ratio is 0
        return lambda law: [_curve(rf"$\zeta$ = {z:g}", energy, runs[law, z], what, DAMPING.index(z)) for z in damping]

    ratios = _by_law(of("ratio"), ENERGY, r"$R = E_\mathrm{viscous}/E_\mathrm{contact}$")
    caption = rf"10 Hz, $\mu_m$ = 0.1, m = 0.5 kg; {ASSUMED.split(', start')[0]}."
    return FigureData("7", caption, (*ratios, *_by_law(of("time"), ENERGY, DECAY_TIME)))


def figure_10() -> FigureData:
    """Decay time of the two rods against the initial energy; the source shows records, this is its model."""
    energy = np.linspace(0.002, 0.1, POINTS)

    def curves(law: str) -> list[Curve]:
        found = []
        for k, (name, rod) in enumerate(RODS.items()):
            starts = start_of(energy, f_n=RIG["f_n"], m=rod["m"])
            label = rf"{name}, $\mu_m$ = {rod['mu_m']:g}"
            found.append(_curve(label, energy, decays(law, "x0", starts, **RIG, **rod), "time", k))
            if law == FALLING:
                smooth = [averaged_decay_time(mu_m=rod["mu_m"], x0=x0, **RIG) for x0 in starts]
                found.append(_averaged(energy, smooth, k))
        return found

    caption = r"Rods at 5.3 Hz, $\zeta$ = 0.009, $\mu_m$ and masses of the source, N = m g; the source shows records."
    return FigureData("10", caption, _by_law(curves, ENERGY, DECAY_TIME))


FIGURES: dict[str, Callable[[], FigureData]] = {
    "3": figure_3,
    "4": figure_4,
    "5": figure_5,
    "6": figure_6,
    "7": figure_7,
    "10": figure_10,
}


def _by_law(curves: Callable[[str], list[Curve]], x: str, y: str, log: bool = False) -> tuple[Panel, ...]:
    return tuple(Panel(law, x, y, tuple(curves(law)), log) for law in LAWS)


def _curve(label: str, x: np.ndarray, runs: list, what: str, group: int) -> Curve:
    y, closest = (np.array([getattr(run, name) for run in runs]) for name in (what, "closest"))
    return Curve(label, x, y, group, closest, steps=what == "time")


def _averaged(x: np.ndarray, y: list[float], group: int) -> Curve:
    return Curve("averaged law", x, np.array(y), group, dash="dotted")


def _transient(title: str, **values) -> Panel:
    """Return the motions with both laws, in mm, until a little after the later stop."""
    runs = {law: run_of(law, **values) for law in LAWS}
    t = np.linspace(0.0, 1.15 * max(run["stop_time"] for run in runs.values()), SAMPLES)
    curves = tuple(Curve(law, t, 1000 * run(t)[0], k) for k, (law, run) in enumerate(runs.items()))
    return Panel(title, "t [s]", "x [mm]", curves)
