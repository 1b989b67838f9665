"""Read scene files: path or text to a `SceneFile`; every error is one line that names file, place and cure."""

import re
import tomllib
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from symfric.errors import SceneError
from symfric.files import read_regular
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import path_of
from symfric.model.belts import belt_speeds
from symfric.model.scene import Scene
from symfric.model.symbols import nearest, shorten
from symfric.scenefile.build import build_scene, observables
from symfric.scenefile.designs import read_designs
from symfric.scenefile.identification import IdentificationPlan, read_identification
from symfric.scenefile.laws import LawSpec
from symfric.scenefile.motions import read_motion
from symfric.scenefile.schema import Sweep, read_document
from symfric.scenefile.structure import StructurePlan, plan_of
from symfric.scenefile.units import Units, units_in_file
from symfric.spelling import spelt

if TYPE_CHECKING:
    from symfric.design.plan import DesignPlan

MAX_BYTES = 1_000_000
MAX_NESTING = 40  # nested brackets in TOML, whose reader recurses
MAX_DOTS = 20  # most parts of a dotted key
MAX_MESSAGE = 400
MAX_CASES = 1_000_000  # most cases of a sweep
_FILES: "WeakKeyDictionary[Scene, SceneFile]" = WeakKeyDictionary()  # of scenes that were read
TOKEN = re.compile(r"""[\w-]+|"[^"\n]*"|'[^'\n]*'|\S""")


@dataclass(frozen=True)
class SweepPlan:
    """A sweep to compute: the contents of ``[sweep]``.

    Attributes
    ----------
    parameter : str
        Name of the value that varies.
    start, stop : float
    number : int
        Equally spaced values, both ends included.
    coordinate : str
        State whose vibration is measured.
    settle, window : float or None
        Settling time and measuring window; None to choose them from the scene.
    branch : (float, float) or None
        Range over which limit cycles are followed.
    """

    parameter: str
    start: float
    stop: float
    number: int
    coordinate: str
    settle: float | None = None
    window: float | None = None
    branch: tuple[float, float] | None = None


@dataclass(frozen=True)
class SceneFile:
    """The contents of a scene file: scene, labels, sweep and designs.

    Attributes
    ----------
    path, title, description : str
    scene : Scene
    model : str or None
        Name of the ready scene; None for own equations.
    laws : tuple of LawSpec
        As written; empty where a ready scene keeps its default law.
    sweep : SweepPlan or None
    grid : dict[str, Any] of str to tuple of float
        Values of each parameter that ``symfric sweep`` varies; empty without ``[sweep]``.
    designs : tuple of DesignPlan
        One for each table of ``[design]``.
    identification : IdentificationPlan or None
        What ``[identify]`` says.
    structure : StructurePlan or None
        Of a scene whose equations are matrices.
    """

    path: str
    title: str
    description: str
    scene: Scene
    model: str | None
    laws: tuple[LawSpec, ...]
    sweep: SweepPlan | None
    grid: Mapping[str, tuple[float, ...]]
    designs: "tuple[DesignPlan, ...]"
    identification: IdentificationPlan | None = None
    structure: StructurePlan | None = None

    @property
    def coordinate(self) -> str:
        """The coordinate that is measured unless the sweep names one: the first, or the first point of a structure."""
        points = () if self.structure is None else tuple(self.structure.points)
        return points[0] if points else self.scene.system.q[0].name

    @property
    def units(self) -> Units:
        """Unit of each state and value by name, "t" for time; empty for a scene without units."""
        return self.scene.units

    def plan(self, kind: str) -> "DesignPlan | None":
        """Return the design of a kind, None if the file has none."""
        return next((p for p in self.designs if p.kind == kind), None)


def read_scene_file(path: str | Path) -> SceneFile:
    """Read a scene file.

    Raises
    ------
    SceneError
        If it cannot be read, is not TOML, or does not describe a scene; one line, naming file, place and cure.
    """
    place = path_of(path)
    return _named(str(path), lambda: _text_of(place), place.parent)


@spelt
def read(path: str | Path) -> Scene:
    """Read the scene of a scene file, to go on with it in Python.

    Parameters
    ----------
    path : path
        A TOML file, see the keys of a scene file.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If the file cannot be read, is not TOML, or does not describe a scene; one line, naming file, place and cure.

    Examples
    --------
    >>> import symfric as sf
    >>> from symfric.scenefile.starters import starter
    >>> from pathlib import Path
    >>> _ = Path("belt.toml").write_text(starter("mass_on_belt"))
    >>> sf.read("belt.toml")
    Scene(1 coordinate, contacts: belt; v_b=0.2, beta=0.05, gamma2=1, a=0, Omega=0; horizon 100)
    """
    file = read_scene_file(path)
    _FILES[file.scene] = file
    return file.scene


