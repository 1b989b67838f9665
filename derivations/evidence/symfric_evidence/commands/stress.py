"""The command ``symfric stress``."""

import logging
from typing import TYPE_CHECKING

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say
from symfric.interrupts import STATUS

if TYPE_CHECKING:
    from symfric_evidence.stress import StressResult, Verdict

_log = logging.getLogger("symfric")


@click.command()
@click.option("--scenes", default=10_000, show_default=True, type=click.IntRange(1), help="Number of random scenes.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Seed of the random scenes.")
@click.option("--family", "families", multiple=True, metavar="NAME", help="Only this family; may be repeated.")
@click.option("--list", "listed", is_flag=True, help="Print the families and exit.")
@click.option("--jobs", "-j", type=int, default=-1, help="Processes; as many as there are processors unless given.")
@click.option("--scene", "name", metavar="FAMILY/SEED/NUMBER", help="Only this scene, by the name shown in a run.")
@common_options
def stress(
    scenes: int,
    seed: int,
    families: tuple[str, ...],
    listed: bool,
    jobs: int,
    name: str | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run random scenes by the automatic route and compare each with an independent reference simulator.

    Exit status 1 if a run differs by more than 1000 tolerances without a status or a sensitivity that explains it, or
    if nothing independent confirms it; such a run is told as soon as it is found. An interrupted command counts what is
    compared until then.

    \b
    Example: symfric stress --scenes 200 --family pulse-in-time --seed 3
    """
    from symfric_evidence.stress import FAMILIES, StressResult, examine, scene_named
    from symfric_evidence.stress import stress as run

    if listed:
        say("\n".join(FAMILIES))
        return
    judged: list[Verdict] = []
    wanted, interrupted = scenes if name is None else 1, False
    with progress_on_stderr(quiet) as progress:

        def told(verdicts: "list[Verdict]") -> None:
            judged.extend(verdicts)
            for case in StressResult(tuple(verdicts)).unexplained:
                if quiet:
                    say(_line(case), err=True)
                else:
                    _log.warning(_line(case))  # shown above the bar
            progress(f"{len(judged)} scenes", len(judged) / wanted)

        try:
            if name is None:
                run(scenes, seed=seed, families=families, jobs=jobs, told=told)
            else:
                family, structure, number = scene_named(name)
                told(examine(family, structure, [number]))
        except KeyboardInterrupt:
            interrupted = True
    result = StressResult(tuple(judged))
    if as_json:
        print_json(result.to_dict())
    elif not quiet:
        _print_table(result)
    if interrupted:
        say(f"interrupted; {len(judged)} of {wanted} scenes are compared", err=True)
        raise click.exceptions.Exit(STATUS)
    if result.unexplained:
        raise click.exceptions.Exit(1)


def _line(case: "Verdict") -> str:
    return (
        f"{case.verdict}: {case.name} ({case.route}): {case.second:.1e} from the reference, "
        f"{case.finer:.1e} from a finer tolerance, energy {case.energy:.1e}{case.note and '; ' + case.note}; "
        f"again with --scene {case.name}"
    )


def _print_table(result: "StressResult") -> None:
    """Print the number of scenes for each family and verdict."""
    width = max((len(name) for name in result.by_family), default=0)
    for name, counts in [*result.by_family.items(), ("all", result.counts)]:
        shown = ", ".join(f"{n} {verdict}" for verdict, n in counts.items() if n)
        say(f"{name:{width}}  {shown}")
