"""Plot functions for the figures of driven slides. Each takes ``axes=None`` and returns the Axes."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from symfric.report.study.drawing.axes import BLUE, COLOURS, GREEN, GREY, ORANGE, RED, WIDE, label, new_axes, tidy
from symfric_evidence.sources.guida import slides
from symfric_evidence.sources.panels import legend_below
from symfric_evidence.sources.registry import Entry, Finding

DASHED = (0, (4, 3))
CLOSE = ("-", "-", "-", "-", (0, (6, 3)), (0, (2, 2)))  # curves for large slopes lie on each other


def panels(rows: int, columns: int, size: tuple[float, float]) -> np.ndarray:
    """Return the Axes of a new figure without global state, shape (rows, columns)."""
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout="constrained").subplots(rows, columns, squeeze=False)


def _legend_above(axes: np.ndarray, columns: int) -> None:
    """Draw one legend, of the curves of the first panel, above all panels."""
    handles, labels = axes.flat[0].get_legend_handles_labels()
    axes.flat[0].figure.legend(handles, labels, loc="outside upper center", ncols=columns, frameon=False)


def plot_stability_maps(maps: Sequence[slides.StabilityMap], axes: Any = None) -> Any:
    """Draw mu2 against eps_crit, one panel for each p*; stick-slip lies below and to the right of a curve."""
    axes = panels(4, 2, (8.0, 11.0)) if axes is None else axes
    for ax, stability_map in zip(axes.flat, maps, strict=True):
        for (mu1, (mu2, epsilon)), colour in zip(stability_map.curves.items(), COLOURS, strict=False):
            ax.plot(np.where(epsilon > 0, epsilon, np.nan), mu2, color=colour, label=rf"$\mu_1 = {mu1:g}$")
        ax.set(xscale="log", yscale="log", xlim=(0.1, 100), ylim=(0.05, 1.0))
        _plain_ticks(ax.xaxis, (0.1, 1, 10, 100))
        _plain_ticks(ax.yaxis, (0.05, 0.1, 0.2, 0.5, 1))
        ax.grid(True, color="0.9", linewidth=0.8)
        ax.set_title(rf"$p^* = {stability_map.p_star:g}$", fontsize=10)
    for ax in axes[-1]:
        ax.set_xlabel(r"$\epsilon = (F_{as} - F_{ac})/(m\,\omega_n v^*)$")
    for ax in axes[:, 0]:
        ax.set_ylabel(r"$\mu_2$")
    _legend_above(axes, 4)
    return axes


def _plain_ticks(axis: Any, places: Sequence[float]) -> None:
    from matplotlib.ticker import NullFormatter

    axis.set_ticks(places, [f"{p:g}" for p in places])
    axis.set_minor_formatter(NullFormatter())


def plot_surfaces(surfaces: Sequence[slides.Surface], axes: Any = None) -> Any:
    """Draw lines of equal eps_crit over both slopes, one panel for each p*; below the grey edge it is 0."""
    axes = panels(1, 2, (9.0, 4.4)) if axes is None else axes
    for ax, surface in zip(axes.flat, surfaces, strict=True):
        square = surface.epsilon**2  # linear near the edge, so that linear interpolation is accurate
        levels = [e for e in (1.0, 3.0, 10.0, 30.0, 100.0, 1000.0) if np.mean(surface.epsilon < e) > 0.06]
        ax.fill_between(surface.mu1, 0, surface.edge, color="0.85", linewidth=0, label="any difference will do")
        lines = ax.contour(surface.mu1, surface.mu2, square, [e**2 for e in levels], cmap="viridis", norm="log")
        ax.clabel(lines, fmt={e**2: f"{e:g}" for e in levels}, fontsize=8)
        ax.set(xlabel=r"$\mu_1$", ylabel=r"$\mu_2$", title=rf"$\epsilon_\mathrm{{crit}}$ at $p^* = {surface.p_star:g}$")
        ax.set(xlim=(surface.mu1[0], surface.mu1[-1]), ylim=(0, surface.mu2[-1]))
    legend_below(axes)
    return axes


def plot_errors(diagrams: Sequence[slides.ErrorDiagram], axes: Any = None) -> Any:
    """Draw Delta S_lambda against lambda, one panel for each mu1; a dashed line where type a ends."""
    axes = panels(2, 2, (8.5, 7.2)) if axes is None else axes
    for ax, diagram in zip(axes.flat, diagrams, strict=True):
        for (mu2, error), colour, dash in zip(diagram.error.items(), COLOURS, CLOSE, strict=False):
            ax.plot(diagram.lam, error, color=colour, linestyle=dash, label=rf"$\mu_2 = {mu2:g}$")
        if diagram.limit > 0:
            ax.axvline(diagram.limit, color=GREY, linewidth=0.9, linestyle=DASHED)
        ax.set(xlim=(0, diagram.lam[-1]), ylim=(0, None), title=rf"$\mu_1 = {diagram.mu1:g}$")
        tidy(ax)
    for ax in axes[-1]:
        ax.set_xlabel(r"$\lambda$")
    for ax in axes[:, 0]:
        ax.set_ylabel(r"$\Delta S_\lambda = \Delta S - \lambda$")
    _legend_above(axes, 6)
    return axes


def plot_slides_motion(motion: slides.SlidesMotion, axes: Any = None) -> Any:
    """Draw a motion of two slides as the source does: phase planes, both slides in time, the relative speed."""
    if axes is None:
        axes = panels(3, 2, (9.0, 10.5))
        axes[2, 1].remove()
        axes[2, 1] = axes.flat[0].figure.add_subplot(3, 2, 6, projection="3d")
    relative = motion.u1 - motion.u2
    stuck = np.where(motion.sticking, relative, np.nan)
    for x, u, colour, k in ((motion.eta1, motion.u1, BLUE, 1), (motion.eta2, motion.u2, GREEN, 2)):
        axes[0, 0].plot(x, u, color=colour, label=rf"$\eta_{k}$")
        axes[0, 1].plot(x, relative, color=colour, label=rf"$\eta_{k}$")
        axes[1, k - 1].plot(motion.t, x, color=colour, label=rf"$\eta_{k}$")
        axes[1, k - 1].plot(motion.t, u, color=ORANGE, linewidth=1.1, label=rf"$\eta_{k}'$")
        axes[1, k - 1].set(xlabel=r"$\tau$", ylabel=rf"$\eta_{k},\ \eta_{k}'$")
    axes[0, 0].set(xlabel=r"$\eta_1,\ \eta_2$", ylabel=r"$\eta_1',\ \eta_2'$")
    axes[0, 1].set(xlabel=r"$\eta_1,\ \eta_2$", ylabel=r"$\eta_1' - \eta_2'$")
    axes[2, 0].plot(motion.t, relative, color=BLUE, label="slipping")
    axes[2, 0].plot(motion.t, stuck, color=ORANGE, linewidth=2.4, label="sticking")
    axes[2, 0].set(xlabel=r"$\tau$", ylabel=r"$\eta_1' - \eta_2'$")
    for ax in axes.flat[:5]:
        tidy(ax)
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
    axes[2, 1].plot(motion.eta1, motion.eta2, relative, color=BLUE, linewidth=1.0)
    axes[2, 1].plot(motion.eta1, motion.eta2, stuck, color=ORANGE, linewidth=2.0)
    axes[2, 1].set(xlabel=r"$\eta_1$", ylabel=r"$\eta_2$", zlabel=r"$\eta_1' - \eta_2'$")
    axes[2, 1].locator_params(nbins=4)
    axes[2, 1].tick_params(labelsize=8)
    axes[2, 1].figure.suptitle(",  ".join(f"{label(k, {})} = {v:g}" for k, v in motion.values.items()))
    return axes


def plot_readings(readings: slides.Readings, axes: Any = None) -> Any:
    """Draw the smallest fs1 with a cycle against s2 for both interpretations, and the cases of the source."""
    ax = new_axes(WIDE) if axes is None else axes
    words = {"omega1": r"$d_2 = s_2$, (24) as printed", "omega2": r"$d_2 = s_2/\zeta$, (23) as printed"}
    for (name, fs1), colour in zip(readings.fs1.items(), (BLUE, ORANGE), strict=True):
        ax.plot(
            readings.s2, np.where(np.isfinite(fs1), fs1, np.nan), color=colour, label=f"least $f_{{s1}}$: {words[name]}"
        )
    for figure, lasting in slides.SAID.items():
        values = {**slides.PAIR, **slides.MOTIONS[figure][0]}
        drawn = f"source's figure {figure[6:]}: {'vibration' if lasting else 'no vibration'}"
        ax.plot(values["s2"], values["fs1"], "o", color=RED if lasting else "black", label=drawn, markersize=5)
    ax.set(xscale="log", xlim=(readings.s2[0], readings.s2[-1]), xlabel=r"$s_2$", ylabel=r"$f_{s1}$")
    _plain_ticks(ax.xaxis, (0.05, 0.1, 0.2, 0.5, 1, 2))
    ax.grid(True, color="0.9", linewidth=0.8)
    legend_below(ax)
    return ax


def plot_stability_gap(gap: slides.StabilityGap, axes: Any = None) -> Any:
    """Draw the slopes of friction with proved stability, with stability by eigenvalues, and with instability."""
    ax = new_axes(WIDE) if axes is None else axes
    top = 1.25 * np.max(gap.exact)
    ax.fill_between(gap.zeta, 0, gap.definite, color=GREEN, alpha=0.25, linewidth=0, label="damping definite: stable")
    ax.fill_between(
        gap.zeta,
        gap.definite,
        gap.exact,
        color=ORANGE,
        alpha=0.35,
        linewidth=0,
        label="not definite, stable all the same",
    )
    ax.fill_between(gap.zeta, gap.exact, top, color=RED, alpha=0.2, linewidth=0, label="unstable")
    ax.plot(gap.zeta, gap.definite, color=GREEN)
    ax.plot(gap.zeta, gap.exact, color=RED)
    ax.set(xscale="log", xlim=(gap.zeta[0], gap.zeta[-1]), ylim=(0, top))
    ax.set(xlabel=r"$\zeta = \omega_1/\omega_2$", ylabel=r"falling slope of the friction, $-\mu$")
    _plain_ticks(ax.xaxis, (0.25, 0.5, 1, 2, 4))
    legend_below(ax)
    return ax


def _of_maps(maps: Sequence[slides.StabilityMap]) -> tuple[Finding, ...]:
    from symfric.model import scenes
    from symfric.theory import drive

    slopes, corners = slides.MAP_SLOPES, [m.p_star for m in maps]
    steep = [drive.threshold(a, 1.0, p) for a in slopes for p in corners]
    below = [drive.threshold(a, 0.999, p) for a in slopes for p in corners]
    tangent = {2 * b: drive.threshold(-0.3, b, -0.2) for b in (0.55, 0.6, 0.75)}
    scene = scenes.drive_slide(mu1=-0.3, mu2=0.5, p_star=-0.2, epsilon=0.6)
    law = scene.contacts[0].law.where(scene.parameter_values())
    jump = float(law.stick - law.at_rest)
    return (
        Finding(
            "stable if the slope of the second section is greater than 1, read as mu2, the maps' ordinate",
            f"no threshold at mu2 = 1 for all {len(steep)} curves, p* < 0; at mu2 = 0.999 from {min(below):.3g} on",
            not np.any(np.isfinite(steep)) and bool(np.all(np.isfinite(below))),
        ),
        Finding(
            "the same read as the tangent that figure 3 draws, 2 mu2",
            ", ".join(f"eps_crit = {e:.4g} at 2 mu2 = {t:g}" for t, e in tangent.items()) + "; mu1 = -0.3, p* = -0.2",
            not np.any(np.isfinite(list(tangent.values()))),
        ),
        Finding(
            "eps of the maps is f_s - f_c of (3)",
            f"the force by v jumps by {jump:g} where the maps' eps, by v*, is 0.6: eps (1 + p*)",
            abs(jump - 0.6) < 1e-12,
        ),
    )


def _of_errors(diagrams: Sequence[slides.ErrorDiagram]) -> tuple[Finding, ...]:
    from symfric.theory import drive

    least = _steps_with_mu1(diagrams)
    rising2 = [np.all(np.diff([e[k] for e in d.error.values()]) >= 0) for d in diagrams for k in range(d.lam.size)]
    fixed = np.array([_at_speed(d.mu1, 6.0) for d in diagrams])
    mu1, mu2 = -0.5, 0.5
    lam, printed = drive.excess(mu1, mu2, 2.0), drive.excess(mu1, mu2, 2.0) + 2 * mu2
    error, solver = drive.positioning_error(mu1, mu2, lam + 0.2).value, _stopped(mu1, mu2, lam + 0.2)
    shifted = drive.positioning_error(mu1, mu2, lam + 0.2 + printed - lam).value
    return (
        Finding(
            "lambda = f(0) - fc + 2 mu2",
            f"the solver stops {solver:.6f} on, lambda = f(0) - fc gives {error:.6f}, the print {shifted:.6f}",
            abs(solver - shifted) < 1e-6,
        ),
        Finding(
            "the error increases as mu1 diminishes",
            f"by {least:.3g} at least from each mu1 to the next, at every lambda and mu2 drawn",
            least > 0,
        ),
        Finding(
            "the error increases as mu2 increases",
            f"not at {100 * (1 - np.mean(rising2)):.0f} % of the lambda drawn, where it falls or stays; at one speed "
            f"of the drive, 6 v*, {'it never falls' if np.all(np.diff(fixed, axis=1) >= 0) else 'it falls somewhere'}",
            bool(np.all(rising2)),
        ),
    )


def _steps_with_mu1(diagrams: Sequence[slides.ErrorDiagram]) -> float:
    """Return by how much the errors of the diagrams rise at least from each mu1 to the next lower one."""
    ordered = sorted(diagrams, key=lambda d: -d.mu1)
    errors = np.array([list(d.error.values()) for d in ordered])
    return float(np.min(np.diff(errors, axis=0)))


def _at_speed(mu1: float, speed: float) -> list[float]:
    """Return the errors at one speed of the drive over the second slopes that let the slide move on."""
    from symfric.theory import drive

    lam = {b: drive.excess(mu1, b, speed) for b in slides.SECOND_SLOPES}
    return [drive.positioning_error(mu1, b, e).value if e > 0 else 0.0 for b, e in lam.items() if b >= 0.5]


def _stopped(mu1: float, mu2: float, lam: float) -> float:
    """Return how far the event-driven solver lets the slide move on."""
    from symfric.model import scenes
    from symfric.solve.routes import simulate

    run = simulate(scenes.drive_stop(mu1=mu1, mu2=mu2, lam=lam)).checked()
    end = next(e.t for e in run.events if e.t > 0)
    return float(run(end)[0] - run(0.0)[0])


def _of_motion(name: str, motion: slides.SlidesMotion) -> tuple[Finding, ...]:
    late = motion.t > motion.t[0] + 0.6 * (motion.t[-1] - motion.t[0])
    sticking = bool(motion.sticking[late].any())
    seen = "it goes on sticking and slipping" if sticking else "it slides steadily"
    if name in slides.SAID:
        said = slides.SAID[name]
        return (Finding("the slides vibrate" if said else "no vibration", f"{seen}, with d2 = s2", sticking == said),)
    caption = slides.slides_cycle_of({"s1": 1.3, "s2": 0.3, "fs1": 7.4})
    return (
        Finding(
            "vibration with s2 = 1.3, of the text; the caption's s1 = 1.3, s2 = 0.3 decays",
            f"{seen}; with the caption's values cycles exist above fs1 = {caption:.4g} only, and fs1 is 7.4",
            sticking and caption > 7.4,
        ),
    )


def _of_readings(readings: slides.Readings) -> tuple[Finding, ...]:
    thresholds = list(readings.threshold.values())
    same = abs(thresholds[0] - thresholds[1]) < 1e-9 * thresholds[0]
    return (Finding("s2 has one meaning in (23) and (24)", readings.statement(), same),)


def _of_gap(gap: slides.StabilityGap) -> tuple[Finding, ...]:
    k = int(np.argmin(np.abs(gap.zeta - 2.0)))
    one = int(np.argmin(np.abs(gap.zeta - 1.0)))
    words = f"at zeta = {gap.zeta[k]:.3g}: definite down to mu = {-gap.definite[k]:.4f}, stable to {-gap.exact[k]:.4f}"
    apart = float(np.max(gap.exact / gap.definite - 1))
    meet = float(abs(gap.exact[one] / gap.definite[one] - 1))
    wider = np.all(gap.exact >= gap.definite * (1 - 1e-12))
    return (
        Finding(
            "(27) decides stability",
            f"it is {'sufficient' if wider else 'not sufficient'}, and exact within {meet:.0e} for zeta = "
            f"{gap.zeta[one]:.3g}; {words}",
            apart < 1e-9,
        ),
    )


def _motion_entry(name: str) -> Entry[Any]:
    change = ", ".join(f"{k} = {v:g}" for k, v in slides.MOTIONS[name][0].items())
    return Entry(
        f"Motion of two slides, {change}.",
        lambda _: slides.slides_motion(name),
        plot_slides_motion,
        findings=lambda motion: _of_motion(name, motion),
    )


def _error_entry(name: str) -> Entry[Any]:
    slopes = slides.ERROR_SLOPES[name]
    caption = f"Positioning errors, mu1 = {slopes[0]:g} ... {slopes[-1]:g}."
    return Entry(caption, lambda _: slides.error_diagrams(name), plot_errors, findings=_of_errors)


FIGURES = {
    "guida-4": Entry("Threshold of stick-slip over both slopes.", lambda _: slides.threshold_surfaces(), plot_surfaces),
    "guida-5": Entry(
        "Stability maps of a drawn slide.", lambda _: slides.stability_maps(), plot_stability_maps, findings=_of_maps
    ),
    **{name: _error_entry(name) for name in slides.ERROR_SLOPES},
    **{name: _motion_entry(name) for name in slides.MOTIONS},
    "guida-readings": Entry(
        "Least static friction of two slides that cycle.",
        lambda _: slides.readings(),
        plot_readings,
        findings=_of_readings,
    ),
    "guida-stability": Entry(
        "Sufficient and exact stability.", lambda _: slides.stability_gap(), plot_stability_gap, findings=_of_gap
    ),
}
