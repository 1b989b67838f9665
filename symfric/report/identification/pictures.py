"""Figures of the page of a fit."""

import numpy as np
from scipy.stats import norm

from symfric.identification.fit import Fit
from symfric.identification.plotting import plot_profile
from symfric.identification.profile import Profile
from symfric.report.html.elements import Picture
from symfric.report.study.drawing.axes import BLUE, GREY, ORANGE, new_axes, tidy, to_svg

LAGS = 30


def record_pictures(fit: Fit, name: str) -> list[Picture]:
    """Draw record and fit, the residuals, their autocorrelation and their distribution."""
    t, y = fit.records[name]
    rest, diagnostics = fit.residuals[name], fit.diagnostics[name]
    ax = new_axes()
    ax.plot(t, y, ".", color=GREY, markersize=3, label="measured")
    ax.plot(t, fit.predictions[name], color=BLUE, linewidth=1.1, label="fitted scene")
    ax.set_xlabel("t")
    ax.set_ylabel(name)
    ax.legend()
    below = new_axes()
    below.plot(t, rest, ".", color=ORANGE, markersize=3)
    below.axhline(0.0, color=GREY, linewidth=0.8)
    below.set_xlabel("t")
    below.set_ylabel(f"residual of {name}")
    fact = f"root mean square {diagnostics.rms:.4g}"
    return [
        Picture(to_svg(tidy(ax)), f"Record {name} and the fitted scene against time", f"Record {name} and the fit."),
        Picture(to_svg(tidy(below)), f"Residuals of {name}, {fact}", f"Residuals: {fact}."),
        _autocorrelation(rest, name),
        _distribution(rest, name),
    ]


def _autocorrelation(rest: np.ndarray, name: str) -> Picture:
    centred = rest - np.mean(rest)
    total = float(centred @ centred) or 1.0
    lags = np.arange(1, min(LAGS, rest.size - 1) + 1)
    rho = [float(centred[k:] @ centred[: rest.size - k]) / total for k in lags]
    ax = new_axes()
    ax.bar(lags, rho, color=BLUE, width=0.5)
    for way in (1, -1):
        ax.axhline(way * 1.96 / np.sqrt(rest.size), color=GREY, linestyle="--", linewidth=0.8)
    ax.set_xlabel("lag, samples")
    ax.set_ylabel("autocorrelation")
    words = "Autocorrelation of the residuals; white noise stays between the dashed lines at 19 of 20 lags."
    return Picture(to_svg(tidy(ax)), f"Autocorrelation of the residuals of {name}", words)


def _distribution(rest: np.ndarray, name: str) -> Picture:
    size = float(np.std(rest)) or 1.0
    ax = new_axes()
    ax.plot(norm.ppf((np.arange(rest.size) + 0.5) / rest.size), np.sort(rest - np.mean(rest)) / size, ".", color=BLUE)
    ends = np.array([-3.0, 3.0])
    ax.plot(ends, ends, color=GREY, linewidth=0.8)
    ax.set_xlabel("quantile of the normal distribution")
    ax.set_ylabel("residual / standard deviation")
    return Picture(
        to_svg(tidy(ax)),
        f"Quantiles of the residuals of {name} against those of the normal distribution",
        "Residuals of normal noise lie on the line.",
    )


def profile_picture(profile: Profile) -> Picture:
    """Draw a profile."""
    ax = plot_profile(profile, new_axes())
    words = f"{_range(*profile.interval)} with probability {100 * profile.level:g} %"
    caption = f"Lowest cost over {profile.name}; below the dashed line: {words}."
    return Picture(to_svg(tidy(ax)), f"Profile of {profile.name}: {words}", caption)


def _range(low: float, high: float) -> str:
    """Return an interval in words; the bounds of the fit cut off an end that is infinite."""
    if np.isfinite(low) and np.isfinite(high):
        return f"{low:.5g} to {high:.5g}"
    return f"at least {low:.5g}" if np.isfinite(low) else f"at most {high:.5g}" if np.isfinite(high) else "any value"
