"""Amplitude against belt speed, Thomsen, figures 5 and 6."""

import numpy as np

from symfric.errors import NotFound
from symfric.model import laws, scenes
from symfric.report.sources.panels import Curve, FigureData, Panel
from symfric.report.sources.registry import Finding
from symfric.report.study.comparison import stick_onset
from symfric.report.study.measurement import vibrations
from symfric.report.study.prediction import belt_curves
from symfric.scenefile import SweepPlan
from symfric.theory import belt

LEAST = (0.25, 0.35, 0.363333)  # mu_m of figure 6
PLAN = SweepPlan("v_b", 0.02, 0.46, 23, "x", 10000.0, 60.0)  # near the onset vibration grows and decays slowly
SPEED, AMPLITUDE = r"$v_b$", "amplitude of $x$"


def scene_of(mu_m: float):
    """Return the belt of figure 3 with another least coefficient."""
    return scenes.mass_on_belt(laws.cubic(0.4, mu_m, 0.5), v_b=0.2, beta=0.05)


def computed(mu_m: float, plan: SweepPlan = PLAN) -> tuple[np.ndarray, np.ndarray]:
    """Return belt speeds and the half range of the steady vibration."""
    speeds = np.linspace(plan.start, plan.stop, plan.number)
    found = vibrations(scene_of(mu_m), "v_b", speeds, plan, lambda _fraction: None)
    return speeds, np.array([v.half_range for v in found])


def _deviation(scene, speeds: np.ndarray, half: np.ndarray, order: int, low: float, high: float) -> tuple[float, float]:
    """Return the smallest and the largest relative deviation of the prediction between two belt speeds."""
    inside = (speeds > low) & (speeds < high) & (half > 0)
    predicted = belt_curves(scene, speeds[inside])[order - 1].amplitude
    off = predicted / half[inside] - 1
    return float(np.nanmin(off)), float(np.nanmax(off))


def _percent(pair: tuple[float, float]) -> str:
    return f"{100 * pair[0]:+.1f} to {100 * pair[1]:+.1f} %"


def figure_5() -> FigureData:
    """Amplitude against belt speed without excitation: predicted and computed."""
    scene, (speeds, half) = scene_of(0.25), computed(0.25)
    fine = np.linspace(0.001, 0.46, 921)
    first, second = belt_curves(scene, fine)
    v_b0, v_b1 = belt.stick_speed(scene), belt.onset_speed(scene)
    curves = (
        Curve("(20), (28)", fine, first.amplitude),
        Curve("second order, not in the source", fine, second.amplitude, 1, dash="dashed"),
        Curve("computed: half the range of $x$", speeds, half, 2, dash="none", marker="o"),
    )
    near = np.linspace(v_b0 * 1.004, v_b1 * 0.998, 7)
    slip = np.array([v.half_range for v in vibrations(scene, "v_b", near, PLAN, lambda _fraction: None)])
    panel = Panel("", SPEED, AMPLITUDE, curves, y_range=(0, 0.45), marks=(("$v_{b0}$", v_b0), ("$v_{b1}$", v_b1)))
    caption = r"$\gamma^2$ = 1, $\beta$ = 0.05, $\mu_s$ = 0.4, $\mu_m$ = 0.25, $v_m$ = 0.5; no excitation."
    sticks = stick_onset(scene, 0.9 * v_b0, 1.05 * v_b0)
    findings = (
        Finding("v_b0 = 0.3944, v_b1 = 0.4410", f"{v_b0:.4f} and {v_b1:.4f}; sticking starts at {sticks:.6f}", True),
        Finding("v_b0 = sqrt(4/3) v_b1, (21)", f"v_b0/v_b1 = {v_b0 / v_b1:.4f} = sqrt(4/5), as its numbers say", False),
        Finding("(20) agrees excellently in pure slip", _percent(_deviation(scene, near, slip, 1, v_b0, v_b1)), True),
        Finding(
            "(28) somewhat underestimates stick-slip",
            f"{_percent(_deviation(scene, speeds, half, 1, 0, v_b0))}; to second order "
            f"{_percent(_deviation(scene, speeds, half, 2, 0, v_b0))}",
            True,
        ),
        Finding(
            f"A0,max = v_b0 = {v_b0:.4f} is the largest attainable amplitude",
            f"(28) itself gives {np.nanmax(first.amplitude):.4f} there: (20) and (28) do not join",
            False,
        ),
    )
    return FigureData("thomsen-5", caption, (panel,), 1, findings)


def figure_6() -> FigureData:
    """Amplitude against belt speed for three levels of the friction difference."""
    fine, curves, findings = np.linspace(0.001, 0.46, 921), [], []
    for k, (mu_m, marker) in enumerate(zip(LEAST, ("x", "o", "s"), strict=True)):
        scene, (speeds, half) = scene_of(mu_m), computed(mu_m)
        eta = belt.friction_difference(scene)
        curves.append(Curve(rf"$\eta$ = {eta:.2f}", fine, belt_curves(scene, fine)[0].amplitude, k))
        curves.append(Curve("", speeds, half, k, dash="none", marker=marker))
        off = _deviation(scene, speeds, half, 1, 0, belt.stick_speed(scene))
        findings.append(max(map(abs, off)))
    words = ", ".join(f"{100 * off:.1f} %" for off in findings)
    try:
        belt.onset_speed(scene_of(0.4 - 0.1 / 3))
        last = Finding("no vibration at eta = 2 beta = 0.10", "there is one", False)
    except NotFound:
        last = Finding("no vibration at eta = 2 beta = 0.10", "steady sliding is stable at every belt speed", True)
    agreement = Finding(
        "agreement becomes better as eta decreases",
        f"stick-slip off by up to {words}",
        findings == sorted(findings)[::-1],
    )
    panel = Panel("", SPEED, AMPLITUDE, tuple(curves), y_range=(0, 0.45))
    caption = "As figure 5, with $\\mu_m$ = 0.25, 0.35, 0.363333; curves: (20) and (28), points computed."
    return FigureData("thomsen-6", caption, (panel,), 1, (agreement, last))
