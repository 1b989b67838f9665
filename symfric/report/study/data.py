"""A study as data: plain Python for JSON, rows for CSV."""

import csv
import io
import json
import math
from typing import Protocol

import numpy as np

from symfric.report.study.answers import StudyAnswer
from symfric.report.study.structure_data import branch_dict, structure_dict, structure_tables
from symfric.report.study.study import StudyResult


def plain(value):
    """Convert to JSON types; NaN and infinity become None."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    return str(value)


def to_dict(result: StudyResult) -> dict:
    """Return a study as plain data."""
    file, scene = result.file, result.file.scene
    numbers = scene.numbers()
    return plain(
        {
            "file": file.path,
            "title": file.title,
            "scene": {
                "model": file.model,
                "coordinates": [q.name for q in scene.system.q],
                "values": {s.name: v for s, v in scene.values.items()},
                "initial": {s.name: numbers[s] for s in scene.system.states},
                "horizon": scene.horizon,
                "units": dict(file.units),
            },
            "equilibrium": _asked(result.equilibrium),
            "stability": _asked(result.stability),
            "hopf": _asked(result.hopf),
            "safe_speed": _asked(result.safe),
            "motion": _motion(result),
            "steady": _steady(result),
            "sweep": _sweep(result),
            "structure": structure_dict(result.structure),
            "limit_cycles": branch_dict(result.branch.value),
            "quench": _quench(result),
            "designs": {d.plan.kind: _asked(d.design) for d in result.designs},
            "comparison": [
                {
                    "quantity": r.quantity,
                    "predicted": r.predicted,
                    "computed": r.computed,
                    "difference": r.difference,
                    "formula": r.formula,
                    "unit": r.unit,
                }
                for r in result.rows
            ],
            "skipped": result.skipped(),
            "explanation": str(result.explanation.value or result.explanation.note),
            "versions": dict(result.versions),
            "seconds": result.seconds,
        }
    )


class _Told(Protocol):
    def to_dict(self) -> dict: ...


def _asked(answer: StudyAnswer[_Told]) -> dict | None:
    return None if answer.value is None else answer.value.to_dict()


def _motion(result: StudyResult) -> dict | None:
    m = result.motion.value
    if m is None:
        return None
    return {
        "route": m.route,
        "status": m.status,
        "events": m.events,
        "energy_residual": m.energy_residual,
        "final": dict(zip(m.names, m.x[:, -1], strict=True)),
        "outputs": dict(m.outputs),
        "sticks": {k: [list(p) for p in v] for k, v in m.sticks.items()},
    }


def _steady(result: StudyResult) -> dict | None:
    v = result.steady.value
    if v is None:
        return None
    return {
        "coordinate": result.plan.coordinate,
        "half_range": v.half_range,
        "largest": v.largest,
        "smallest": v.smallest,
        "mean": v.mean,
        "period": v.period,
        "stick_fraction": v.stick_fraction,
        "settled": v.settled,
        "note": v.note,
    }


def _sweep(result: StudyResult) -> dict | None:
    sweep = result.sweep.value
    if sweep is None:
        return None
    return {
        "parameter": sweep.parameter,
        "coordinate": sweep.coordinate,
        "values": sweep.values,
        "half_range": sweep.half_range,
        "largest": [v.largest for v in sweep.computed],
        "smallest": [v.smallest for v in sweep.computed],
        "half_range_quenched": sweep.quenched,
        "predicted": [
            {"label": c.label, "formula": c.source, "values": c.values, "half_range": c.amplitude} for c in sweep.curves
        ],
        "marks": dict(sweep.marks),
    }


def _quench(result: StudyResult) -> dict | None:
    found = result.quench.value
    return None if found is None else found.design.to_dict()


def json_text(data: dict) -> str:
    """Return plain data as JSON."""
    return json.dumps(data, indent=2, allow_nan=False)


def data_files(result: StudyResult) -> dict[str, str]:
    """Return the tables beside a page, by their file names."""
    made = {"motion.csv": motion_csv(result), "amplitude.csv": amplitude_csv(result)}
    return {name: text for name, text in made.items() if text is not None} | structure_tables(result)


def motion_csv(result: StudyResult) -> str | None:
    """Return the motion as CSV: time and states, one line for each sample; None if it was not computed."""
    motion = result.motion.value
    if motion is None:
        return None
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["t", *motion.names])
    writer.writerows([repr(float(v)) for v in row] for row in np.column_stack([motion.t, motion.x.T]))
    return stream.getvalue()


def amplitude_csv(result: StudyResult) -> str | None:
    """Return the sweep as CSV, one line for each value; None without a sweep."""
    sweep = result.sweep.value
    if sweep is None:
        return None
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    head = [sweep.parameter, "half_range", "largest", "smallest", *(c.label for c in sweep.curves)]
    writer.writerow([*head, "half_range with excitation"] if sweep.quenched is not None else head)
    for k, value in enumerate(sweep.values):
        v = sweep.computed[k]
        row = [value, v.half_range, v.largest, v.smallest, *(c(value) for c in sweep.curves)]
        if sweep.quenched is not None:
            row.append(sweep.quenched[k])
        writer.writerow([repr(float(x)) if math.isfinite(x) else "" for x in row])
    return stream.getvalue()
