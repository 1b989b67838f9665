"""The command ``symfric bench``."""

import json
from pathlib import Path

import click

from symfric.bench.problems import problems


@click.command()
@click.option("--peers", "with_peers", is_flag=True, help="Run the other packages' solvers too, where installed.")
@click.option("--problem", "names", multiple=True, metavar="NAME", help="Only this problem; may be repeated.")
@click.option("--rounds", default=7, show_default=True, type=click.IntRange(1, 1000), help="Samples of each solver.")
@click.option("-o", "folder", type=click.Path(file_okay=False, path_type=Path), help="Write bench.json and bench.png.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
@click.option("--quiet", is_flag=True, help="No progress.")
def bench(with_peers, names, rounds, folder, as_json, quiet):
    """Run time against error on problems with known answers."""
    from rich.console import Console

    from symfric.bench.measure import measure
    from symfric.bench.picture import table

    known = problems()
    unknown = next((name for name in names if name not in known), None)
    if unknown is not None:
        raise click.BadParameter(f"no problem {unknown!r}; there are {', '.join(known)}", param_hint="--problem")
    errors = Console(stderr=True)
    tell = (lambda _: None) if quiet else (lambda line: errors.print(line, style="dim"))
    benchmark = measure(names, with_peers=with_peers, rounds=rounds, progress=tell)
    text = json.dumps(benchmark.to_dict(), indent=2)
    if folder is not None:
        _write(benchmark, text, folder)
    if as_json:
        click.echo(text)
        return
    Console().print(table(benchmark))
    for curve in (c for c in benchmark.curves if c.failure):
        click.echo(f"{curve.problem}, {curve.solver}: {curve.failure}")
    for name, need in benchmark.absent.items():
        click.echo(f"{name}: left out, needs {need}")
    if not quiet:
        for name, lines in benchmark.workarounds.items():
            click.echo(f"{name}: " + "; ".join(lines))


def _write(benchmark, text: str, folder: Path) -> None:
    from matplotlib.figure import Figure

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bench.json").write_text(text)
    names = list(dict.fromkeys(c.problem for c in benchmark.curves if c.points))
    if names:
        figure = Figure(figsize=(4.2 * len(names), 4.2), layout="constrained")
        benchmark.plot(figure.subplots(1, len(names), squeeze=False).ravel())
        figure.savefig(folder / "bench.png", dpi=120)
