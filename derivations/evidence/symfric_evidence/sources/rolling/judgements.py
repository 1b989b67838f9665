"""What the study of scaled rolling isolation says of its figures 4 to 8, judged on the ratios computed here."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symfric.motions.motion import Motion
from symfric.theory.scaling import factors
from symfric_evidence.sources.registry import Finding
from symfric_evidence.sources.rolling.printed_scheme import returned_by_steps, rounded_factors
from symfric_evidence.sources.rolling.study import SCALES, frictions

if TYPE_CHECKING:
    import xarray as xr

WORDS = {
    "peak_acceleration": "acceleration",
    "peak_velocity": "velocity",
    "peak_displacement": "displacement",
    "residual": "residual",
}
SIMILAR = 1e-6  # of a ratio: rounding in the residual, which may be a small difference of large displacements
ALLOWED = 0.2  # the source's limit of an error that is acceptable, section 3.1


def findings_of(name: str, study: "xr.Dataset", motions: Sequence[Motion]) -> tuple[Finding, ...]:
    """Return what the source says of a figure and what was found.

    Parameters
    ----------
    name : str
        "rolling-4" to "rolling-8".
    study : xarray.Dataset
        Ratios of the models of one friction over damping, model, motion and pga.
    motions : sequence of Motion
    """
    part = study.isel(damping=0)
    return {
        "rolling-4": lambda: _similar("RR close to 1, residuals within 20 %", part, motions, "case 1", moved=False),
        "rolling-5": lambda: (_uneven(part),),
        "rolling-6": lambda: _similar(
            "RR much closer to 1, except some special points of the residual", part, motions, "case 3", moved=True
        ),
        "rolling-7": lambda: (*_distorted(part), *_with_intensity(part), _with_damping(study)),
        "rolling-8": lambda: (*_by_density(part), *_with_intensity(part, "closer to 1"), _with_damping(study)),
    }[name]()


def _finite(part: "xr.Dataset", name: str) -> np.ndarray:
    """Return the sizes of the ratios of a response, shape (model, motion, pga); NaN where the prototype rests."""
    sizes = np.abs(part[f"ratio_{name}"].transpose("model", "motion", "pga").values)
    return np.where(np.isfinite(sizes), sizes, np.nan)


def _medians(part: "xr.Dataset", name: str) -> np.ndarray:
    """Return the medians over the motions, shape (model, pga)."""
    return np.asarray(np.nanmedian(_finite(part, name), axis=1))


def _worst(part: "xr.Dataset") -> float:
    return max(float(np.nanmax(np.abs(part[f"ratio_{k}"].values - 1))) for k in WORDS)


def _row(values: Iterable[float]) -> str:
    return ", ".join(f"{v:.2f}" for v in values)


def _similar(
    claim: str, part: "xr.Dataset", motions: Sequence[Motion], friction: str, *, moved: bool
) -> tuple[Finding, ...]:
    """Judge a figure whose models are similar to the prototype, and say where the printed scatter comes from."""
    worst = _worst(part)
    exact, rounded = (
        returned_by_steps(motions, frictions()[friction], by, moved=moved)
        for by in ([factors(float(L)) for L in SCALES], rounded_factors())
    )
    off = {
        what: {k: float(np.nanmax(np.abs(_size(r[k]) - 1))) for k in WORDS}
        for what, r in (("exact", exact), ("rounded", rounded))
    }
    shown = ", ".join(f"{WORDS[k]} {v:.1e}" for k, v in off["rounded"].items())
    steps = ", ".join(f"{WORDS[k]} {v:.0e}" for k, v in off["exact"].items())
    words = (
        f"all ratios are 1 within {worst:.0e}: it is a similarity. The source's fixed steps scale along and return 1 "
        f"too, within {steps}; with the factors as they are rounded in table 1 they are off by up to {shown}"
    )
    return (Finding(claim, words, worst < SIMILAR and max(off["exact"].values()) < SIMILAR),)


def _size(ratio: np.ndarray) -> np.ndarray:
    """Return ratios without those of a prototype that did not move."""
    return np.where(np.isfinite(ratio), np.abs(ratio), np.nan)


def _uneven(part: "xr.Dataset") -> Finding:
    ends = {k: (float(np.nanmin(_finite(part, k))), float(np.nanmax(_finite(part, k)))) for k in WORDS}
    widths = [high - low for low, high in ends.values()]
    shown = ", ".join(f"{WORDS[k]} {low:.2f} to {high:.3g}" for k, (low, high) in ends.items())
    claim = "the range widens from acceleration over velocity and displacement to the residual"
    return Finding(claim, shown, bool(np.all(np.diff(widths) > 0)))


def _distorted(part: "xr.Dataset") -> tuple[Finding, ...]:
    by = [factors(float(L)) for L in SCALES]
    gravity = [f.gravity_2 / f.gravity_1 for f in by]
    median = _medians(part, "peak_acceleration")
    return (
        Finding(
            "ARR is underestimated, and tends to 1 with rising PGA",
            f"medians at 1:{SCALES[-1]}: {_row(median[-1])}",
            bool(np.all(median < 1) and np.all(np.diff(median, axis=1) > 0)),
        ),
        Finding(
            "the underestimated ratio, of gravity, is just the model scale",
            ", ".join(f"1:{L}: {g:.4f}" for L, g in zip(SCALES, gravity, strict=True)),
            bool(np.max(np.abs(np.array(gravity) * SCALES - 1)) < 1e-12),
        ),
    )


def _with_intensity(part: "xr.Dataset", word: str = "") -> tuple[Finding, ...]:
    """Judge what rising PGA does to the other ratios; gravity scaled by density asks for no side of 1."""
    velocity, length, rest = (_medians(part, k) for k in ("peak_velocity", "peak_displacement", "residual"))
    near = np.abs(length - 1)
    worst = np.nanmax(np.abs(_finite(part, "peak_displacement") - 1), axis=1)
    at = f"medians at 1:{SCALES[-1]}"
    if word:
        responses = {"ARR": _medians(part, "peak_acceleration"), "RVRR": velocity, "relative DRR": length}
        closer = {k: bool(np.all(np.abs(m[:, -1] - 1) < np.abs(m[:, 0] - 1))) for k, m in responses.items()}
        comes = [
            Finding(f"{k} comes {word} when PGA increases", f"{at}: {_row(m[-1])}", closer[k])
            for k, m in responses.items()
        ]
        return (*comes, _irregular(rest))
    return (
        Finding(
            "PGA increases the underestimated RVRR",
            f"{at}: {_row(velocity[-1])}",
            bool(np.all(velocity[:, 0] < 1) and np.all(np.diff(velocity, axis=1) > 0)),
        ),
        Finding(
            "relative DRR tends to 1 when PGA increases",
            f"{at}: {_row(length[-1])}",
            bool(np.all(near[:, -1] < near[:, 0])),
        ),
        Finding(
            "relative DRR tends to 1 when PGA increases, by the motion furthest off",
            f"|DRR - 1| up to, at 1:{SCALES[-1]}: {_row(worst[-1])}",
            bool(np.all(worst[:, -1] < worst[:, 0])),
        ),
        _irregular(rest),
    )


def _irregular(rest: np.ndarray) -> Finding:
    steps = np.diff(rest, axis=1)
    one_way = np.all(steps > 0, axis=1) | np.all(steps < 0, axis=1)
    words = f"medians at 1:{SCALES[-1]}: {_row(rest[-1])}; {int(one_way.sum())} of {len(rest)} scales go one way"
    return Finding("residual DRR changes irregularly with PGA", words, not bool(np.all(one_way)))


def _with_damping(study: "xr.Dataset") -> Finding:
    """Judge whether the larger damping constant brings the ratio of accelerations nearer to 1."""
    medians = [_medians(study.isel(damping=k), "peak_acceleration") for k in (0, 1)]
    gap = [np.abs(m - 1) for m in medians]
    shown = "; ".join(f"C = {c / 1e3:g}: {_row(m[-1])}" for c, m in zip(study.damping.values, medians, strict=True))
    return Finding(
        "a larger damping constant reduces the errors, of ARR",
        f"medians at 1:{SCALES[-1]}, kN s/m: {shown}",
        bool(np.all(gap[1] < gap[0])),
    )


def _by_density(part: "xr.Dataset") -> tuple[Finding, ...]:
    accelerations = [factors(float(L), mass=0.008163).acceleration for L in SCALES]
    median = _medians(part, "peak_acceleration")
    short = np.array(accelerations) > 1  # gravity is less than similarity asks for
    ten = SCALES.index(10)
    ends = {k: (float(np.nanmin(_finite(part, k)[ten])), float(np.nanmax(_finite(part, k)[ten]))) for k in WORDS}
    off = {k: max(abs(low - 1), abs(high - 1)) for k, (low, high) in ends.items()}
    shown = {k: f"{low:.2f} to {high:.2f}" for k, (low, high) in ends.items()}
    return (
        Finding(
            "ARR is under- or overestimated, as gravity is",
            f"medians at {part.pga.values[0]:g} g: "
            + ", ".join(f"1:{L} {m:.2f}" for L, m in zip(SCALES, median[:, 0], strict=True)),
            bool(np.all((median < 1) == short[:, None])),
        ),
        Finding(
            f"at 1:10 ARR is close to 1, its acceleration scale being {accelerations[ten]:.3f}",
            shown["peak_acceleration"],
            off["peak_acceleration"] < ALLOWED,
        ),
        Finding(
            "at 1:10 all ratios are always close to 1",
            ", ".join(f"{WORDS[k]} {shown[k]}" for k in WORDS),
            max(off.values()) < ALLOWED,
        ),
    )
