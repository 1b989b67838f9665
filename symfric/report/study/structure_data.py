"""The study of a structure as data: plain Python for JSON, rows for CSV."""

import csv
import io
import math
from collections.abc import Iterable

from symfric.report.study.branches import BranchResult
from symfric.report.study.structural import StructureResult
from symfric.report.study.study import StudyResult


def structure_dict(found: StructureResult | None) -> dict | None:
    """Return the results of a structure as plain data; None without one."""
    if found is None:
        return None
    plan = found.plan
    flutter, modes, error = found.flutter.value, found.modes.value, plan.small.error
    return {
        "matrices": plan.origin,
        "degrees_of_freedom": plan.full.n,
        "coordinates": plan.small.n,
        "points": {name: dict(row) for name, row in plan.points.items()},
        "reduction": None if error is None else error.to_dict(),
        "modes": None if modes is None else modes.frequency,
        "flutter": None if flutter is None else flutter.to_dict(),
        "open_in_steady_sliding": list(found.opened),
        "contacts": {
            s.contact: {"sticks": s.sticks, "least_load": s.least, "dissipated": s.dissipated} for s in found.shares
        },
    }


def branch_dict(found: BranchResult | None) -> dict | None:
    """Return limit cycles as plain data; None without them."""
    if found is None:
        return None
    return {
        "parameter": found.parameter,
        "coordinate": found.coordinate,
        "values": found.values,
        "half_range": found.half_range,
        "stable": found.stable,
        "special": [{"kind": s.kind, "value": s.value} for s in found.branch.special],
        "lift_off": {lift.contact: lift.value for lift in found.lift_off},
    }


def structure_tables(result: StudyResult) -> dict[str, str]:
    """Return the files of a structure and of limit cycles by their names, as CSV."""
    found, files = result.structure, {}
    if found is not None and found.flutter.value is not None:
        flutter = found.flutter.value
        head = [f"{part}_{k + 1}" for k in range(len(flutter.eigenvalues)) for part in ("growth", "frequency")]
        lines = zip(flutter.mu, *(e for row in flutter.eigenvalues for e in (row.real, row.imag)), strict=True)
        files["flutter.csv"] = _csv(["mu", *head], lines)
        if flutter.critical:
            head = [f"{part}_{k + 1}" for k in range(len(flutter.critical)) for part in ("real", "imaginary")]
            parts = [e for shape in flutter.shapes for e in (shape.real, shape.imag)]
            files["shapes.csv"] = _csv(["name", *head], zip(found.plan.full.names, *parts, strict=True))
    cycles = result.branch.value
    if cycles is not None:
        periods = [orbit.period for orbit in cycles.branch.orbits]
        rows = zip(cycles.values, cycles.half_range, periods, cycles.stable.astype(int), strict=True)
        files["cycles.csv"] = _csv([cycles.parameter, f"half_range of {cycles.coordinate}", "period", "stable"], rows)
    return files


def _csv(head: list[str], rows: Iterable[Iterable]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([_cell(v) for v in row] for row in rows)
    return stream.getvalue()


def _cell(value) -> str:
    if isinstance(value, str):
        return value
    return repr(float(value)) if math.isfinite(value) else ""
