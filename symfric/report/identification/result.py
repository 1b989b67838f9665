"""What the page of a fit shows: the fit, its profiles, and plain data."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.identification.fit import Fit
from symfric.identification.profile import Profile
from symfric.model.scene import Scene
from symfric.report.html.versions import versions
from symfric.report.study.data import plain
from symfric.scenefile import SceneFile

MOST_PROFILES = 8  # unknowns beyond which profiles are left out


@dataclass(frozen=True)
class IdentificationResult:
    """A fit and what belongs to it.

    Attributes
    ----------
    file : SceneFile
    fit : Fit
    profiles : dict of str to Profile
        Of unknowns that the record fixes.
    intervals : dict of str to (float, float)
        Of 95 %; NaN where a profile finds that the fit is no minimum.
    missing : dict of str to str
        Why an unknown has no profile.
    seconds : float
    versions : dict of str to str
    """

    file: SceneFile
    fit: Fit
    profiles: dict[str, Profile]
    intervals: dict[str, tuple[float, float]]
    missing: dict[str, str]
    seconds: float
    versions: dict[str, str]


def identification(file: SceneFile, progress: Callable[[str, float], None] | None = None) -> IdentificationResult:
    """Fit what a scene file says.

    Raises
    ------
    SceneError
        If the file has no ``[identify]``, or the record is bad.
    NotFound
        If no run between the bounds reaches the end of the record.
    """
    asked = asked_fit(file)
    tell = progress or (lambda _stage, _fraction: None)
    begin = time.monotonic()
    tell("fit", 0.05)
    try:
        fit = asked(file.scene)
    except SceneError as error:
        raise SceneError(f"{file.path}: {error}") from None
    profiles, missing = {}, {}
    for k, name in enumerate(fit.names):
        tell(f"profile of {name}", 0.5 + 0.4 * k / len(fit.names))
        if np.isinf(fit.standard_errors[name]):
            missing[name] = "the record does not depend on it"
        elif len(fit.names) > MOST_PROFILES:
            missing[name] = f"there are more than {MOST_PROFILES} unknowns; use fit.profile"
        else:
            try:
                profiles[name] = fit.profile(name)
            except NotFound as reason:
                missing[name] = str(reason)
    intervals = {n: _interval(fit, n) for n in fit.names}
    return IdentificationResult(file, fit, profiles, intervals, missing, time.monotonic() - begin, versions())


def _interval(fit: Fit, name: str) -> tuple[float, float]:
    try:
        return fit.interval(name)
    except NotFound:
        return float("nan"), float("nan")


def asked_fit(file: SceneFile) -> Callable[[Scene], Fit]:
    """Return the fit that a scene file asks for, as a function of the scene; raise `SceneError` if there is none."""
    if file.identification is None:
        raise SceneError(
            f"{file.path}: there is no [identify] section; add one with record = 'measured.csv' and [identify.unknowns]"
        )
    return file.identification


def to_dict(result: IdentificationResult) -> dict[str, Any]:
    """Return a fit as plain data."""
    fit = result.fit
    data: dict[str, Any] = plain(
        {
            "file": result.file.path,
            "fit": fit.to_dict(),
            "intervals": {n: list(ends) for n, ends in result.intervals.items()},
            "profiles": {n: p.to_dict() for n, p in result.profiles.items()},
            "without_profile": result.missing,
            "predictions": {
                n: {"t": t, "measured": y, "predicted": fit.predictions[n]} for n, (t, y) in fit.records.items()
            },
            "seconds": result.seconds,
            "versions": result.versions,
        }
    )
    return data
