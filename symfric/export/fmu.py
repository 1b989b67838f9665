"""A stepper as a unit for co-simulation, FMI 2.0: the C code with the functions of the standard, compiled, packed."""

import hashlib
import io
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import sympy as sp

from symfric.errors import SceneError
from symfric.export.c_code import Exported, c_sources, exported, identifier, source_text, with_name
from symfric.export.stepper import MEANING, Stepper, stepper
from symfric.files import write_whole
from symfric.long_calls import logged
from symfric.model.arguments import path_of
from symfric.model.scene import Scene

_COMPILERS = "cc", "gcc", "clang"
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC")
_PLATFORMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("win", ".dll")}
_OUTPUT = {"causality": "output", "variability": "continuous", "initial": "calculated"}
_MODE = {**_OUTPUT, "variability": "discrete"}
_INPUT = {"causality": "input", "variability": "continuous"}
_PARAMETER = {"causality": "parameter", "variability": "tunable", "initial": "exact"}
_EPOCH = (1980, 1, 1, 0, 0, 0)  # of the files inside, so that the same scene gives the same bytes


@logged
def write_fmu(
    scene: Scene, path: Path | str, step: float, outputs: Mapping[str, sp.Expr] | None = None, events: int = 4
) -> Exported:
    """Write a scene as a functional mock-up unit (FMI 2.0, co-simulation), for Simulink, OpenModelica and others.

    Parameters
    ----------
    scene : Scene
    path : Path or str
        Of the file; ends in ``.fmu``.
    step, outputs, events
        See `stepper`; a communication step is divided into steps of at most this length.

    Returns
    -------
    Exported
        ``compiled`` says whether it holds machine code for this computer. Without a C compiler it holds the sources
        alone, which many importers compile themselves.

    Raises
    ------
    SceneError
        If `stepper` refuses the scene, the path is not that of such a file, or the compiler fails.

    Notes
    -----
    States, outputs and the mode of every contact (an integer: -1, 0, 1) are outputs; states have their start values,
    which can be set before the run. Parameters are tunable, and the scene's sampled inputs are inputs: the records
    themselves are not inside. ``status`` is that of the last step, see `write_c`. Nothing of Python is needed where it
    runs.

    Examples
    --------
    >>> import tempfile, zipfile
    >>> from pathlib import Path
    >>> import symfric as sf
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     unit = sf.export.write_fmu(sf.scenes.mass_on_belt(v_b=0.2), Path(folder) / "belt.fmu", step=1e-3)
    ...     zipfile.ZipFile(unit.files[0]).namelist()[0]
    'modelDescription.xml'
    """
    place = path_of(path)
    if place.suffix != ".fmu":
        raise SceneError(f"{path} is no name for a unit; it ends in .fmu, such as {place.stem or 'scene'}.fmu")
    name = identifier(place.stem, "the file")
    made = stepper(scene, step, outputs, events)
    sources = c_sources(made, name)
    guid = hashlib.sha256("".join([source_text("fmi2.c"), *sources.values()]).encode()).hexdigest()[:32]
    sources[f"{name}_fmi2.c"] = with_name(source_text("fmi2.c"), name).replace("@GUID@", guid)
    packed: dict[str, str | bytes] = {"modelDescription.xml": description(made, name, guid)}
    packed |= {f"sources/{file}": text for file, text in sources.items()}
    compiled = _compiled(sources, name)
    if compiled is not None:
        system, suffix = _PLATFORMS[sys.platform]
        bits = 64 if sys.maxsize > 2**32 else 32
        packed[f"binaries/{system}{bits}/{name}{suffix}"] = compiled
    write_whole(place, _zipped(packed))
    return exported(made, [place], compiled is not None)


def compiler() -> str | None:
    """Return the C compiler of this computer: the one that CC names, or one on the path; None if there is none."""
    named = os.environ.get("CC")
    return shutil.which(named) if named else next(filter(None, map(shutil.which, _COMPILERS)), None)


