"""Amplitude against belt speed, Thomsen, figures 5 and 6."""

from collections.abc import Iterable

import numpy as np

from symfric.model import laws, scenes
from symfric.model.scene import Scene
from symfric.report.study.measurement import vibrations
from symfric.report.study.sections.comparison import stick_onset
from symfric.report.study.sections.prediction import belt_curves
from symfric.scenefile import SweepPlan
from symfric.theory import belt
from symfric.theory.hopf import hopf
from symfric.theory.stability import stability
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve
from symfric_evidence.sources.registry import Finding

LEAST = (0.25, 0.35, 0.363333)  # mu_m of figure 6
PLAN = SweepPlan("v_b", 0.02, 0.46, 23, "x", 10000.0, 60.0)  # near the onset vibration grows and decays slowly
EXCELLENT, QUITE_GOOD, HIGHLY = 0.03, 0.1, 0.3  # relative deviations that these words are taken for, ours
SPEED, AMPLITUDE = r"$v_b$", "amplitude of $x$"


def scene_of(mu_m: float) -> Scene:
    """Return the belt of figure 3 with another least coefficient."""
    return scenes.mass_on_belt(laws.cubic(0.4, mu_m, 0.5), v_b=0.2, beta=0.05)


def computed(mu_m: float, plan: SweepPlan = PLAN) -> tuple[np.ndarray, np.ndarray]:
    """Return belt speeds and the half range of the steady vibration."""
    speeds = np.linspace(plan.start, plan.stop, plan.number)
    steady = vibrations(scene_of(mu_m), "v_b", speeds, plan, lambda _fraction: None)
    return speeds, np.array([v.half_range for v in steady])


def _deviation(
    scene: Scene, speeds: np.ndarray, half: np.ndarray, order: int, low: float, high: float
) -> tuple[float, float]:
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
        PanelCurve("(20), (28)", fine, first.amplitude),
        PanelCurve("second order, not in the source", fine, second.amplitude, 1, dash="dashed"),
        PanelCurve("computed: half the range of $x$", speeds, half, 2, dash="none", marker="o"),
    )
    near = np.linspace(v_b0 * 1.004, v_b1 * 0.998, 7)
    slip = np.array([v.half_range for v in vibrations(scene, "v_b", near, PLAN, lambda _fraction: None)])
    panel = Panel("", SPEED, AMPLITUDE, curves, y_range=(0, 0.45), marks=(("$v_{b0}$", v_b0), ("$v_{b1}$", v_b1)))
    caption = r"$\gamma^2$ = 1, $\beta$ = 0.05, $\mu_s$ = 0.4, $\mu_m$ = 0.25, $v_m$ = 0.5; no excitation."
    sticks = stick_onset(scene, 0.9 * v_b0, 1.05 * v_b0)
    slips, sticking = _deviation(scene, near, slip, 1, v_b0, v_b1), _deviation(scene, speeds, half, 1, 0, v_b0)
    middle = _deviation(scene, speeds, half, 1, 0.25 * v_b1, 0.75 * v_b1)
    largest = float(np.nanmax(half))
    at_onset = _by_orbits(scene, [0.999 * sticks, 1.001 * sticks])
    findings = (
        Finding(
            "v_b0 = 0.3944, v_b1 = 0.4410",
            f"{v_b0:.4f} and {v_b1:.4f}; sticking starts at {sticks:.6f}",
            (round(v_b0, 4), round(v_b1, 4)) == (0.3944, 0.441),
        ),
        Finding(
            "v_b0 = sqrt(4/3) v_b1, (21)",
            f"v_b0/v_b1 = {v_b0 / v_b1:.4f} = sqrt(4/5), as its numbers say",
            abs(v_b0 / v_b1 - np.sqrt(4 / 3)) < 1e-9,
        ),
        Finding(
            f"(20) agrees excellently in pure slip, within {100 * EXCELLENT:g} %",
            _percent(slips),
            max(map(abs, slips)) < EXCELLENT,
        ),
        Finding(
            "(28) somewhat underestimates stick-slip in the mid-range",
            f"{_percent(middle)} between 0.25 and 0.75 v_b1, {_percent(sticking)} in all; to second order "
            f"{_percent(_deviation(scene, speeds, half, 2, 0, v_b0))}",
            middle[1] < 0,
        ),
        Finding(
            f"A0,max = v_b0 = {v_b0:.4f} is the largest attainable amplitude",
            f"(28) gives {np.nanmax(first.amplitude):.4f} there, and the motion itself {max(largest, *at_onset):.4f} "
            "where sticking starts",
            max(largest, *at_onset) <= v_b0,
        ),
    )
    return FigureData("thomsen-5", caption, (panel,), 1, findings)


