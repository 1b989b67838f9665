"""The command ``new``."""

from pathlib import Path

import click

from symfric.cli.console import common_options, print_json, say, writable_folder, write_results
from symfric.errors import SceneError


@click.command()
@click.argument("words", nargs=-1, metavar="[MODEL] FILE")
@click.option("--force", is_flag=True, help="Replace FILE if it exists.")
@common_options
def new(words: tuple[str, ...], force: bool, as_json: bool, quiet: bool) -> None:
    """Write a scene file to start from: of a ready MODEL, or with own equations if none is named.

    `symfric scenes` lists the models; `structure` has its equations from matrices, which are written beside it. The
    file runs as it is, and says what its numbers are.

    \b
    Example: symfric new mass_on_belt belt.toml
    """
    from symfric.scenefile.starters import companions, starter

    if not 1 <= len(words) <= 2:
        raise SceneError("name the file to write, perhaps with a model before it: symfric new mass_on_belt belt.toml")
    model, path = ("own", *words)[-2:]
    place = Path(path)
    if place.suffix != ".toml":
        raise SceneError(f"{path} is no name for a scene file; it ends in .toml, such as {place.stem or 'scene'}.toml")
    text = starter(model).replace("FILE.toml", path).replace("FILE-", f"{place.stem}-")
    folder = place.parent / f"{place.stem}-matrices"
    beside = {folder / name: content for name, content in companions(model).items()}
    there = next((p for p in (place, *beside) if p.exists()), None)
    if there is not None and not force:
        raise SceneError(f"{there} exists; name another file, or replace it with --force")
    if beside:
        writable_folder(folder)
    write_results({place: text, **beside})
    if as_json:
        print_json({"file": path, "model": model})
    elif not quiet:
        say(f"{path} is written; next: symfric study {path}")
