"""The command ``sweep``."""

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from symfric.cli.console import (
    Progress,
    common_options,
    print_json,
    progress_on_stderr,
    say,
    writable_folder,
    write_results,
)
from symfric.interrupts import STATUS

if TYPE_CHECKING:
    from xarray import Dataset

    from symfric.scenefile import SceneFile

FILE = click.Path(path_type=Path)
STORE = "store"  # folder of the finished cases, inside the folder of the results
TABLE = "sweep.csv"


@click.command()
@click.argument("file", type=FILE)
@click.option("-o", "--out", type=FILE, help="Folder for the results; FILE's name with -sweep unless given.")
@click.option("--jobs", "-j", type=int, default=-1, help="Threads; as many as there are processors unless given.")
@click.option("--resume", is_flag=True, help="Continue an interrupted sweep, or show a finished one.")
@common_options
def sweep(file: Path, out: Path | None, jobs: int, resume: bool, as_json: bool, quiet: bool) -> None:
    """Run a scene file for every combination of values in [sweep].

    [sweep.grid] gives a list of values or {start, stop, count} for each parameter; without it from, to and number of
    [sweep] are used. Writes the scalar [outputs] and a status of every case to sweep.csv and store/result.nc. An
    interrupted sweep keeps every finished case.

    \b
    Example: symfric sweep examples/belt.toml -o out/ --jobs 2
    """
    from symfric.ensemble import store
    from symfric.ensemble.sweep import sweep as run
    from symfric.scenefile import read_scene_file

    scene_file = read_scene_file(file)
    _check(scene_file, file)
    folder = writable_folder(Path(f"{file.stem}-sweep") if out is None else out)
    place = folder / STORE
    if not resume:
        _make_room(place)
    begin = time.monotonic()
    try:
        with progress_on_stderr(quiet) as progress:
            result = run(scene_file.scene, scene_file.grid, jobs=jobs, store=place, progress=_staged(progress))
    except KeyboardInterrupt:
        kept = store.records_in(place)
        if kept is None:
            raise
        say(
            f"interrupted; {kept} finished cases are kept, go on with: symfric sweep {file} -o {folder} --resume",
            err=True,
        )
        raise click.exceptions.Exit(STATUS) from None
    _write(folder / TABLE, result)
    _report(result, file, folder, time.monotonic() - begin, as_json, quiet)


def _check(scene_file: "SceneFile", file: Path) -> None:
    """Raise unless the file has an axis and a scalar output."""
    from symfric.errors import SceneError

    if not scene_file.grid:
        raise SceneError(f"{file}: there is no [sweep] section; add [sweep.grid] with values, such as v_b = [0.1, 0.2]")
    if not any(o.size(len(scene_file.scene.system.states)) for o in scene_file.scene.outputs.values()):
        state = scene_file.scene.system.states[0]
        raise SceneError(f'{file}: [outputs] has no number to tabulate; add one, such as largest = "max({state})"')


def _make_room(place: Path) -> None:
    """Remove a finished sweep; raise if an unfinished one exists."""
    from symfric.ensemble import store
    from symfric.errors import SceneError

    kept = store.records_in(place)
    if kept:
        raise SceneError(
            f"{place} holds an unfinished sweep with {kept} finished cases; continue it with --resume, remove it, or "
            "name another folder with -o"
        )
    store.clear(place)


def _staged(progress: Progress) -> Callable[[Any], None]:
    """Return a function that reports the sweep's progress, without a terminal at growing intervals."""
    steady, begin, last = sys.stderr.isatty(), time.monotonic(), 0.0

    def report(at: Any) -> None:
        nonlocal last
        spent = time.monotonic() - begin
        if steady or spent - last > max(1.0, 0.1 * spent):
            last = spent
            progress(str(at), at.done / at.total)

    return report


def _rows(result: "Dataset") -> Iterator[Sequence[Any]]:
    """Yield the header of a table and a row for each case: values of the axes, outputs, name of the status."""
    import numpy as np

    axes = list(result["status"].dims)
    names = dict(
        zip(
            result["status"].attrs["flag_values"].tolist(), result["status"].attrs["flag_meanings"].split(), strict=True
        )
    )
    columns: dict[str, list[Any]] = {}
    for name, data in result.data_vars.items():
        if name != "status":
            parts = (
                {str(name): data}
                if "state" not in data.dims
                else {f"{name}_{s}": data.sel(state=s) for s in data.state.values}
            )
            columns |= {k: v.values.ravel().tolist() for k, v in parts.items()}
    grids = np.meshgrid(*(result[a].values for a in axes), indexing="ij")
    values = [g.ravel().tolist() for g in grids] + list(columns.values())
    yield [*axes, *columns, "status"]
    status = [names[s] for s in result["status"].values.ravel().tolist()]
    yield from zip(*values, status, strict=True)


def _write(place: Path, result: "Dataset") -> None:
    import csv
    import io

    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(_rows(result))
    write_results({place: text.getvalue()})


def _report(result: "Dataset", file: Path, folder: Path, seconds: float, as_json: bool, quiet: bool) -> None:
    """Print a summary; exit with status 1 if no case was successful."""
    from collections import Counter

    rows = _rows(result)
    head = next(rows)
    cases = [dict(zip(head, row, strict=True)) for row in rows]
    counts = Counter(c["status"] for c in cases)
    if as_json:
        from symfric.report.study.data import plain

        data = {"file": str(file), "folder": str(folder), "seconds": seconds, "statuses": dict(counts), "cases": cases}
        print_json(plain(data))
    elif not quiet:
        shown = ", ".join(f"{n} {s}" for s, n in counts.most_common())
        say(f"{len(cases)} cases: {shown}")
        for name in head[len(result["status"].dims) : -1]:
            numbers = [c[name] for c in cases if c[name] == c[name]]
            if numbers:
                say(f"  {name}: {min(numbers):.6g} to {max(numbers):.6g}")
        say(f"{folder / TABLE}, {folder / STORE / 'result.nc'} ({seconds:.1f} s)")
    if not counts["OK"]:
        say("Error: no case ran to its end; the statuses say why", err=True)
        raise click.exceptions.Exit(1)
