"""The command ``explore``."""

import contextlib
from pathlib import Path

import click

from symfric.cli.console import common_options, print_json, progress_on_stderr, say
from symfric.errors import SceneError


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--port", default=0, type=click.IntRange(0, 65535), help="Port of the page; any free one unless given.")
@click.option("--open", "opening", is_flag=True, help="Open the page in the browser.")
@common_options
def explore(file: Path, port: int, opening: bool, as_json: bool, quiet: bool) -> None:
    """Serve a local web page with a slider for each value of a scene file and live figures.

    Ctrl-C ends it.

    \b
    Example: symfric explore examples/belt.toml --open
    """
    from importlib.util import find_spec

    from symfric.scenefile import read_scene_file

    scene_file = read_scene_file(file)
    if find_spec("bokeh") is None:
        raise SceneError("symfric explore needs Bokeh; install it with: python -m pip install 'symfric[explore]'")
    from symfric.report.explorer.page import page
    from symfric.report.explorer.server import check_free, serve
    from symfric.report.explorer.views import explorer

    check_free(port, "--port")
    with progress_on_stderr(quiet) as progress:
        progress("compiling", 0.0)
        prepared = explorer(scene_file)

    def ready(address: str) -> None:
        if as_json:
            print_json({"address": address})
        elif not quiet:
            say(f"{address} (Ctrl-C ends it)")
        if opening:
            click.launch(address)

    with contextlib.suppress(KeyboardInterrupt):
        serve(page(prepared), port, ready)
