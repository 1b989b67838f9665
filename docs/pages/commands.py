"""The commands with their arguments and options, from the command line itself."""

from pathlib import Path

import click

from docs.files import put
from symfric.cli import COMMANDS, main


def write(folder: Path) -> None:
    """Write the page."""
    context = click.Context(main, info_name="symfric")
    parts = ["# Commands\n", (folder / "commands.in.md").read_text(encoding="utf-8")]
    for name in COMMANDS:
        command = main.get_command(context, name)
        assert command is not None
        parts.append(_section(command, click.Context(command, info_name=f"symfric {name}")))
    put(folder / "commands.md", "\n".join(parts))


def _section(command: click.Command, context: click.Context) -> str:
    words, _, example = (command.help or "").partition("\b\n")
    lines = [f"## `{context.info_name}`", "", words.strip(), ""]
    if example:
        lines += ["```sh", example.strip().removeprefix("Example: "), "```", ""]
    lines += ["```text", command.get_usage(context).removeprefix("Usage: "), "```", "", "| option | |", "|---|---|"]
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record:
            lines.append(f"| `{record[0].replace('|', chr(92) + '|')}` | {record[1].replace('|', chr(92) + '|')} |")
    return "\n".join(lines) + "\n"
