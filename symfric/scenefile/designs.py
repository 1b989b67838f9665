"""Designs of a scene file: the checked tables of ``[design]`` as calls of functions in ``sf.design``."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symfric.errors import SceneError
from symfric.model.scene import Scene
from symfric.model.symbols import nearest
from symfric.motions import record_files
from symfric.motions.motion import Motion
from symfric.motions.synthetic import sine_burst, synthetic
from symfric.scenefile import questions
from symfric.scenefile.expressions import shorten
from symfric.scenefile.fields import Section
from symfric.scenefile.friction import call, check_arguments, exact

if TYPE_CHECKING:
    from symfric.design.result import Design

MODELS = {"positioning": "drive_slide", "contact_damper": "contact_damper", "isolator": "rolling_isolator"}
MAX_SAMPLES, MAX_ITERATIONS = 1_000_000, 1000  # limits of a motion made from a table
OF_PARAMETERS = ("damper", "contact_damper", "isolator")  # designs whose parameters are values of the scene

_MADE: dict[str, Callable[..., Motion]] = {"synthetic": synthetic, "sine_burst": sine_burst}


@dataclass(frozen=True)
class DesignPlan:
    """A design to compute: one table of ``[design]``.

    Attributes
    ----------
    kind : str
        Name of the function in `symfric.design`.
    arguments : mapping of str
        Its arguments, as far as the table gives them.
    """

    kind: str
    arguments: Mapping[str, Any]

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of the design parameters."""
        fixed = {"quench": ("a", "Omega"), "absorber": ("tuning", "damping")}
        given = self.arguments
        return fixed.get(self.kind) or ((given["parameter"],) if "parameter" in given else tuple(given["bounds"]))

    def __call__(self, scene: Scene) -> "Design":
        """Compute the design; raises the exceptions of the design function."""
        from symfric import design  # slow to import, and most files have no design

        function = getattr(design, self.kind)
        return function(**self.arguments) if self.kind == "absorber" else function(scene, **self.arguments)


def read_motion(motion: questions.MotionTable, place: str, folder: Path | None) -> Motion:
    """Return the ground motion of a table.

    Parameters
    ----------
    place : str
        Place of the table, for messages.
    folder : Path or None
        Folder of the scene file, relative to which records are found; None if there is no file.
    """
    given = {k: exact(v) if isinstance(v, float) else v for k, v in motion.__pydantic_extra__.items()}
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
    try:
        return call(place, function, given)
    except SceneError as error:
        raise SceneError(f"{place}: {str(error).removeprefix(f'{place}: ')}") from None


def _check_size(place: str, given: Mapping) -> None:
    """Raise on a motion with too many samples or iterations; `synthetic` limits its samples itself."""
    numbers = {k: v for k, v in given.items() if isinstance(v, float | int) and v > 0}
    each = 1 / numbers["dt"] / numbers.get("frequency", 1.0) if "dt" in numbers else 200
    if numbers.get("cycles", 10) * each > MAX_SAMPLES or numbers.get("iterations", 0) > MAX_ITERATIONS:
        raise SceneError(f"{place} has more than {MAX_SAMPLES} samples or {MAX_ITERATIONS} iterations; take fewer")


def read_designs(asked: questions.Designs, scene: Scene, model: str | None, folder: Path | None) -> tuple:
    """Return the designs of a file, with ranges and names checked against the scene.

    Parameters
    ----------
    asked : Designs
    scene : Scene
    model : str or None
        Name of the ready scene.
    folder : Path or None
        Folder relative to which records are found.

    Returns
    -------
    tuple of DesignPlan
    """
    return tuple(
        DesignPlan(kind, _arguments(kind, section, scene, model, folder))
        for kind, section in asked
        if section is not None
    )


def _arguments(kind: str, section: Section, scene: Scene, model: str | None, folder: Path | None) -> dict:
    place = f"design.{kind}"
    if MODELS.get(kind, model) != model:
        raise SceneError(
            f"[{place}] takes the ready scene {MODELS[kind]}; this file has {model or 'equations of its own'}"
        )
    given = {key: _plain(value) for key, value in section if value is not None}
    for key, value in given.items():
        _check_ranges(f"{place}.{key}", value, negative=kind == "positioning" and key == "bounds")
    names = [s.name for s in scene.parameters]
    if kind in OF_PARAMETERS:
        for key in {"parameter", "speed", "bounds"} & set(given):
            for name in [given[key]] if isinstance(given[key], str) else given[key]:
                if isinstance(name, str) and name not in names:
                    raise SceneError(f"{place}.{key}: no value {shorten(name, 40)!r}{nearest(name, names)}")
    if kind == "quench":
        _check_quench(given, names)
    if kind == "absorber" and "mass_ratio" not in given:
        if model != "absorber":
            raise SceneError(f"{place}.mass_ratio is missing; add it")
        given["mass_ratio"] = scene.values[scene.parameter("mass_ratio")]
    if isinstance(section, questions.Isolator):
        numbered = enumerate(section.motions)
        given["motions"] = [read_motion(m, f"{place}.motions[{i}]", folder) for i, m in numbered]
    return given


def _plain(value):
    """Convert TOML data to arguments: tables to dicts, lists of numbers to tuples."""
    if isinstance(value, Section):
        return {k: v for k, v in value if v is not None}
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    return tuple(value) if isinstance(value, list) else value


def _check_ranges(place: str, value, negative: bool) -> None:
    if isinstance(value, dict):
        for key, inner in value.items():
            _check_ranges(f"{place}.{shorten(key, 40)}", inner, negative)
    elif isinstance(value, tuple) and all(isinstance(e, float) for e in value):
        low, high = value
        if not low <= high or (low < 0 and not negative):
            words = "" if negative else ", not negative"
            raise SceneError(f"{place} is [{low:g}, {high:g}]; write [smallest, largest]{words}")


def _check_quench(given: Mapping, names: list[str]) -> None:
    if given["margin"] < 0:
        raise SceneError(f"design.quench.margin is {given['margin']:g}; it must not be negative")
    for key in ("a", "Omega"):
        if key not in names:
            raise SceneError(
                f"design.quench: the scene has no value {key}; it needs an excitation a*Omega**2*sin(Omega*t)"
            )