def file_of(scene: Scene) -> SceneFile:
    """Return the scene file that `read` read a scene from; for another scene one with nothing else in it."""
    if scene in _FILES:
        return _FILES[scene]
    plan = None if scene.system.linear is None else plan_of(scene)
    return SceneFile("Python", "", "", scene, None, (), None, {}, (), structure=plan)


def read_scene_text(text: str, name: str = "scene file", folder: Path | None = None) -> SceneFile:
    """Read a scene file given as text; `name` is used in messages. It refers to records in `folder` only."""
    return _named(name, lambda: text, folder)


def _named(name: str, text_of: Callable[[], str], folder: Path | None) -> SceneFile:
    """Read a scene file, with its name in front of every error message."""
    shown = shorten(name, 120)
    try:
        return _scene_file(name, text_of(), folder)
    except (SceneError, RecursionError) as error:
        message = str(error) if isinstance(error, SceneError) else "is nested too deeply; write it simpler"
        for python, toml in (("Scene.values", "[values]"), ("Scene.initial", "scene.initial"), ("sf.TIME", "t")):
            message = message.replace(python, toml)
        raise SceneError(shorten(f"{shown}: {message}", MAX_MESSAGE)) from None


def _text_of(path: Path) -> str:
    """Return the text of a file, of limited size."""
    try:
        if path.is_dir():
            raise SceneError("is a folder; name a scene file in it")
        if not path.exists():
            beside = sorted(p.name for p in path.parent.glob("*.toml"))[:50] if path.parent.is_dir() else []
            hint = nearest(path.name, beside) if beside else ""
            raise SceneError("no such file" + (hint if "did you" in hint else "; check the path"))
        if not path.is_file():
            raise SceneError("is not a regular file; name a scene file")
        data = read_regular(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"cannot be read ({reason}); check the path and its permissions") from None
    if len(data) > MAX_BYTES:
        raise SceneError(f"is larger than {MAX_BYTES // 1000} kB; the limit for a scene file")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise SceneError(
            f"is not text (byte {data[error.start]:#04x} in line {line}); save the scene file as UTF-8"
        ) from None


def _toml(text: str) -> dict[str, Any]:
    """Return the parsed TOML."""
    if not text.strip():
        raise SceneError("is empty; a scene file has at least a section [scene]")
    _check_nesting(text)
    try:
        return tomllib.loads(text.replace("\r\n", "\n"))
    except tomllib.TOMLDecodeError as error:
        raise SceneError(
            f"is not TOML: {_lower(str(error))}; mind quotes around text and one key = value a line"
        ) from None
    except (RecursionError, MemoryError):
        raise SceneError("is nested too deeply; a scene file has sections, keys and lists of lists") from None
    except (ValueError, OverflowError) as error:
        raise SceneError(f"is not TOML: {_lower(str(error))}") from None


def _check_nesting(text: str) -> None:
    """Raise on deep nesting, on which the TOML reader recurses, and on long dotted keys, on which it is slow."""
    for number, line in enumerate(text.splitlines(), 1):
        if line.count("[") > MAX_NESTING and "[" * MAX_NESTING in line.replace(" ", ""):
            raise SceneError(f"more than {MAX_NESTING} nested brackets (at line {number})")
    dots, before = 0, ""
    for match in TOKEN.finditer(text):
        token = match.group()
        if token == "." and before != ".":
            dots += 1
        elif before != ".":
            dots = 0
        if dots > MAX_DOTS:
            number = text.count("\n", 0, match.start()) + 1
            raise SceneError(f"a key of more than {MAX_DOTS} parts (at line {number}); use sections")
        before = token


def _check_letters(value: object, place: str = "") -> None:
    """Raise on control characters in keys and texts, which terminals execute and pages cannot show."""
    if isinstance(value, dict):
        for key, inner in value.items():
            inside = f"{place}.{shorten(key, 40)}" if place else shorten(key, 40)
            _check_letters(key, f"a key of {place}" if place else "a key")
            _check_letters(inner, inside)
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            _check_letters(inner, f"{place}[{k}]")
    elif isinstance(value, str):
        odd = next((c for c in value if unicodedata.category(c) == "Cc" and c not in "\n\r\t"), None)
        if odd:
            raise SceneError(f"{place} holds the control character U+{ord(odd):04X}; remove it")


