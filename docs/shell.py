"""Run a command of symfric inside a page and show what it prints."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples"


def shell(line: str) -> None:
    """Run a line such as ``symfric explain belt.toml`` and print its output; a failure of the command is an error."""
    words = [sys.executable, "-m", *shlex.split(line)]
    done = subprocess.run(words, capture_output=True, text=True, env={**os.environ, "COLUMNS": "100"})
    print(done.stdout.rstrip())
    if done.returncode:
        raise RuntimeError(f"{line} ended with status {done.returncode}: {done.stderr}")
