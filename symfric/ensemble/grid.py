"""The grid of a sweep: labelled axes, the scene and the parameter values of each case, and a hash of all."""

import hashlib
import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from symfric.codegen import loop_loader
from symfric.ensemble.sampling import CaseTable, row_of
from symfric.ensemble.statistics import CASE, REPEAT
from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.outputs import End, Output, Samples
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of
from symfric.model.system import Signal
from symfric.motions.motion import Motion
from symfric.solve.routes import Settings

SCENES = "scene"  # name of the axis of several scenes


@dataclass(frozen=True, eq=False)
class Grid:
    """The cases of a sweep: all combinations of the axes' entries, in C order.

    Attributes
    ----------
    axes : dict of str to ndarray
        Name of each axis and its labels: numbers of a parameter, names of motions or scenes.
    scenes : tuple of Scene
        One for each combination of the entries that are not numbers (inputs, scenes).
    scene_of : ndarray of int, shape (n,)
        Index in `scenes` of each case.
    names : tuple of str
        The parameters that vary.
    width : dict of str to int
        Outputs and how many numbers each has: 1, or n_x for `End`.
    tables : dict of str to CaseTable
        Axes that vary several parameters together.
    """

    axes: dict[str, np.ndarray]
    scenes: tuple[Scene, ...]
    scene_of: np.ndarray
    names: tuple[str, ...]
    width: dict[str, int]
    tables: dict[str, CaseTable] = field(default_factory=dict, kw_only=True)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of entries of every axis."""
        return tuple(a.size for a in self.axes.values())

    @cached_property
    def size(self) -> int:
        """Number of cases."""
        return int(np.prod(self.shape))

    def numbers(self, cases: np.ndarray) -> np.ndarray:
        """Return the values of the varied parameters of some cases, shape (n, number of parameters)."""
        at = dict(zip(self.axes, np.unravel_index(cases, self.shape), strict=True))
        columns = {n: self.axes[n][at[n]] for n in self.names if n in self.axes}
        for axis, table in self.tables.items():
            columns |= {n: column[at[axis]] for n, column in table.columns.items()}
        return np.stack([columns[n] for n in self.names], axis=-1) if self.names else np.zeros((len(cases), 0))


@alone(SYMBOLIC)
def make_grid(scene: Scene | Mapping[str, Scene], axes: Mapping[Key, Any] | CaseTable) -> Grid:
    """Check the arguments of a sweep and return its grid; see `symfric.ensemble.sweep.sweep`."""
    scenes = _scenes(scene)
    first = next(iter(scenes.values()))
    axes = {CASE: axes} if isinstance(axes, CaseTable) else axes
    if not isinstance(axes, Mapping):
        raise SceneError(f"the grid is {axes!r}; give a mapping of parameters to sequences of values, or sf.CaseTable")
    given = {name_of(k): v for k, v in axes.items()}
    if len(given) < len(axes):
        raise SceneError("a parameter is given twice in the grid, as a symbol and by name")
    if not given and len(scenes) == 1:
        raise SceneError("the grid has no axis; give at least one parameter and its values")
    swapped = {s.name for s in first.inputs} & set(given)
    tables = {n: v for n, v in given.items() if isinstance(v, CaseTable)}
    numbers = _numbers(given, swapped, tables)
    names = tuple(numbers)
    signals = {n: _signals(given[n], n) for n in swapped}
    labels = {
        n: np.arange(len(tables[n])) if n in tables else numbers[n] if n in numbers else np.array(list(signals[n]))
        for n in given
    }
    if not isinstance(scene, Scene):
        if SCENES in labels:
            raise SceneError(f"an axis is called {SCENES!r}, like that of the scenes; rename the parameter")
        labels = {SCENES: np.array(list(scenes)), **labels}
    scenes = {label: _prepared(s, numbers) for label, s in scenes.items()}
    width = widths(scenes)
    clash = next((n for n in (*width, "status", "state") if n in {*labels, *names}), None) or (
        "status" if "status" in width else ""
    )
    if clash:
        raise SceneError(f"{clash!r} is the name of an axis or of the status, and of an output too; rename the output")
    order = [n for n in given if n in swapped]
    variants = [
        _with_inputs(base, dict(zip(order, swaps, strict=True)))
        for base in scenes.values()
        for swaps in itertools.product(*(signals[n].values() for n in order))
    ]
    return Grid(labels, tuple(variants), _scene_of(labels, (*names, *tables)), names, width, tables=tables)


def _numbers(given: Mapping[str, Any], swapped: set[str], tables: Mapping[str, CaseTable]) -> dict[str, np.ndarray]:
    """Return the rows of all parameters, those in tables too."""
    numbers: dict[str, np.ndarray] = {}
    for name, values in given.items():
        if name in swapped:
            continue
        rows = dict(tables[name].columns) if name in tables else {name: row_of(values, name)}
        for n, row in rows.items():
            if n in numbers or (name in tables and n in given):
                raise SceneError(f"{n} varies on two axes of the sweep; keep one")
            numbers[n] = row
    return numbers


def columns_of(table: CaseTable, axis: str) -> dict[str, np.ndarray]:
    """Return what a table adds to the coordinates of its axis: its columns, and the draws that its rows belong to."""
    repeat = REPEAT if axis == CASE else f"{REPEAT} of {axis}"
    return {**table.columns, **({repeat: table.repeat} if np.ptp(table.repeat) else {})}


def _scenes(scene: Any) -> dict[str, Scene]:
    scenes = {"": scene} if isinstance(scene, Scene) else scene
    if not isinstance(scenes, Mapping) or not scenes or not all(isinstance(s, Scene) for s in scenes.values()):
        raise SceneError(f"{scene!r} is neither a sf.Scene nor a mapping of labels to scenes")
    return {str(k): s for k, s in scenes.items()}


def _signals(values: Any, name: str) -> dict[str, Signal]:
    """Return the signals of an input by their labels."""
    if isinstance(values, Mapping):
        pairs = [(str(k), v) for k, v in values.items()]
    elif isinstance(values, Motion | Signal):
        raise SceneError(f"the input {name} is given one motion; give a list of them, or put it into Scene.inputs")
    else:
        pairs = [(v.name if isinstance(v, Motion) else f"{name} {k}", v) for k, v in enumerate(values)]
    signals: dict[str, Signal] = {}
    for label, value in pairs:
        if not isinstance(value, Motion | Signal):
            raise SceneError(f"the input {name} has {value!r}; give motions or sf.Signal")
        count = sum(k == label or k.startswith(f"{label} (") for k in signals)
        signals[f"{label} ({count + 1})" if count else label] = value.signal() if isinstance(value, Motion) else value
    if not signals:
        raise SceneError(f"the input {name} has no motions; give at least one")
    return signals


def _prepared(scene: Scene, numbers: Mapping[str, np.ndarray]) -> Scene:
    """Return a scene with its scalar outputs only and a number for every value."""
    outputs = {n: o for n, o in scene.outputs.items() if o.size(len(scene.system.states))}
    if not outputs:
        raise SceneError("the scene has no scalar output; give it some: scene.wanting({'x_max': sf.Max(x)})")
    open_values = {n: v[0] for n, v in numbers.items() if scene.values[scene.parameter(n)] is None}
    scene = scene.where(open_values) if open_values else scene
    scene.numbers()
    scene = scene if len(outputs) == len(scene.outputs) else scene.wanting(outputs)
    for n in numbers:
        scene.parameter(n)
    return scene


def widths(scenes: Mapping[str, Scene]) -> dict[str, int]:
    """Return how many numbers each output has; all scenes must have the same ones."""
    layouts = []
    for scene in scenes.values():
        n_x = len(scene.system.states)
        sizes = {n: o.size(n_x) or 0 for n, o in scene.outputs.items()}
        layouts.append((sizes, dimensions(scene)))
    if any(f != layouts[0] for f in layouts):
        raise SceneError("the scenes have different outputs; give them the same ones with scene.wanting")
    return layouts[0][0]


def dimensions(scene: Scene) -> dict[str, tuple[str, list[Any]]]:
    """Return the name and the labels of the extra dimension of each output with several numbers."""
    extra: dict[str, tuple[str, list[Any]]] = {}
    for name, output in scene.outputs.items():
        if isinstance(output, End):
            extra[name] = "state", [s.name for s in scene.system.states]
        elif isinstance(output, Samples):
            extra[name] = f"time_of_{name}", list(output.times)
    return extra


def _with_inputs(scene: Scene, inputs: Mapping[str, Signal]) -> Scene:
    present = {s.name: v for s, v in scene.inputs.items()}
    missing = next((n for n in inputs if n not in present), None)
    if missing:
        raise SceneError(f"a scene has no input {missing}; every scene of a sweep needs it")
    return replace(scene, inputs={**present, **inputs}) if inputs else scene


def _scene_of(labels: Mapping[str, np.ndarray], names: tuple[str, ...]) -> np.ndarray:
    """Return the index of the scene of every case."""
    fixed = [n not in names for n in labels]
    shape = [a.size if f else 1 for a, f in zip(labels.values(), fixed, strict=True)]
    scene = np.arange(int(np.prod(shape))).reshape(shape)
    return np.broadcast_to(scene, [a.size for a in labels.values()]).ravel()


@alone(SYMBOLIC)
def fingerprint(scene: Scene) -> str:
    """Return a hash of everything in a scene that affects its runs, equal in every process."""
    system = scene.system
    parts = [sp.srepr(e) for e in (*system.states, *system.expressions)]
    for c in scene.contacts:
        parts += [c.name, *map(sp.srepr, c.expressions)]
    parts += sorted(f"{s.name} = {v.hex()}" for s, v in scene.parameter_values().items())
    parts += [f"{s.name} starts at {_plain(v)}" for s, v in scene.initial.items()]
    parts += [f"{n} is {_output(o)}" for n, o in scene.outputs.items()]
    parts += [f"{p!r}" for p in scene.clocks]
    parts.append(scene.horizon.hex())
    digest = hashlib.sha256("\n".join(parts).encode())
    if system.linear is not None:
        for array in system.linear.arrays:
            digest.update(str(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    for symbol, signal in sorted(scene.inputs.items(), key=lambda pair: pair[0].name):
        digest.update(f"{symbol.name} {signal.dt.hex()} {signal.t0.hex()}{' held' * signal.hold}\n".encode())
        digest.update(signal.samples.tobytes())
    return digest.hexdigest()


def _plain(value: Any) -> str:
    return sp.srepr(value) if isinstance(value, sp.Basic) else float(value).hex()


def _output(output: Output) -> str:
    entries = (getattr(output, f.name) for f in fields(output))
    return f"{type(output).__name__} {[sp.srepr(e) if isinstance(e, sp.Basic) else repr(e) for e in entries]}"


def sweep_key(grid: Grid, tolerance: float, route: str | Settings | None) -> str:
    """Return a hash of a sweep: its scenes, axes, tolerance and route."""
    digest = hashlib.sha256(f"{float(tolerance).hex()} {route!r} {list(grid.width.items())}".encode())
    for name, labels in grid.axes.items():
        digest.update(f"\n{name} {labels.dtype.kind} {labels.size}\n".encode())
        digest.update("\n".join(labels.tolist()).encode() if labels.dtype.kind == "U" else labels.tobytes())
    for name, table in grid.tables.items():
        for column, values in table.columns.items():
            digest.update(f"\n{name} {column}\n".encode() + values.tobytes())
    for scene in grid.scenes:
        digest.update(fingerprint(scene).encode())
    return digest.hexdigest()


def code_key() -> str:
    """Return a key of the solvers' source code, whose changes may change the last bits of results."""
    return loop_loader.sources_key("symfric.solve.routes", (*loop_loader.FOLLOWED, "symfric.lower"))[:16]
