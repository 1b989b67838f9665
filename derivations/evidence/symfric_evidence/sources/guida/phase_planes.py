"""Friction characteristics and phase planes of drawn slides: Guida, figures 2, 3, 6-9 and 13."""

from typing import TypedDict

import numpy as np

from symfric.model import laws, scenes
from symfric.theory import drive
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve, panels_entry
from symfric_evidence.sources.registry import Finding


class Slopes(TypedDict):
    """Slopes of the friction below and above v*."""

    mu1: float
    mu2: float


class Stop(Slopes):
    """Slopes, and the excess of friction lambda at the stop of the drive."""

    lam: float


SLOPES: Slopes = {"mu1": -0.3, "mu2": 0.5}  # for figures 2 to 8; chosen here, the source has sketches
FC, EPSILON, SIGMA = 1.0, 0.6, 0.15
FORWARD = np.linspace(0.0, 5.0, 1001)[1:]
TYPES: dict[str, Stop] = {  # for figure 9; chosen here
    "a": {"mu1": -0.5, "mu2": 0.5, "lam": 0.25},
    "b": {"mu1": -0.5, "mu2": 1.5, "lam": 2.0},
    "c": {"mu1": -0.5, "mu2": 0.5, "lam": 2.0},
}
STOP = ("$x$", r"$x'$")


def characteristic(mu1: float, mu2: float) -> laws.Law:
    """Return the force of friction and damper over the sliding speed, by v*."""
    scene = scenes.drive_stop(mu1=mu1, mu2=mu2, lam=0.0, epsilon=EPSILON, fc=FC)
    return scene.contacts[0].law.where(scene.parameter_values())


