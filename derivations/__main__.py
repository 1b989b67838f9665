"""``python -m derivations``: carry out all checks and print the ledger. Exit status 0, 1 (unsound), 2 or 130."""

import click

from derivations import written
from derivations.sources import SOURCES, checked
from symfric.cli import BadInput
from symfric.cli.console import common_options, print_json, progress_on_stderr
from symfric.model.symbols import nearest


@click.command(context_settings={"help_option_names": ["-h", "--help"]}, epilog=f"Sources: {', '.join(SOURCES)}.")
@click.argument("source", required=False)
@click.option("--markdown", "as_markdown", is_flag=True, help="Print it as derivations/README.md has it.")
@click.option("--revised", "as_revised", is_flag=True, help="Print the verdicts that were revised, and why.")
@common_options
@click.pass_context
def main(ctx: click.Context, source: str | None, as_markdown: bool, as_revised: bool, as_json: bool, quiet: bool):
    """Derive every equation of the sources, or of one SOURCE, and print what became of it.

    Exit status 1 if a row is unsound: its residual is not zero, or the printed form of a correction passes too.

    \b
    Example: python -m derivations guida
    """
    if source is not None and source not in SOURCES:
        raise BadInput(f"no source {source!r}{nearest(source, SOURCES)}")
    if as_json and as_markdown:
        raise BadInput("--json and --markdown exclude each other; give one of them")
    if as_revised:
        if source is not None or as_markdown:
            raise BadInput("--revised prints one table; leave SOURCE and --markdown out")
        _print_revised(as_json)
        return
    try:
        with progress_on_stderr(quiet) as progress:
            found = checked(SOURCES if source is None else (source,), progress)
    except KeyboardInterrupt:
        click.echo("interrupted", err=True)
        ctx.exit(130)
    if as_json:
        print_json(written.to_dict(found))
    elif as_markdown:
        click.echo(written.markdown(found), nl=False)
    else:
        click.echo(written.text(found))
    ctx.exit(0 if all(row.sound for rows in found.values() for row in rows) else 1)


def _print_revised(as_json: bool) -> None:
    from derivations.revised import revised

    names = ("source", "equation", "statement", "before", "now", "why")
    if as_json:
        print_json([dict(zip(names, row, strict=True)) for row in revised()])
    else:
        click.echo(written.revisions())


if __name__ == "__main__":
    main(prog_name="python -m derivations")
