"""The command line: ``python -m symfric study FILE.toml`` is ``symfric study FILE.toml``."""

from symfric.cli import main

main(prog_name="symfric")