def _lower(message: str) -> str:
    return message[:1].lower() + message[1:]


@alone(SYMBOLIC)
def _scene_file(name: str, text: str, folder: Path | None) -> SceneFile:
    raw = _toml(text)
    _check_letters(raw)
    document = read_document(raw)
    ground = getattr(document.scene, "motion", None)
    motion = None if ground is None else read_motion(ground, "scene.motion", folder)
    pair = getattr(document.scene, "motions", None) or []
    motions = [read_motion(table, f"scene.motions[{i}]", folder) for i, table in enumerate(pair)]
    built = build_scene(document, motion, folder, motions)
    scene, laws = built.scene, built.laws
    if None in scene.values.values():
        scene.numbers()  # raises, naming the value
    scene = replace(scene, units=units_in_file(scene, document.units, laws))
    points = () if built.structure is None else tuple(built.structure.points)
    plan = None if document.sweep is None else _sweep_plan(document.sweep, scene, points)
    return SceneFile(
        path=name,
        title=document.title,
        description=document.description,
        scene=scene,
        model=getattr(document.scene, "model", None),
        laws=laws,
        sweep=plan,
        grid={} if document.sweep is None else _grid(document.sweep, plan, scene),
        identification=None if document.identify is None else read_identification(document.identify, scene, folder),
        designs=read_designs(document.design, scene, getattr(document.scene, "model", None), folder),
        structure=built.structure,
    )


def _grid(sweep: Sweep, plan: SweepPlan | None, scene: Scene) -> dict[str, tuple[float, ...]]:
    """Return the axes of ``[sweep.grid]``, or the axis of ``[sweep]``."""
    if not sweep.grid:
        return {plan.parameter: tuple(np.linspace(plan.start, plan.stop, plan.number).tolist())} if plan else {}
    names = [s.name for s in scene.parameters]
    cases = 1
    for name, values in sweep.grid.items():
        if name not in names:
            raise SceneError(f"sweep.grid: no value {shorten(name, 40)!r}{nearest(name, names)}")
        cases *= len(values)
    if cases > MAX_CASES:
        raise SceneError(f"sweep.grid has {cases} cases; at most {MAX_CASES} are run, take fewer values")
    return {name: tuple(values) for name, values in sweep.grid.items()}


def _sweep_plan(sweep: Sweep, scene: Scene, points: tuple[str, ...]) -> SweepPlan | None:
    """Return the checked sweep, by default over the belt speed; None if only a grid is given."""
    alone = all(v is None for v in (sweep.parameter, sweep.coordinate, sweep.settle, sweep.window))
    if sweep.from_ is None and sweep.to is None and alone and sweep.grid:
        return None
    if sweep.from_ is None or sweep.to is None:
        raise SceneError(f"sweep.{'from' if sweep.from_ is None else 'to'} is missing; add it")
    parameter, coordinate = sweep.parameter, sweep.coordinate
    if parameter is None:
        speeds = belt_speeds(scene)
        if not speeds:
            raise SceneError("sweep.parameter is missing and no contact has a belt speed; name one of [values]")
        parameter = speeds[0].name
    names = [s.name for s in scene.parameters]
    if parameter not in names:
        raise SceneError(f"sweep.parameter: no value {shorten(parameter, 40)!r}{nearest(parameter, names)}")
    states = list(observables(scene))
    if coordinate is None:
        coordinate = points[0] if points else states[0]
    if coordinate not in states:
        raise SceneError(f"sweep.coordinate: no state {shorten(coordinate, 40)!r}{nearest(coordinate, states)}")
    if sweep.from_ >= sweep.to:
        raise SceneError(f"sweep.from is {sweep.from_:g} and sweep.to is {sweep.to:g}; the first must be smaller")
    for key, value in (("from", sweep.from_), ("to", sweep.to)):
        try:
            scene.where({parameter: value})
        except SceneError as error:
            raise SceneError(f"sweep.{key}: with {parameter} = {value:g}, {error}") from None
    branch = None if sweep.branch is None else (sweep.branch[0], sweep.branch[1])
    if branch is not None and not branch[0] < branch[1]:
        raise SceneError(f"sweep.branch is [{branch[0]:g}, {branch[1]:g}]; write [smallest, largest]")
    return SweepPlan(parameter, sweep.from_, sweep.to, sweep.number, coordinate, sweep.settle, sweep.window, branch)