def both_ways(law: laws.Law, top: float, shift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds less `shift` and the odd force, with the vertical segment at rest."""
    v = FORWARD[FORWARD <= top]
    speeds = np.concatenate([-v[::-1], [0.0, 0.0, 0.0, 0.0], v])
    stick, start = float(law.stick), float(law.at_rest)
    return speeds - shift, np.concatenate([-law(v[::-1]), [-start, -stick, stick, start], law(v)])


def figure_2() -> FigureData:
    """Friction and viscous force against the sliding velocity."""
    friction = characteristic(SLOPES["mu1"] - SIGMA, SLOPES["mu2"] - SIGMA)
    speeds, force = both_ways(friction, 3.0)
    curves = (
        PanelCurve("friction $F_a$", speeds, force),
        PanelCurve(r"viscous force $c(\dot X - v)$, $v = 2v^*$", speeds, 2 * SIGMA * (speeds - 2.0), 1, dash="dashed"),
    )
    levels = (("$F_{as}$", FC + EPSILON), ("$F_{ac}$", FC))
    panel = Panel("", r"$\dot X/v^*$", r"force over $m\omega_n v^*$", curves, marks=(("$v^*$", 1.0),), levels=levels)
    return FigureData("guida-2", _values(), (panel,), 1)


def figure_3() -> FigureData:
    """Dimensionless force of friction and damper, lengths by the drive's speed."""
    v = 2.0
    speeds, force = both_ways(characteristic(**SLOPES), 5.0)
    p_star = 1 / v - 1
    curve = PanelCurve("", speeds / v - 1, force / v)
    levels = (("$f_{1s}$", (FC + EPSILON) / v), ("$f_{1c}$", FC / v))
    panel = Panel(
        "", r"$x'$", r"$f = F/(m\omega_n v)$", (curve,), marks=(("rest", -1.0), ("$p^*$", p_star)), levels=levels
    )
    scene = scenes.drive_slide(**SLOPES, p_star=p_star, epsilon=EPSILON, fc=FC)
    law = scene.contacts[0].law.where(scene.parameter_values())
    w = np.linspace(0.01, 2.0, 200)
    off = float(np.max(np.abs(law(w) - characteristic(**SLOPES)(v * w) / v)))
    printed, right = -1 / v / (1 - v), -(1 - v) / -v  # p1/p2 with p1 = -v*/v; -p2/p1 with p1 = -v/v*
    corner = float(law.breaks[0]) - 1
    jump = float(law.stick - law.at_rest)
    findings = (
        Finding(
            "p* = p1/p2 with p1 = -v*/v, (1)",
            f"that is {printed:g}; the force has its corner at x' = {corner:g} = -p2/p1 with p1 = -v/v*, {right:g}",
            abs(printed - corner) < 1e-12,
        ),
        Finding(
            "eps = f_s - f_c is that of the maps",
            f"f_s - f_c = {jump:g} by v, and eps = {EPSILON:g} of the maps by v*: eps1 = eps (1 + p*)",
            abs(jump - EPSILON) < 1e-12,
        ),
        Finding("the ready scene has this force", f"off by {off:.1e}", off < 1e-12),
    )
    return FigureData("guida-3", f"$v = 2v^*$, by $v$. {_values()}", (panel,), 1, findings)


def figure_6() -> FigureData:
    """Dimensionless force of friction and damper in the stop phase, by the corner's speed."""
    V = 2.0
    law = characteristic(**SLOPES)
    levels = (("$f_s$", FC + EPSILON), ("$f_c$", FC), ("$f'_c$", -FC), ("$f'_s$", -FC - EPSILON))
    marks = (("$-(2 - p_2)$", -V - 1), ("$p_1$", -V), ("$p_2$", 1 - V))
    curve = PanelCurve("", *both_ways(law, 3.0, V))
    panel = Panel("", r"$x'$", "$f(x' - p_1)$", (curve,), x_range=(-5, 1), marks=marks, levels=levels)
    inner, bend = law(-1.0 + 1e-9), 2 * (SLOPES["mu1"] - SLOPES["mu2"])
    jumps = {sign: -FC + sign * bend - 2 * SLOPES["mu2"] - inner for sign in (1, -1)}  # at the corner, X' = -v*
    rising = np.linspace(-V - 3, -V - 0.001, 40001)
    slopes = np.diff(law(rising + V))
    corner = float(rising[1 + np.argmax(np.abs(np.diff(slopes)))])
    findings = (
        Finding(
            "(8), last branch: f'c + 2(mu1 - mu2) + 2 mu2 (x' - p1)",
            f"it jumps by {jumps[1]:g} at the corner; with a minus by {abs(jumps[-1]):.0e}",
            abs(jumps[1]) < 1e-6,
        ),
        Finding(
            "the corner backward is at -(2 - p2)",
            f"the slope changes at {corner:.3f}, and -(2 - p2) = {-(2 - (1 - V)):g}",
            abs(corner + 2 - (1 - V)) < 1e-3,
        ),
    )
    return FigureData("guida-6", f"$v = 2v^*$: $p_1$ = -2, $p_2$ = -1. {_values()}", (panel,), 1, findings)


def _plane(speed: float, title: str) -> tuple[Panel, drive.PositioningError]:
    """Return the phase plane of the stop from a drive of some speed, and the error."""
    law, V = characteristic(**SLOPES), speed
    lam = drive.excess(**SLOPES, speed=V)
    error = drive.positioning_error(**SLOPES, lam=lam, epsilon=EPSILON)
    E = -(FC + lam)
    moving, still = both_ways(law, 5.0, V), both_ways(law, 5.0)
    curves = [
        PanelCurve("$x = -f(x' - p_1)$, drive moves", -moving[1], moving[0]),
        PanelCurve("$x = -f(x')$, drive stands", -still[1], still[0], 1),
        PanelCurve("E", np.array([E]), np.array([0.0]), 4, dash="none", marker="o"),
    ]
    if error.value > 0:
        x, w = _trajectory(**SLOPES, lam=lam)
        curves.append(PanelCurve(rf"after the stop, $\Delta S$ = {error.value:.3f}", x, w, 4))
    levels = (("$p_1$", -V), ("1", 1.0))
    return Panel(title, *STOP, tuple(curves), x_range=(-4, 4), y_range=(-4, 4), levels=levels), error


def _trajectory(mu1: float, mu2: float, lam: float, epsilon: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return place and speed of a slide after the stop, until it rests."""
    from symfric.solve.routes import simulate

    scene = scenes.drive_stop(mu1=mu1, mu2=mu2, lam=lam, epsilon=epsilon, fc=FC)
    run = simulate(scene).checked()
    end = next((e.t for e in run.events if e.t > 0), run.t_final)
    return tuple(run(np.linspace(0.0, end, 1000)))


def figure_7() -> FigureData:
    """Phase plane of the stop without a positioning error."""
    panel, error = _plane(2.0, "")
    lam = drive.excess(**SLOPES, speed=2.0)
    words = f"lambda = {lam:g} <= eps = {EPSILON:g}: Delta S = {error.value:g}"
    findings = (
        Finding("E stays an equilibrium, no error", words, error.value == 0),
        Finding(
            "more damping changes lambda = f(0) - fc",
            "only with the damper on the ground; on the support, as (3) and (9) have it, sigma does not enter",
            None,
        ),
    )
    return FigureData("guida-7", f"$v = 2v^*$. {_values()}", (panel,), 1, findings)


def figure_8() -> FigureData:
    """Phase plane of the stop with a positioning error."""
    panel, error = _plane(2.5, "")
    lam = drive.excess(**SLOPES, speed=2.5)
    x, _ = _trajectory(**SLOPES, lam=lam)
    words = f"lambda = {lam:g} > eps = {EPSILON:g}: Delta S = {error.value:.6f}, {x[-1] - x[0]:.6f} by the solver"
    findings = (Finding("E is no equilibrium any more, and the slide moves on", words, error.value > 0),)
    return FigureData("guida-8", f"$v = 2.5v^*$. {_values()}", (panel,), 1, findings)


def figure_9() -> FigureData:
    """The three types of motion after the stop."""
    curves, findings = [], []
    for k, (kind, given) in enumerate(TYPES.items()):
        x, w = _trajectory(**given)
        words = rf"{kind}: $\mu_2$ = {given['mu2']:g}, $\lambda$ = {given['lam']:g}"
        curves.append(PanelCurve(words, x, w, k))
        error = drive.positioning_error(**given)
        outcome = f"type {error.type}, Delta S = {error.value:.6f}, {x[-1] - x[0]:.6f} by the solver"
        findings.append(Finding(f"type {kind}", outcome, error.type == kind))
    mu1 = TYPES["a"]["mu1"]
    limit = -(FC + drive.type_limit(mu1))
    marks, levels = (("$E^*$", limit), ("$-f_c$", -FC)), (("1", 1.0),)
    panel = Panel("", *STOP, tuple(curves), y_range=(-0.1, 3.2), marks=marks, levels=levels)
    caption = rf"$\mu_1$ = {mu1:g}, $f_c$ = {FC:g}; ours, the source draws a sketch."
    return FigureData("guida-9", caption, (panel,), 1, tuple(findings))


def figure_13() -> FigureData:
    """Friction between two slides against their relative speed."""
    from symfric_evidence.sources.guida.slides import MOTIONS, PAIR

    scene = scenes.two_slides(**PAIR, **MOTIONS["guida-14"][0])
    law = scene.contacts[0].law.where(scene.parameter_values())
    speeds, force = both_ways(law, 2.0)
    levels = (("$f_{s1}$", float(law.stick)), ("$f_{c1}$", 1.0))
    panel = Panel("", r"$\eta_1' - \eta_2' + 1$", "$f$", (PanelCurve("", speeds, force),), levels=levels)
    return FigureData("guida-13", "$f_{c1}$ = 1, $f_{s1}$ = 7.4, of figure 14.", (panel,), 1)


def _values() -> str:
    given = ", ".join(rf"$\mu_{k[-1]}$ = {v:g}" for k, v in SLOPES.items())
    return rf"{given}, $f_c$ = {FC:g}, $\epsilon$ = {EPSILON:g}; ours, the source draws a sketch."


FIGURES = {
    "guida-2": panels_entry(figure_2),
    "guida-3": panels_entry(figure_3),
    "guida-6": panels_entry(figure_6),
    "guida-7": panels_entry(figure_7),
    "guida-8": panels_entry(figure_8),
    "guida-9": panels_entry(figure_9),
    "guida-13": panels_entry(figure_13),
}
