"""The command ``identify``."""

import json
from pathlib import Path

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say, writable_folder, write_results

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("file", type=FILE)
@click.option("-o", "--out", type=FILE, help="Folder for the results; FILE's name with -identify unless given.")
@common_options
def identify(file: Path, out: Path | None, as_json: bool, quiet: bool) -> None:
    """Fit values of a scene file to the record in [identify] and write one HTML page.

    [identify] names a CSV file (the first column is time) and, in [identify.unknowns], the unknowns with their bounds:
    values of the scene, states for their starts, column.offset and column.scale of a sensor. Writes identify.html and
    identify.json: values with standard errors and intervals, residuals, profiles.

    \b
    Example: symfric identify examples/rig_record.toml -o out/
    """
    from symfric.report.identification.result import asked_fit, identification, to_dict
    from symfric.scenefile import read_scene_file

    scene_file = read_scene_file(file)
    asked_fit(scene_file)  # before a folder is made
    folder = writable_folder(Path(f"{file.stem}-identify") if out is None else out)
    with progress_on_stderr(quiet) as progress:
        from symfric.report.identification.page import page, summary

        result = identification(scene_file, progress)
        progress("pictures", 0.95)
        data = to_dict(result)
        files = {"identify.html": page(result), "identify.json": json.dumps(data, indent=2, allow_nan=False)}
        write_results({folder / name: text for name, text in files.items()})
    if as_json:
        print_json(data)
    elif not quiet:
        say(scene_file.title or str(file))
        for line in summary(result):
            say(f"  {line}")
        say(f"{folder / 'identify.html'} ({result.seconds:.1f} s)")
