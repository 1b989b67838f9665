"""The commands ``study``, ``explain`` and ``scenes``."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say, writable_folder, write_results
from symfric.errors import SceneError

if TYPE_CHECKING:
    from symfric.report.study.section import StudyResult

FILE = click.Path(path_type=Path)
LIMIT = "Longest time for the runs of one part, ten times as long for designs and limit cycles."


@click.command()
@click.argument("file", type=FILE)
@click.option("-o", "--out", type=FILE, help="Folder for the results; FILE's name with -study unless given.")
@click.option(
    "--limit",
    default=20.0,
    show_default=True,
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help=LIMIT,
)
@common_options
def study(file: Path, out: Path | None, limit: float, as_json: bool, quiet: bool) -> None:
    """Study a scene file (motion, stability, sweep, designs) and write one HTML page.

    Writes study.html, study.json, motion.csv and, if the file sweeps a value, amplitude.csv; of a structure also
    flutter.csv, shapes.csv and cycles.csv, as far as the file asks for them.

    \b
    Example: symfric study examples/belt.toml -o out/
    """
    from symfric.scenefile import read_scene_file

    if not limit < math.inf:
        raise SceneError(f"--limit is {limit}; give a number of seconds")
    scene_file = read_scene_file(file)
    folder = writable_folder(Path(f"{file.stem}-study") if out is None else out)
    with progress_on_stderr(quiet) as progress:
        from symfric.report.study.study import Study
        from symfric.report.study.study import study as computed

        made = Study(computed(scene_file, progress, limit))
        progress("pictures", 0.97)
        write_results({folder / name: text for name, text in made.files().items()})
    if as_json:
        print_json(made.to_dict())
    elif not quiet:
        _print_summary(made.result, folder)


def _print_summary(result: "StudyResult", folder: Path) -> None:
    from rich.console import Console
    from rich.table import Table

    from symfric.report.html.words import percent
    from symfric.report.study.page import summary

    console = Console(highlight=False)
    console.print(result.file.title or result.file.path, style="bold", markup=False)
    for line in summary(result):
        console.print(f"  {line}", markup=False)
    if result.comparison.value:
        table = Table("quantity", "predicted", "computed", "difference", "formula", box=None, pad_edge=False)
        for r in result.comparison.value:
            table.add_row(r.quantity, f"{r.predicted:.6g}", f"{r.computed:.6g}", percent(r.difference), r.formula)
        console.print(table)
    console.print(f"{folder / 'study.html'} ({result.seconds:.1f} s)", markup=False, soft_wrap=True)


@click.command()
@click.argument("file", type=FILE)
@common_options
def explain(file: Path, as_json: bool, quiet: bool) -> None:
    """Show which solver takes a scene file, why the others decline, and what is not computed.

    \b
    Example: symfric explain examples/belt.toml
    """
    from symfric.scenefile import read_scene_file
    from symfric.solve.routes import explain as explain_scene

    explanation = explain_scene(read_scene_file(file).scene)
    if as_json:
        from symfric.report.study.data import plain

        print_json(plain({"file": str(file), **explanation.to_dict()}))
    else:
        say(str(explanation))


@click.command()
@common_options
def scenes(as_json: bool, quiet: bool) -> None:
    """List the ready scenes with their arguments.

    \b
    Example: symfric scenes --json
    """
    from symfric.scenefile import friction_laws, ready_scenes

    listed = {"scenes": _described(ready_scenes()), "laws": _described(friction_laws())}
    if as_json:
        print_json(listed)
        return
    if quiet:
        say("\n".join(ready_scenes()))
        return
    for kind, entries in listed.items():
        say(f"{kind}:")
        for entry in entries:
            shown = ", ".join(a["name"] + (f"={a['default']}" if "default" in a else "") for a in entry["arguments"])
            say(f"  {entry['name']}({shown})\n      {entry['summary']}")


def _described(functions: Mapping[str, Callable[..., Any]]) -> list[dict[str, Any]]:
    """Return name, arguments and a one-line description of each function."""
    import inspect

    result = []
    for name, function in functions.items():
        given = inspect.signature(function).parameters.values()
        arguments = [
            {"name": p.name} if p.default is p.empty else {"name": p.name, "default": p.default} for p in given
        ]
        result.append({"name": name, "arguments": arguments, "summary": _one_line(function)})
    return result


def _one_line(function: Callable[..., Any]) -> str:
    """Return the formula of a law, or the words before the formula in the first line of a docstring."""
    import inspect

    import sympy as sp

    from symfric.scenefile import friction_laws

    parameters = inspect.signature(function).parameters
    if function in friction_laws().values() and not {"kinetic", "speeds"} & set(parameters):
        try:
            law = function(**{name: sp.Symbol(name) for name in parameters})
        except SceneError:  # a number of elements, or the name of a form, is no symbol
            law = None
        if law is not None and not law.memory:
            return f"mu(v) = {law.kinetic}"
    return (inspect.getdoc(function) or "").split("\n")[0].split(": :math:")[0].rstrip(".").replace("`", "") + "."
