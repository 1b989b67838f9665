"""Motions of Thomsen's mass on a belt: figures 3, 4 and 8, and phase planes."""

from typing import Any

import numpy as np

from symfric.model import scenes
from symfric.orbits.steady_state import vibration
from symfric.theory import belt
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve
from symfric_evidence.sources.registry import Finding

QUIET: dict[str, Any] = {"v_b": 0.2, "beta": 0.05, "gamma2": 1.0}
SHAKEN: dict[str, Any] = {**QUIET, "a": 0.01, "Omega": 50.0}
SPEEDS = (0.05, 0.2, 0.3, 0.42)  # belt speeds of the phase planes; chosen here
TAU, X, V = r"$\tau$", r"$x$", r"$\dot{x}$"
TOLERANCE = 1e-10
NEAR = 0.01  # relative deviation up to which two numbers are called equal where the source reads them off a figure
SAID = {0.2: 0.86, 0.01: 0.83}  # frequency of stick-slip by belt speed, after (29)


def motion(values: dict[str, Any], end: float, number: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Return times and the states of the ready scene from rest."""
    from symfric.solve.routes import simulate

    run = simulate(scenes.mass_on_belt(**values, horizon=end), tolerance=TOLERANCE).checked()
    t = np.union1d(np.linspace(0.0, end, number), run.t)
    return t, run(t)


def _responses(values: dict[str, Any], end: float) -> tuple[Panel, ...]:
    t, (x, u) = motion(values, end)
    level = ((r"$v_b$", values["v_b"]),)
    return (
        Panel("displacement", TAU, X, (PanelCurve("", t, x),), x_range=(0, end)),
        Panel("velocity", TAU, V, (PanelCurve("", t, u),), x_range=(0, end), levels=level),
    )


def figure_3() -> FigureData:
    """Motion from rest without fast excitation: self-excited vibration grows up."""
    findings = []
    for speed, said in SAID.items():
        scene = scenes.mass_on_belt(**{**QUIET, "v_b": speed})
        steady = vibration(scene, "x", tolerance=TOLERANCE)
        frequency = 2 * np.pi / steady.period
        claim = f"frequency of stick-slip at v_b = {speed:g} is {said:g}"
        findings.append(Finding(claim, f"{frequency:.4f}", abs(frequency - said) < 0.005))
        if speed == min(SAID):
            words = f"sticking occupies most of the period at v_b = {speed:g}"
            share = steady.stick_fraction
            findings.append(Finding(words, f"{100 * share:.0f} % of it", share > 0.5))
    caption = r"$v_b$ = 0.2, $\gamma^2$ = 1, $\beta$ = 0.05, $\mu_s$ = 0.4, $\mu_m$ = 0.25, $v_m$ = 0.5; no excitation."
    return FigureData("thomsen-3", caption, _responses(QUIET, 60.0), 1, tuple(findings))


def figure_4() -> FigureData:
    """Motion from rest under fast excitation: the vibration is quenched."""
    t, (x, _) = motion({**SHAKEN}, 100.0)
    late = x[t > 80] + SHAKEN["a"] * np.sin(SHAKEN["Omega"] * t[t > 80])
    before = motion(QUIET, 100.0)[1][0][-800:]
    words = f"the slow part of x keeps a range of {np.ptp(late):.1e}, against {np.ptp(before):.3f} without excitation"
    finding = Finding("the fast excitation quenches self-excited oscillations", words, np.ptp(late) < 0.01)
    caption = r"As figure 3, with $a$ = 0.01, $\Omega$ = 50."
    return FigureData("thomsen-4", caption, _responses(SHAKEN, 60.0), 1, (finding,))


def figure_8() -> FigureData:
    """Full motion under fast excitation and its slow part."""
    from symfric.solve.routes import simulate
    from symfric.theory.separation import separate

    end, scene = 12.0, scenes.mass_on_belt(**SHAKEN, horizon=100.0)
    t, (x, u) = motion(SHAKEN, end, 8000)
    slow = simulate(separate(scene.until(end)), tolerance=TOLERANCE).checked()
    z, w = slow(t)
    full = vibration(scene, "x", tolerance=TOLERANCE)
    fast = vibration(scene, "u", tolerance=TOLERANCE)
    off = _distance(t, x, z)
    a, q = SHAKEN["a"], SHAKEN["a"] * SHAKEN["Omega"]
    mean = belt.quasi_equilibrium_position(scene)
    findings = (
        Finding(
            "the slow part traces the moving mean of x",
            f"x + a sin(Omega tau) stays within {off:.4f} of z, whose range is {np.ptp(z):.3f}",
            off < a,
        ),
        Finding(
            f"fast part of x has the amplitude a = {a:g}", f"{full.half_range:.6f}", abs(full.half_range / a - 1) < NEAR
        ),
        Finding(
            f"fast part of the velocity has the amplitude a Omega = {q:g}",
            f"{fast.half_range:.6f}",
            abs(fast.half_range / q - 1) < NEAR,
        ),
        Finding(
            f"quasi-equilibrium (51) at {mean:.8f}", f"mean of x is {full.mean:.8f}", abs(full.mean / mean - 1) < NEAR
        ),
    )
    panels = (
        Panel(
            "displacement",
            TAU,
            r"$x$, $z$",
            (PanelCurve("full motion $x$", t, x), PanelCurve("slow part $z$", t, z, 1)),
        ),
        Panel(
            "velocity", TAU, r"$\dot x$, $\dot z$", (PanelCurve(r"$\dot x$", t, u), PanelCurve(r"$\dot z$", t, w, 1))
        ),
    )
    return FigureData("thomsen-8", r"$v_b$ = 0.2, $a$ = 0.01, $\Omega$ = 50.", panels, 1, findings)


def _distance(t: np.ndarray, x: np.ndarray, z: np.ndarray) -> float:
    """Return how far x + a sin(Omega t), the slow part of (37), is from z at the most."""
    return float(np.max(np.abs(x + SHAKEN["a"] * np.sin(SHAKEN["Omega"] * t) - z)))


def phase_planes() -> FigureData:
    """Phase planes of the mass on a belt from rest to its limit cycle."""
    panels = []
    for speed in SPEEDS:
        t, (x, u) = motion({**QUIET, "v_b": speed}, 200.0, 12000)
        late = t > 185
        cycle = PanelCurve("after a long time", x[late], u[late], 1)
        panels.append(
            Panel(rf"$v_b$ = {speed:g}", X, V, (PanelCurve("from rest", x, u), cycle), levels=((r"$v_b$", speed),))
        )
    low, high = belt.stick_speed(scene := scenes.mass_on_belt(**QUIET)), belt.onset_speed(scene)
    caption = f"Not in the source. It sticks below $v_{{b0}}$ = {low:.4f} and vibrates below $v_{{b1}}$ = {high:.4f}."
    return FigureData("thomsen-phase-planes", caption, tuple(panels))
