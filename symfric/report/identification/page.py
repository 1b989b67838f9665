"""One self-contained HTML page of a fit to a record."""

import math

from symfric.identification.fit import Fit
from symfric.report.html.versions import used
from symfric.report.html.words import inline_name, number
from symfric.report.identification.pictures import profile_picture, record_pictures
from symfric.report.identification.result import IdentificationResult
from symfric.templates import render


def page(result: IdentificationResult) -> str:
    """Return the page as HTML."""
    fit, file = result.fit, result.file
    return render(
        "identify.html",
        title=file.title or "A scene fitted to a record",
        file=file,
        record=file.identification.record.name if file.identification else "",
        summary=summary(result),
        unknowns=[_row(result, n) for n in fit.names],
        correlation=_correlation(fit),
        records=[(n, record_pictures(fit, n)) for n in fit.records],
        diagnostics=[
            [n, number(d.rms, 4), number(d.autocorrelation, 3), number(d.white, 3), number(d.runs, 3)]
            for n, d in fit.diagnostics.items()
        ],
        profiles=[profile_picture(p) for p in result.profiles.values()],
        missing=result.missing,
        starts=[[k + 1, number(m.cost), m.evaluations, m.changes] for k, m in enumerate(fit.tries)],
        seconds=result.seconds,
        used=used(result.versions),
    )


def summary(result: IdentificationResult) -> list[str]:
    """Return the main findings as sentences."""
    fit = result.fit
    lines = []
    for name, value in fit.values.items():
        error = fit.standard_errors[name]
        lines.append(f"{name} = {value:.6g}" + (f" ± {error:.2g}" if math.isfinite(error) else ""))
    samples = ", ".join(f"{t.size} of {n}" for n, (t, _) in fit.records.items())
    lines.append(f"{len(fit.names)} unknowns from {samples} samples; half the sum of squares {fit.cost:.6g}")
    return [*lines, *fit.notes]


def _row(result: IdentificationResult, name: str) -> list[str]:
    fit = result.fit
    low, high = result.intervals[name]
    profile = result.profiles.get(name)
    ends = profile.interval if profile else (math.nan, math.nan)
    values = (fit.values[name], fit.standard_errors[name], low, high, *ends)
    return [inline_name(name), *(number(v) for v in values), result.file.units.get(name, "")]


def _correlation(fit: Fit) -> list[list[str]]:
    return [[inline_name(n), *(number(v, 3) for v in row)] for n, row in zip(fit.names, fit.correlation, strict=True)]