def _by_orbits(scene: Scene, speeds: Iterable[float]) -> list[float]:
    """Return the half range of x of the limit cycle at some belt speeds."""
    from symfric.orbits.cycle import limit_cycle

    return [float(limit_cycle(scene.where({"v_b": float(v)})).half_range[0]) for v in speeds]


def _large_difference() -> tuple[Finding, ...]:
    """Judge what is said of a friction difference near 1, where the small parameter is none any more."""
    scene = scene_of(0.4 - 1 / 3)
    eta, v_b0, v_b1 = belt.friction_difference(scene), belt.stick_speed(scene), belt.onset_speed(scene)
    onset = hopf(scene, "v_b", (0.9 * v_b1, 1.02 * v_b1)).value
    slip, stick = np.array([0.998 * v_b1, 0.45, 0.44]), np.array([0.1, 0.2, 0.3])
    off = [
        [
            belt.pure_slip_amplitude(scene.where({"v_b": v})) / h - 1
            for v, h in zip(slip, _by_orbits(scene, slip), strict=True)
        ],
        [
            belt.stick_slip_amplitude(scene.where({"v_b": v})) / h - 1
            for v, h in zip(stick, _by_orbits(scene, stick), strict=True)
        ],
    ]
    shown = [
        ", ".join(f"{100 * e:+.1f} % at {v:.4g}" for v, e in zip(at, e_, strict=True))
        for at, e_ in zip((slip, stick), off, strict=True)
    ]
    claim = f"for eta near 1 ({eta:.3f})"
    return (
        Finding(
            f"{claim} the onset remains quite good", f"{onset:.6f}, (19) {v_b1:.6f}", abs(onset / v_b1 - 1) < QUITE_GOOD
        ),
        Finding(
            f"{claim} (20) remains quite good, within {100 * QUITE_GOOD:g} %",
            f"{shown[0]}; v_b0 = {v_b0:.4f}",
            max(map(abs, off[0])) < QUITE_GOOD,
        ),
        Finding(f"{claim} (28) highly underestimates stick-slip", shown[1], min(off[1]) < -HIGHLY and max(off[1]) < 0),
    )


def figure_6() -> FigureData:
    """Amplitude against belt speed for three levels of the friction difference."""
    fine, curves, findings = np.linspace(0.001, 0.46, 921), [], []
    for k, (mu_m, marker) in enumerate(zip(LEAST, ("x", "o", "s"), strict=True)):
        scene, (speeds, half) = scene_of(mu_m), computed(mu_m)
        eta = belt.friction_difference(scene)
        curves.append(PanelCurve(rf"$\eta$ = {eta:.2f}", fine, belt_curves(scene, fine)[0].amplitude, k))
        curves.append(PanelCurve("", speeds, half, k, dash="none", marker=marker))
        off = _deviation(scene, speeds, half, 1, 0, belt.stick_speed(scene))
        findings.append(max(map(abs, off)))
    words = ", ".join(f"{100 * off:.1f} %" for off in findings)
    critical = scene_of(0.4 - 0.1 / 3)
    at = [0.01, 0.1, 0.2, 0.3, 0.4, 0.49]
    margins = [stability(critical.where({"v_b": v})).margin for v in at]
    last = Finding(
        "no vibration at eta = 2 beta = 0.10",
        f"steady sliding decays at least with the rate {min(margins):.1e} for v_b = {at[0]:g} to {at[-1]:g}",
        min(margins) > 0,
    )
    agreement = Finding(
        "agreement becomes better as eta decreases",
        f"stick-slip off by up to {words}",
        findings == sorted(findings)[::-1],
    )
    panel = Panel("", SPEED, AMPLITUDE, tuple(curves), y_range=(0, 0.45))
    caption = "As figure 5, with $\\mu_m$ = 0.25, 0.35, 0.363333; curves: (20) and (28), points computed."
    return FigureData("thomsen-6", caption, (panel,), 1, (agreement, last, *_large_difference()))
