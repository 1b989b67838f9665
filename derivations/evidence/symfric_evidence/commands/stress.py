"""The command ``symfric stress``."""

from typing import TYPE_CHECKING

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say

if TYPE_CHECKING:
    from symfric_evidence.stress import StressResult


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
    if nothing independent confirms it.

    \b
    Example: symfric stress --scenes 200 --family pulse-in-time --seed 3
    """
    from symfric_evidence.stress import FAMILIES, StressResult, examine, scene_named
    from symfric_evidence.stress import stress as run

    if listed:
        say("\n".join(FAMILIES))
        return
    if name is not None:
        family, structure, number = scene_named(name)
        result = StressResult(tuple(examine(family, structure, [number])))
    else:
        with progress_on_stderr(quiet) as progress:
            result = run(
                scenes,
                seed=seed,
                families=families,
                jobs=jobs,
                progress=lambda n: progress(f"{n} scenes", n / scenes),
            )
    if as_json:
        print_json(result.to_dict())
    elif not quiet:
        _print_table(result)
    for case in result.unexplained:
        say(
            f"{case.verdict}: {case.name} ({case.route}): {case.second:.1e} from the reference, "
            f"{case.finer:.1e} from a finer tolerance, energy {case.energy:.1e}{case.note and '; ' + case.note}; "
            f"again with --scene {case.name}",
            err=True,
        )
    if result.unexplained:
        raise click.exceptions.Exit(1)


def _print_table(result: "StressResult") -> None:
    """Print the number of scenes for each family and verdict."""
    width = max(len(name) for name in result.by_family)
    for name, counts in [*result.by_family.items(), ("all", result.counts)]:
        shown = ", ".join(f"{n} {verdict}" for verdict, n in counts.items() if n)
        say(f"{name:{width}}  {shown}")
