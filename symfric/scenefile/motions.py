"""Ground motions of a scene file: records beside it, and artificial ones from tables."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from symfric.errors import SceneError
from symfric.motions import record_files
from symfric.motions.motion import Motion
from symfric.motions.synthetic import sine_burst, synthetic
from symfric.motions.table import MotionTable
from symfric.scenefile.arguments import call_at, check_arguments, exact_numbers

MAX_SAMPLES, MAX_ITERATIONS = 1_000_000, 1000  # limits of a motion made from a table
_MADE: dict[str, Callable[..., Motion]] = {"synthetic": synthetic, "sine_burst": sine_burst}


def read_motion(motion: MotionTable, place: str, folder: Path | None) -> Motion:
    """Return the ground motion of a table.

    Parameters
    ----------
    motion : MotionTable
    place : str
        Place of the table, for messages.
    folder : Path or None
        Folder of the scene file, relative to which records are found; None if there is no file.
    """
    given = exact_numbers(motion.__pydantic_extra__)
    function: Callable[..., Motion]
    if motion.kind is not None and motion.file is None:
        function = _MADE[motion.kind]
    elif motion.file is not None and motion.kind is None:
        if folder is None:
            raise SceneError(f"{place}.file: a record's path is relative to a scene file; this scene was given as text")
        function = record_files.read_at2 if motion.file.lower().endswith(".at2") else record_files.read_text
        given = {"path": folder / motion.file, **given}
    else:
        raise SceneError(f"{place} needs one of file, a record's path, and kind, 'synthetic' or 'sine_burst'")
    check_arguments(place, function, given)
    if motion.kind is not None:
        _check_size(place, given)
    return call_at(place, function, given)


def _check_size(place: str, given: Mapping[str, Any]) -> None:
    """Raise on a motion with too many samples or iterations; `synthetic` limits its samples itself."""
    numbers = {k: v for k, v in given.items() if isinstance(v, float | int) and v > 0}
    each = 1 / numbers["dt"] / numbers.get("frequency", 1.0) if "dt" in numbers else 200
    if numbers.get("cycles", 10) * each > MAX_SAMPLES or numbers.get("iterations", 0) > MAX_ITERATIONS:
        raise SceneError(f"{place} has more than {MAX_SAMPLES} samples or {MAX_ITERATIONS} iterations; take fewer")
