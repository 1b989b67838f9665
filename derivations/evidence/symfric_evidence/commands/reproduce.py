"""The command ``reproduce``."""

import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say, writable_folder, write_results
from symfric.errors import SceneError
from symfric.interrupts import STATUS

if TYPE_CHECKING:
    from symfric.motions import Motion
    from symfric_evidence.sources.registry import Entry, Made

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("names", nargs=-1, metavar="[FIGURE]...")
@click.option("-o", "--out", type=FILE, default=Path("reproduction"), show_default=True, help="Folder for the results.")
@click.option("--list", "listing", is_flag=True, help="Print the names, one a line.")
@click.option("--records", type=FILE, help="Folder of AT2 records for the figures that need ground motions.")
@common_options
def reproduce(
    names: tuple[str, ...], out: Path, listing: bool, records: Path | None, as_json: bool, quiet: bool
) -> None:
    """Reproduce figures and tables of the sources; all of them unless some are named.

    Writes figures and tables, and index.html with the claims of the sources and the results.

    \b
    Example: symfric reproduce guida-5 rolling-table-3 --records records/ -o out/
    """
    from symfric_evidence.sources.reproduction import chosen

    entries = chosen(names)
    if listing:
        _list(entries, as_json)
        return
    from symfric.report.study.data import plain
    from symfric_evidence.sources.registry import Inputs

    motions = None if records is None else _read(records)
    folder = writable_folder(out)
    results, pages = {}, {}
    try:
        with progress_on_stderr(quiet) as progress:
            for k, (name, entry) in enumerate(entries.items()):
                begin, share = time.monotonic(), 1 / len(entries)
                progress(name, k * share)
                report = lambda part, name=name, k=k, share=share: progress(name, (k + part) * share)  # noqa: E731
                made = entry.make(Inputs(motions, report))
                files = _write(folder, name, made)
                seconds = time.monotonic() - begin
                pages[name] = entry, made, seconds
                findings = plain([asdict(f) for f in made.findings])
                results[name] = {"files": files, "seconds": round(seconds, 2), "findings": findings, "data": made.data}
                if made.text and not (as_json or quiet):
                    say(made.text, nl=False)
    except KeyboardInterrupt:
        index = _save_index(folder, pages)
        say(f"interrupted; {len(pages)} of {len(entries)} are finished, see {index}", err=True)
        raise click.exceptions.Exit(STATUS) from None
    index = _save_index(folder, pages)
    if as_json:
        print_json(results)
    elif not quiet:
        for name, result in results.items():
            say(f"{name}: {', '.join(result['files'])} ({result['seconds']:.1f} s)")
        say(index)


def _save_index(folder: Path, pages: dict[str, tuple["Entry[Any]", "Made", float]]) -> str:
    from symfric.report.html.versions import versions
    from symfric_evidence.sources.gallery import gallery

    index = folder / "index.html"
    write_results({index: gallery(pages, versions())})
    return str(index)


def _list(entries: dict[str, "Entry[Any]"], as_json: bool) -> None:
    if as_json:
        print_json({name: entry.caption for name, entry in entries.items()})
        return
    for name, entry in entries.items():
        say(f"{name}: {entry.caption}")


def _read(folder: Path) -> list["Motion"]:
    """Read all records of a folder, in the order of their names."""
    from symfric.motions import read_at2

    if not folder.is_dir():
        raise SceneError(f"{folder} is not a folder of records; give one that holds AT2 files")
    files = sorted(f for f in folder.iterdir() if f.suffix.lower() == ".at2")
    if not files:
        raise SceneError(f"{folder} holds no AT2 file")
    return [read_at2(f) for f in files]


def _write(folder: Path, name: str, made: "Made") -> list[str]:
    """Write the figures and tables; return the names of the files."""
    from symfric.report.study.drawing.axes import png

    parts: dict[Path, bytes | str] = {}
    if made.figure is not None:
        parts[folder / f"{name}.png"] = png(made.figure)
    if made.text:
        parts[folder / f"{name}.txt"] = made.text
    if made.data is not None:
        parts[folder / f"{name}.json"] = json.dumps(made.data, indent=2)
    write_results(parts)
    return [str(place) for place in parts]
