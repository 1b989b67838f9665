"""The command ``symfric stress``."""

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say


@click.command()
@click.option("--scenes", default=10_000, show_default=True, type=click.IntRange(1), help="Number of random scenes.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Of the first structure.")
@click.option("--jobs", "-j", type=int, default=-1, help="Processes; as many as there are processors unless given.")
@click.option("--scene", "name", metavar="SEED/NUMBER", help="Only this one, by the name that a run gave it.")
@common_options
def stress(scenes: int, seed: int, jobs: int, name: str | None, as_json: bool, quiet: bool):
    """Random scenes by the chosen route, each compared with other routes and its balance of energy.

    Exit status 1 if a run is wrong by more than 1000 tolerances and does not say so.

    \b
    Example: symfric stress --scenes 200 --seed 3
    """
    from symfric.bench.stress import StressResult, examine, scene_named
    from symfric.bench.stress import stress as run

    if name is not None:
        structure, number = scene_named(name)
        result = StressResult(tuple(examine(structure, [number])))
    else:
        with progress_on_stderr(quiet) as progress:
            result = run(scenes, seed=seed, jobs=jobs, progress=lambda n: progress(f"{n} scenes", n / scenes))
    if as_json:
        print_json(result.to_dict())
    elif not quiet:
        for verdict, count in result.counts.items():
            say(f"{count:6d} {verdict}")
    for found in result.failures:
        say(
            f"silent failure: {found.name} ({found.kind}, {found.route}): {found.finer:.1e} from a finer tolerance, "
            f"{found.second:.1e} from the second route, energy {found.energy:.1e}; again with --scene {found.name}",
            err=True,
        )
    if result.failures:
        raise click.exceptions.Exit(1)
