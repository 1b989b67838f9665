"""The command ``export``."""

import math
from pathlib import Path

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say
from symfric.errors import RunFailed, SceneError

_LARGE = 1e-3  # difference from the event-driven solution above which a shorter step is advised


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--to", "kind", type=click.Choice(["c", "fmu"]), required=True, help="C code, or a unit of FMI 2.0.")
@click.option("--step", type=float, required=True, help="Length of a step, in the scene's unit of time.")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="File to write; FILE's name unless given.")
@common_options
def export(file: Path, kind: str, step: float, out: Path | None, as_json: bool, quiet: bool) -> None:
    """Write a scene as C code or as a unit for co-simulation, in steps of fixed length.

    The steps are compared with the event-driven solution over the horizon of the scene, 50000 steps at most.

    \b
    Example: symfric export examples/belt.toml --to fmu --step 0.01
    """
    from symfric.export import stepper, write_c, write_fmu
    from symfric.scenefile import read_scene_file

    scene = read_scene_file(file).scene
    place = Path(f"{file.stem}.{kind}") if out is None else out
    with progress_on_stderr(quiet) as progress:
        progress("the steps as C code", 0.0)
        try:
            written = (write_c if kind == "c" else write_fmu)(scene, place, step)
        except OSError as error:
            raise SceneError(f"cannot write {place} ({error.strerror}); name another file with -o") from None
        progress("comparison with the event-driven solution", 0.3)
        try:
            difference, why = stepper(scene, step).error(), ""
        except RunFailed as failure:
            difference, why = math.nan, str(failure)
    if as_json:
        print_json({**written.to_dict(), "error": difference if math.isfinite(difference) else None})
    elif not quiet:
        say(", ".join(str(f) for f in written.files))
        say(_told(difference, why, step))
        if kind == "fmu" and not written.compiled:
            say("no C compiler was found: the unit holds sources alone, which the importer must compile")


def _told(error: float, why: str, step: float) -> str:
    if why:
        return f"not compared with the event-driven solution, which fails: {why}"
    if math.isinf(error):
        return f"the motion in steps of {step:g} leaves the finite numbers; give a shorter --step"
    advice = "; give a shorter --step" if error > _LARGE else ""
    return f"largest difference from the event-driven solution: {error:.1e} of the size of each state{advice}"
