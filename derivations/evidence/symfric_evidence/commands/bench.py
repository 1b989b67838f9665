"""The command ``symfric bench``."""

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from symfric.cli.console import common_options, no_interrupt_lost, print_json, say, writable_folder, write_results
from symfric.errors import SceneError
from symfric.model.symbols import nearest
from symfric_evidence.bench.problems import NAMES

if TYPE_CHECKING:
    from symfric_evidence.bench.result import Benchmark

_WIDE = 150  # characters of the widest table


@click.command()
@click.option("--peers", "with_peers", is_flag=True, help="Run the other packages' solvers too, where installed.")
@click.option("--problem", "names", multiple=True, metavar="NAME", help="Only this problem; may be repeated.")
@click.option("--growth", "with_growth", is_flag=True, help="Measure instead how run time grows with size and outputs.")
@click.option("--published", "with_published", is_flag=True, help="Compare instead with Modelica's published numbers.")
@click.option("--where", "with_where", is_flag=True, help="Tell instead where the CPU time of ten long calls goes.")
@click.option("--quick", is_flag=True, help="Fewer rounds and tolerances: two minutes at most, peers included.")
@click.option("--rounds", default=7, show_default=True, type=click.IntRange(1, 1000), help="Timings; 3 x if short.")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="Folder for bench.json and bench.png.")
@common_options
def bench(
    with_peers: bool,
    names: tuple[str, ...],
    with_growth: bool,
    with_published: bool,
    with_where: bool,
    quick: bool,
    rounds: int,
    out: Path | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Measure run time and error on problems with known solutions.

    \b
    Example: symfric bench --problem P2 --rounds 3 -o out/
    """
    from rich.console import Console

    from symfric_evidence.bench.picture import table
    from symfric_evidence.bench.timing import measure

    unknown = next((name for name in names if name not in NAMES), None)
    if unknown is not None:
        raise SceneError(f"no problem {unknown!r}{nearest(unknown, NAMES)}")
    folder = None if out is None else writable_folder(out)
    errors = Console(stderr=True)
    with no_interrupt_lost() as check:

        def tell(line: str) -> None:
            check()
            if not quiet:
                errors.print(line, style="dim")

        for asked, measured in ((with_growth, _growth), (with_published, _published), (with_where, _where)):
            if asked:
                measured(folder, as_json, tell)
                return
        benchmark = measure(names, with_peers=with_peers, rounds=rounds, quick=quick, progress=tell)
    if folder is not None:
        _write(benchmark, folder)
    if as_json:
        print_json(benchmark.to_dict())
        return
    Console().print(table(benchmark))
    for curve in (c for c in benchmark.curves if c.failure):
        say(f"{curve.problem}, {curve.solver}: {curve.failure}")
    for name, need in benchmark.absent.items():
        say(f"{name}: left out, needs {need}")
    if not quiet:
        for name, lines in benchmark.workarounds.items():
            say(f"{name}: " + "; ".join(lines))


def _published(folder: Path | None, as_json: bool, tell: Callable[[str], None]) -> None:
    from rich.console import Console

    from symfric_evidence.bench.picture import published_table
    from symfric_evidence.bench.published import compared

    tell("friction examples of the Modelica Standard Library")
    found = compared()
    plain = [asdict(row) for row in found]
    if folder is not None:
        write_results({folder / "published.json": json.dumps(plain, indent=2)})
    if as_json:
        print_json({"published": plain})
        return
    Console().print(published_table(found))


def _where(folder: Path | None, as_json: bool, tell: Callable[[str], None]) -> None:
    from rich.console import Console

    from symfric_evidence.bench.picture import where_table
    from symfric_evidence.bench.where import where

    shares = where(progress=tell)
    plain = [share.to_dict() for share in shares]
    if folder is not None:
        write_results({folder / "where.json": json.dumps(plain, indent=2)})
    if as_json:
        print_json({"where": plain})
        return
    console = Console()
    if not console.is_terminal:
        console.width = max(console.width, _WIDE)  # in a file or a pipe no line is too long
    console.print(where_table(shares))


def _growth(folder: Path | None, as_json: bool, tell: Callable[[str], None]) -> None:
    from rich.console import Console

    from symfric_evidence.bench import ensembles, known_times, needs, scaling
    from symfric_evidence.bench.picture import cases_table, costs_table, growth_table, needs_table

    tell("what is wanted")
    measured = needs.needs()
    tell("events at known times, and tables")
    instants, tables = known_times.instant_costs(), known_times.table_costs()
    tell("new processes")
    processes = needs.starts()
    grown = scaling.growth(tell)
    cases = ensembles.case_costs(tell)
    plain = {
        "growth": [g.to_dict() for g in grown],
        "cases": [c.to_dict() for c in cases],
        "wanted": [asdict(n) for n in measured],
        "processes": [asdict(n) for n in processes],
        "known_times": [asdict(n) for n in instants],
        "tables": [asdict(n) for n in tables],
    }
    if folder is not None:
        write_results({folder / "scaling.json": json.dumps(plain, indent=2)})
    if as_json:
        print_json(plain)
        return
    Console().print(needs_table("One motion, P2, with more and more wanted", measured, "ms", 1e3))
    Console().print(costs_table("One motion, P2, with events at known times", instants))
    Console().print(costs_table("First call of a mass on a belt", tables))
    Console().print(needs_table("A new process", processes, "s", 1.0))
    Console().print(cases_table(cases))
    Console().print(growth_table(grown))


def _write(benchmark: "Benchmark", folder: Path) -> None:
    from symfric.report.study.drawing.axes import png
    from symfric_evidence.bench.picture import picture

    files: dict[Path, bytes | str] = {folder / "bench.json": json.dumps(benchmark.to_dict(), indent=2)}
    if any(c.points for c in benchmark.curves):
        files[folder / "bench.png"] = png(picture(benchmark))
    write_results(files)
