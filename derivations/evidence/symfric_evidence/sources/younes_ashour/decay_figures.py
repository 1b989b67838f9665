"""Figures 3-10 of Younes and Ashour as data: each function computes one, nothing is drawn."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypedDict

import numpy as np

from symfric.solve.run import Run
from symfric.theory.transient import averaged_decay_time
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve
from symfric_evidence.sources.registry import Finding
from symfric_evidence.sources.younes_ashour.decays import (
    FALLING,
    GRAVITY,
    LAWS,
    START,
    RodDecay,
    decays,
    run_of,
    start_of,
)

FREQUENCIES = (3.5, 5.0, 10.0, 20.0)  # Hz; the text names 3.5 and 10
FRICTION = (0.02, 0.05, 0.1, 0.2)
DAMPING = (0.0, 0.005, 0.01, 0.02, 0.05)


class Rig(TypedDict):
    """Natural frequency, Hz, and damping ratio of the support of the rods."""

    f_n: float
    zeta: float


RODS = {"steel": {"mu_m": 0.19, "m": 0.679}, "aluminium": {"mu_m": 0.3, "m": 0.357}}  # fitted and weighed by the source
RIG: Rig = {"f_n": 5.3, "zeta": 0.009}  # measured by the source
DECAY_TIME, ENERGY = "decay time [s]", "initial energy [J]"
SAMPLES, POINTS = 3000, 120
ASSUMED = f"r = 1, g = 9.81 m/s$^2$, start at {1000 * START:g} mm"


def figure_3() -> FigureData:
    """Transients of supports of different stiffness."""
    panels = tuple(_transient(f"$f_n$ = {f:g} Hz", f_n=f, mu_m=0.1) for f in FREQUENCIES)
    return FigureData(
        "younes-3", rf"Transients without damping, $\mu_m$ = 0.1 (not said in the source); {ASSUMED}.", panels
    )


def figure_4() -> FigureData:
    """Transients of a soft support with different friction."""
    panels = tuple(_transient(rf"$\mu_m$ = {mu:g}", f_n=3.5, mu_m=mu) for mu in FRICTION)
    return FigureData("younes-4", f"Transients at 3.5 Hz without damping; {ASSUMED}.", panels)


def figure_5() -> FigureData:
    """Decay time against friction."""
    friction = np.geomspace(0.02, 0.3, POINTS)

    def curves(law: str) -> list[PanelCurve]:
        drawn = [
            _curve(f"{f:g} Hz", friction, decays(law, "mu_m", friction, f_n=f), "time", k)
            for k, f in enumerate(FREQUENCIES)
        ]
        if law == FALLING:
            drawn += [
                _averaged(friction, [averaged_decay_time(f, mu) for mu in friction], k)
                for k, f in enumerate(FREQUENCIES)
            ]
        return drawn

    caption = f"Decay time without damping; {ASSUMED}."
    return FigureData("younes-5", caption, _by_law(curves, r"$\mu_m$", DECAY_TIME, log="both"))


def figure_6() -> FigureData:
    """Decay time against the initial energy, given as displacement or as impulse."""
    energy = np.linspace(0.004, 0.2, POINTS)

    def curves(law: str) -> list[PanelCurve]:
        drawn = []
        for k, f, impulse in ((k, f, i) for k, f in enumerate((3.5, 10.0, 20.0)) for i in (False, True)):
            word, fixed = ("impulse", {"x0": 0.0}) if impulse else ("displacement", {"v0": 0.0})
            starts = start_of(energy, f_n=f, m=0.5, impulse=impulse)
            runs = decays(law, "v0" if impulse else "x0", starts, f_n=f, mu_m=0.1, **fixed)
            curve = _curve(f"{f:g} Hz, {word}", energy, runs, "time", k)
            drawn.append(replace(curve, dash="dashed") if impulse else curve)
        return drawn

    caption = rf"Decay time without damping, $\mu_m$ = 0.1, m = 0.5 kg; {ASSUMED.split(', start')[0]}."
    return FigureData("younes-6", caption, _by_law(curves, ENERGY, DECAY_TIME))


def figure_7() -> FigureData:
    """Dissipation ratio and decay time against the initial energy, for different damping."""
    energy = np.linspace(0.004, 0.4, POINTS)
    starts = start_of(energy, f_n=10.0, m=0.5)
    runs = {(law, z): decays(law, "x0", starts, f_n=10.0, mu_m=0.1, zeta=z) for law in LAWS for z in DAMPING}

    def of(what: str) -> Callable[[str], list[PanelCurve]]:
        damping = DAMPING[1:] if what == "ratio" else DAMPING  # without damping the ratio is 0
        return lambda law: [_curve(rf"$\zeta$ = {z:g}", energy, runs[law, z], what, DAMPING.index(z)) for z in damping]

    ratios = _by_law(of("ratio"), ENERGY, r"$R = E_\mathrm{viscous}/E_\mathrm{contact}$")
    caption = rf"10 Hz, $\mu_m$ = 0.1, m = 0.5 kg; {ASSUMED.split(', start')[0]}."
    return FigureData("younes-7", caption, (*ratios, *_by_law(of("time"), ENERGY, DECAY_TIME)))


def figure_8() -> FigureData:
    """Acceleration of the steel rod after a displacement; the source shows records, this is its model."""
    return _records("8", "steel")


def figure_9() -> FigureData:
    """Acceleration of the aluminium rod after a displacement; the source shows records, this is its model."""
    return _records("9", "aluminium")


def _records(number: str, name: str) -> FigureData:
    """Return accelerations of a rod from a large and a small displacement, ours: the source does not say its own."""
    rod, panels, shown = RODS[name], [], []
    counts: dict[str, list[int]] = {rod: [] for rod in RODS}
    for x0 in (0.01, 0.003):
        runs = {law: run_of(law, **RIG, **rod, x0=x0) for law in LAWS}
        t = np.linspace(0.0, 1.15 * max(run["stop_time"] for run in runs.values()), SAMPLES)
        curves = [
            PanelCurve(law, t, _acceleration(run, law, t, rod["mu_m"]), k) for k, (law, run) in enumerate(runs.items())
        ]
        panels.append(Panel(f"{name} rod, from {1000 * x0:g} mm", "t [s]", "acceleration [m/s$^2$]", tuple(curves)))
        for other, values in RODS.items():
            counts[other].append(len(run_of(FALLING, **RIG, **values, x0=x0).events))
        shown.append(f"{counts[name][-1]} half cycles, {runs[FALLING]['stop_time']:.4f} s from {1000 * x0:g} mm")
    claim, agrees = "steel takes more cycles than aluminium", np.greater(counts["steel"], counts["aluminium"]).all()
    if name == "aluminium":
        claim, agrees = "a small displacement comes to rest after one cycle", counts[name][-1] <= 2
    words = f"about measured records, {'so' if agrees else 'not so'} in the model: {'; '.join(shown)}"
    caption = rf"{name.capitalize()} rod, $\mu_m$ = {rod['mu_m']:g}, {rod['m']:g} kg, 5.3 Hz, $\zeta$ = 0.009, N = m g."
    return FigureData(f"younes-{number}", caption, tuple(panels), 2, (Finding(claim, words, True if agrees else None),))


def _acceleration(run: Run, law: str, t: np.ndarray, mu_m: float) -> np.ndarray:
    """Return the acceleration (2) gives at each time, 0 while the rod sticks, m/s^2."""
    omega, (x, u) = 2 * np.pi * RIG["f_n"], run(t)
    side = run.mode[0, np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, run.mode.shape[1] - 1)]
    friction = mu_m * GRAVITY * np.exp(-np.abs(u) if law == FALLING else -u)
    return np.where(side == 0, 0.0, -2 * RIG["zeta"] * omega * u - omega**2 * x - side * friction)


def figure_10() -> FigureData:
    """Decay time of the two rods against the initial energy; the source shows records, this is its model."""
    energy = np.linspace(0.002, 0.1, POINTS)

    def curves(law: str) -> list[PanelCurve]:
        drawn = []
        for k, (name, rod) in enumerate(RODS.items()):
            starts = start_of(energy, f_n=RIG["f_n"], m=rod["m"])
            label = rf"{name}, $\mu_m$ = {rod['mu_m']:g}"
            drawn.append(_curve(label, energy, decays(law, "x0", starts, **RIG, **rod), "time", k))
            if law == FALLING:
                smooth = [averaged_decay_time(mu_m=rod["mu_m"], x0=x0, **RIG) for x0 in starts]
                drawn.append(_averaged(energy, smooth, k))
        return drawn

    caption = r"Rods at 5.3 Hz, $\zeta$ = 0.009, $\mu_m$ and masses of the source, N = m g; the source shows records."
    return FigureData("younes-10", caption, _by_law(curves, ENERGY, DECAY_TIME))


FIGURES: dict[str, Callable[[], FigureData]] = {
    "younes-3": figure_3,
    "younes-4": figure_4,
    "younes-5": figure_5,
    "younes-6": figure_6,
    "younes-7": figure_7,
    "younes-8": figure_8,
    "younes-9": figure_9,
    "younes-10": figure_10,
}


def _by_law(curves: Callable[[str], list[PanelCurve]], x: str, y: str, log: str = "") -> tuple[Panel, ...]:
    return tuple(Panel(law, x, y, tuple(curves(law)), log) for law in LAWS)


def _curve(label: str, x: np.ndarray, runs: list[RodDecay], what: str, group: int) -> PanelCurve:
    y, closest = (np.array([getattr(run, name) for run in runs]) for name in (what, "closest"))
    return PanelCurve(label, x, y, group, closest, steps=what == "time")


def _averaged(x: np.ndarray, y: list[float], group: int) -> PanelCurve:
    return PanelCurve("averaged law", x, np.array(y), group, dash="dotted")


def _transient(title: str, **values: float) -> Panel:
    """Return the motions with both laws, in mm, until a little after the later stop."""
    runs = {law: run_of(law, **values) for law in LAWS}
    t = np.linspace(0.0, 1.15 * max(run["stop_time"] for run in runs.values()), SAMPLES)
    curves = tuple(PanelCurve(law, t, 1000 * run(t)[0], k) for k, (law, run) in enumerate(runs.items()))
    return Panel(title, "t [s]", "x [mm]", curves)
