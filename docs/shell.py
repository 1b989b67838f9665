"""Run a command of symfric inside a page and show what it prints."""

import shlex
from pathlib import Path

from click.testing import CliRunner

EXAMPLES = Path(__file__).parents[1] / "examples"


def shell(line: str) -> None:
    """Run a line such as ``symfric explain belt.toml`` and print its output; a failure of the command is an error."""
    from symfric.cli import main

    found = CliRunner().invoke(main, shlex.split(line)[1:])
    print(found.output.rstrip())
    if found.exit_code:
        raise RuntimeError(f"{line} ended with status {found.exit_code}")