def build(folder: Path, name: str, files: list[str]) -> Path:
    """Compile C files in a folder to a shared library there, and return its path; raise if the compiler fails."""
    library = folder / f"{name}{_PLATFORMS[sys.platform][1]}"
    command = [str(compiler()), *FLAGS, "-o", library.name, *files, "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        first = next(iter(done.stderr.splitlines()), f"exit status {done.returncode}")
        raise SceneError(f"the C compiler {command[0]} failed: {first}")
    return library


def _compiled(sources: Mapping[str, str], name: str) -> bytes | None:
    if compiler() is None or sys.platform not in _PLATFORMS or platform.machine().lower() not in ("x86_64", "amd64"):
        return None
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        return build(Path(folder), name, [f for f in sources if f.endswith(".c")]).read_bytes()


def _zipped(packed: Mapping[str, str | bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, data in packed.items():
            entry = zipfile.ZipInfo(file, _EPOCH)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, data)
    return buffer.getvalue()


def description(made: Stepper, name: str, guid: str) -> str:
    """Return ``modelDescription.xml``."""
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=name,
        guid=guid,
        description=f"{len(made.states)} states, {len(made.contacts)} contacts with dry friction",
        generationTool="symfric",
        variableNamingConvention="flat",
        numberOfEventIndicators="0",
    )
    unit = SubElement(
        root,
        "CoSimulation",
        modelIdentifier=name,
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="true",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    listed = SubElement(unit, "SourceFiles")
    for file in (f"{name}.c", f"{name}_fmi2.c"):
        SubElement(listed, "File", name=file)
    units = _units(made)
    texts = dict.fromkeys(filter(None, units.values()))
    if texts:
        defined = SubElement(root, "UnitDefinitions")
        for text in texts:
            SubElement(defined, "Unit", name=text)
    categories = SubElement(root, "LogCategories")
    for category in ("logStatusWarning", "logStatusError"):
        SubElement(categories, "Category", name=category)
    ends = {"startTime": "0", "stopTime": repr(made.scene.horizon), "stepSize": repr(made.step)}
    SubElement(root, "DefaultExperiment", ends)
    variables = SubElement(root, "ModelVariables")
    shown = _variables(variables, made, units)
    structure = SubElement(root, "ModelStructure")
    for what, indices in (("Outputs", shown["all"]), ("InitialUnknowns", shown["computed"])):
        place = SubElement(structure, what)
        for k in indices:
            SubElement(place, "Unknown", index=str(k))
        if not indices:
            structure.remove(place)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _units(made: Stepper) -> dict[str, str]:
    """Return the unit of every real variable, "" where there is none."""
    own = made.scene.units
    return {**dict(own), **{name: own.of(e) for name, e in made.outputs.items()}}


def _variables(place: Element, made: Stepper, units: Mapping[str, str]) -> dict[str, list[int]]:
    """Add the variables; return the indices of the outputs, and of those that are computed at the start."""
    reals, places = 0, {"all": [], "computed": []}  # type: tuple[int, dict[str, list[int]]]

    names: set[str] = set()

    def add(
        kind: str, name: str, reference: int, said: str, attributes: dict[str, str], start: float | None = None
    ) -> None:
        if name in names:
            raise SceneError(f"two variables of the unit would be called {name!r}; rename the {said.split()[0]}")
        names.add(name)
        variable = SubElement(place, "ScalarVariable", name=name, valueReference=str(reference), description=said)
        variable.attrib.update(attributes)
        value = SubElement(variable, kind)
        if kind == "Real" and units.get(name):
            value.set("unit", units[name])
        if start is not None:
            value.set("start", repr(float(start)))
        if attributes["causality"] == "output":
            places["all"].append(len(place))
            if attributes["initial"] == "calculated":
                places["computed"].append(len(place))

    for name, value in zip(made.states, made.initial, strict=True):
        add("Real", name, reals, "state", {**_OUTPUT, "initial": "exact"}, value)
        reals += 1
    for name in made.inputs:
        add("Real", name, reals, "input", _INPUT, 0.0)
        reals += 1
    for name in made.outputs:
        add("Real", name, reals, "output", _OUTPUT)
        reals += 1
    for name, value in zip(made.parameters, made.values, strict=True):
        add("Real", name, reals, "parameter", _PARAMETER, value)
        reals += 1
    for k, name in enumerate(made.contacts):
        add("Integer", f"{name}.mode", k, "-1 slips backward, 0 sticks, 1 slips forward", _MODE)
    meanings = "; ".join(f"{k}: {text}" for k, text in MEANING.items())
    add("Integer", "status", len(made.contacts), f"of the last step. {meanings}", _MODE)
    return places
