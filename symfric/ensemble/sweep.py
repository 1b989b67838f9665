"""Sweeps: runs of a scene over a grid of parameters and inputs, in parallel and stored on disk while they run."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.ensemble.grid import Grid, code_key, columns_of, dimensions, make_grid, sweep_key
from symfric.ensemble.progress import Meter, Progress
from symfric.ensemble.sampling import CaseTable
from symfric.ensemble.scheduler import Results, run_on_executor, run_on_threads
from symfric.ensemble.store import Store
from symfric.ensemble.worker import CODES, NOT_COMPUTED, Task, make_program
from symfric.errors import SceneError
from symfric.long_calls import logged, show_this, until_interrupted
from symfric.model.arguments import is_one_of, path_of
from symfric.model.scene import Scene
from symfric.model.symbols import Key, shortened
from symfric.model.units import attributes_of, output_unit
from symfric.solve.case_values import processors, workers_of
from symfric.solve.program import check_tolerance
from symfric.solve.routes import RouteName, Settings

if TYPE_CHECKING:
    import xarray as xr


@logged
def sweep(
    scene: Scene | Mapping[str, Scene],
    grid: Mapping[Key, Any] | CaseTable,
    *,
    jobs: int = 1,
    executor: Executor | None = None,
    progress: bool | Callable[[Progress], None] = False,
    store: str | Path | None = None,
    tolerance: float = 1e-9,
    route: RouteName | Settings | None = None,
) -> "xr.Dataset":
    """Run a scene for every combination of values, and return its scalar outputs on a labelled grid.

    Parameters
    ----------
    scene : Scene or mapping of str to Scene
        Several scenes with the same outputs make a first axis ``scene``. Trajectories and events are not kept.
    grid : mapping of symbol or name to values, or CaseTable
        For a parameter a row of numbers; for an input a list of motions, or a mapping of labels to signals, which take
        its place one by one; under any other name a `CaseTable`, which varies several parameters together. A table
        alone makes the axis ``case``. Horizon and times in outputs stay those of the scene.
    jobs : int
        Threads, which share one program; -1 for as many as there are processors. With an executor, how many
        chunks it computes at a time, if more than the processors here.
    executor : concurrent.futures.Executor, optional
        In place of threads: a pool of processes, or ``dask.distributed.Client.get_executor()``.
    progress : bool or callable, optional
        A function gets a `Progress`, at most ten times a second. True shows this call even after
        ``sf.show_progress(False)``.
    store : str or Path, optional
        A folder of finished cases. The same sweep over it goes on where it was, whatever ended the first, and ends in
        the same bits. A thread's cases are there when those that it took together are finished (a twentieth of a
        second of work, or one case), an executor's when its chunk comes back (half a second of work).
    tolerance, route
        See `symfric.solve.routes.prepare`.

    Returns
    -------
    xarray.Dataset
        The scalar outputs, NaN where a run failed; `End` has a further dimension ``state``. ``status`` holds codes of
        `Status`, -1 for values that the scene refuses, -2 for an error, -3 for one that
        was not computed, see `symfric.keep_when_interrupted`; its attributes name them. The numbers are those
        of ``prepare(scene).run(values)``, whoever computes them.

    Raises
    ------
    SceneError
        If the scene, the grid or the store is wrong; names the thing and the cure.
    NoRoute
        If no route takes the scene.
    RunFailed
        If the executor loses its workers or the store cannot be written; what is finished is in the store.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x = sp.Symbol("x", real=True)
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0)
    >>> table = sf.sweep(belt.wanting({"x_max": sf.Max(x)}), {"v_b": [0.1, 0.2], "beta": [0.0, 0.05]})
    >>> (table.x_max.sel(beta=0.05).values.round(4)).round(6)
    array([0.4832, 0.5665])
    """
    cases = make_grid(scene, grid)
    tolerance = check_tolerance(tolerance)
    workers = _checked(jobs, executor, progress)
    width = sum(cases.width.values())
    kept = None if store is None else _open_store(path_of(store, "store"), cases, tolerance, route, width)
    if kept is not None and kept.complete:
        return _stored(kept, cases, tolerance)
    results = Results(cases.size, width, kept)
    try:
        with until_interrupted("sweep"):
            if results.left.size:
                _run(cases, results, tolerance, route, workers, executor, progress)
    finally:
        results.close()
    result = _dataset(cases, results.status, results.values, tolerance)
    if kept is not None and results.done == cases.size:
        kept.finish(result)
    return result


def _run(
    cases: Grid,
    results: Results,
    tolerance: float,
    route: RouteName | Settings | None,
    workers: int,
    executor: Executor | None,
    progress: bool | Callable[[Progress], None],
) -> None:
    """Run the remaining cases."""

    def task_of(scene: int) -> Task:
        return Task(cases.scenes[scene], tolerance, route, cases.names, tuple(cases.width.values()))

    first = int(cases.scene_of[results.left[0]])
    program = make_program(task_of(first))  # errors of the scene itself are raised here, once
    if progress is True:
        show_this()
    meter = Meter(progress if callable(progress) else None, results.done, cases.size)
    if executor is None:
        run_on_threads(cases, task_of, results, workers, meter, {first: program})
    else:
        run_on_executor(cases, task_of, results, executor, max(workers, processors()), meter)


def _checked(jobs: int, executor: object, progress: object) -> int:
    """Check the arguments and return the number of threads."""
    workers = workers_of(jobs, "jobs")
    if executor is not None and not isinstance(executor, Executor):
        raise SceneError(
            f"executor is {shortened(executor)}; give a concurrent.futures.Executor, such as Client.get_executor()"
        )
    if not is_one_of(progress, (True, False, None)) and not callable(progress):
        raise SceneError(f"progress is {shortened(progress)}; give True or a function of a Progress")
    return workers


def _open_store(
    store: str | Path, cases: Grid, tolerance: float, route: RouteName | Settings | None, width: int
) -> Store:
    from xarray.backends.netcdf3 import is_valid_nc3_name

    for name in (*cases.width, *cases.axes, *cases.names):
        if not is_valid_nc3_name(name):
            raise SceneError(f"{name!r} cannot be a name in a netCDF file; rename it, or sweep without a store")
    about = {
        "sweep": sweep_key(cases, tolerance, route),
        "code": code_key(),
        "axes": ", ".join(f"{n} ({a.size})" for n, a in cases.axes.items()),
        "cases": cases.size,
        "outputs": list(cases.width),
        "scene": repr(cases.scenes[0]),
    }
    return Store(store, about, width)


def _stored(kept: Store, cases: Grid, tolerance: float) -> "xr.Dataset":
    """Return the finished result of a store in the form of a new result."""
    result = kept.result()
    columns = []
    for name, width in cases.width.items():
        columns.append(np.asarray(result[name].values, dtype=float).reshape(cases.size, width))
    status = np.asarray(result["status"].values, dtype=np.int32).ravel()
    return _dataset(cases, status, np.concatenate(columns, axis=1), tolerance)


def _dataset(cases: Grid, status: np.ndarray, values: np.ndarray, tolerance: float) -> "xr.Dataset":
    """Return the result as a labelled dataset."""
    import xarray as xr

    axes, shape, place = list(cases.axes), cases.shape, 0
    along = {n: (axis, v) for axis, table in cases.tables.items() for n, v in columns_of(table, axis).items()}
    data: dict[str, tuple[Any, ...]] = {}  # dimensions, values and, for the status, the meaning of the codes
    coordinates: dict[str, Any] = {**cases.axes, **along}
    own, units = dimensions(cases.scenes[0]), cases.scenes[0].units
    for name in cases.scenes[0].outputs:
        width = cases.width[name]
        block = values[:, place : place + width]
        place += width
        if name in own:
            dimension, labels = own[name]
            data[name] = ([*axes, dimension], block.reshape(*shape, width).copy())
            coordinates[dimension] = np.array(labels)
        else:
            unit = output_unit(units, cases.scenes[0].outputs[name])
            data[name] = (axes, block[:, 0].reshape(shape).copy(), {"units": unit} if unit else {})
    seen = [c for c in sorted(CODES) if c != NOT_COMPUTED or np.any(status == NOT_COMPUTED)]
    codes = np.array(seen, dtype=np.int32)
    meaning = {"flag_values": codes, "flag_meanings": " ".join(CODES[int(c)] for c in codes)}
    data["status"] = (axes, status.reshape(shape).astype(np.int32), meaning)
    for name in cases.axes:
        if attributes_of(name, units):
            coordinates[name] = (name, coordinates[name], attributes_of(name, units))
    return xr.Dataset(data, coordinates, {"scene": repr(cases.scenes[0]), "tolerance": tolerance})
