"""The command line. Exit status 0 (success), 1 (no solution), 2 (bad input), 130 (interrupted)."""

import errno
import importlib
import os
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

import click

from symfric.cli.console import say
from symfric.cli.streams import hold_closed, safe_streams
from symfric.errors import NoRoute, NotFound, RunFailed, SceneError
from symfric.interrupts import STATUS, leave_at_interrupt
from symfric.long_calls import silent

COMMANDS = {  # name: module and attribute, imported at first use
    "new": "symfric.cli.new:new",
    "study": "symfric.cli.commands:study",
    "explain": "symfric.cli.commands:explain",
    "sweep": "symfric.cli.sweep:sweep",
    "identify": "symfric.cli.identify:identify",
    "explore": "symfric.cli.explore:explore",
    "export": "symfric.cli.export:export",
    "scenes": "symfric.cli.commands:scenes",
    "reproduce": "symfric_evidence.commands.reproduce:reproduce",
    "bench": "symfric_evidence.commands.bench:bench",
    "stress": "symfric_evidence.commands.stress:stress",
}

_EVIDENCE = "symfric_evidence"  # a package of its own, which a checkout has beside this one
_CHECKOUT = Path(__file__).parents[2] / "derivations" / "evidence"
_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")


class _OneLine(click.ClickException):
    """An error shown as one line on stderr."""

    def show(self, file: IO[Any] | None = None) -> None:
        """Print the error."""
        say(f"Error: {self.format_message()}", err=True)


class BadInput(_OneLine):
    """Bad input: exit status 2."""

    exit_code = 2


class NoAnswer(_OneLine):
    """No solution: exit status 1."""

    exit_code = 1


def _in_one_line(error: click.UsageError) -> BadInput:
    """Return a usage error as one line, with the command that shows help."""
    path = "symfric" if error.ctx is None else error.ctx.command_path
    return BadInput(f"{error.format_message().rstrip('.')}; see {path} --help")


def _is_here(name: str) -> bool:
    """Whether a command can be imported; those of the evidence need its package."""
    if not COMMANDS[name].startswith(_EVIDENCE):
        return True
    if _CHECKOUT.is_dir() and str(_CHECKOUT) not in sys.path:
        sys.path.insert(0, str(_CHECKOUT))  # before an installed one, which may be older
    return find_spec(_EVIDENCE) is not None


class Commands(click.Group):
    """The group of commands: imports a command when it is used, and shows errors as one line with an exit status."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run with safe output streams; lost output gives exit status 1, except after a closed pipe."""
        hold_closed()
        with safe_streams() as output, silent():
            try:
                return super().main(*args, **kwargs)
            except SystemExit as ended:
                sys.stdout.flush()
                if output.failure is None or output.failure.errno == errno.EPIPE or ended.code:
                    raise
                say(f"Error: cannot write to standard output ({output.failure.strerror})", err=True)
                raise SystemExit(1) from None
            finally:
                leave_at_interrupt()

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of those that are installed in the order of `COMMANDS`."""
        return [name for name in COMMANDS if _is_here(name)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, or raise with the nearest known name."""
        if cmd_name not in COMMANDS:
            from symfric.model.symbols import nearest  # slow to import

            ctx.fail(f"no command {cmd_name!r}{nearest(cmd_name, COMMANDS)}")
        if not _is_here(cmd_name):
            raise BadInput(
                f"symfric {cmd_name} is in the package symfric-evidence; install that from the source of symfric with "
                "python -m pip install ./derivations/evidence"
            )
        for name in _THREADS:  # before NumPy is loaded: its threads cost more than they bring on matrices of this size
            os.environ.setdefault(name, "1")
        module, attribute = COMMANDS[cmd_name].split(":")
        command: click.Command = getattr(importlib.import_module(module), attribute)
        return command

    def make_context(self, *args: Any, **kwargs: Any) -> click.Context:
        """Parse the options before the command; errors are one line."""
        try:
            return super().make_context(*args, **kwargs)
        except click.UsageError as error:
            raise _in_one_line(error) from None

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except click.UsageError as error:
            raise _in_one_line(error) from None
        except SceneError as error:
            raise BadInput(str(error)) from None
        except (NotFound, NoRoute, RunFailed) as error:
            raise NoAnswer(str(error)) from None
        except KeyboardInterrupt:
            exec(
                ""
            )  # makes Python forget an interrupt inside generated code, for which it would kill itself at its end
            say("interrupted", err=True)
            return ctx.exit(STATUS)
        except MemoryError:
            raise NoAnswer("not enough memory; take a smaller problem, or fewer values") from None


def _show_version(ctx: click.Context, _parameter: click.Parameter, asked: bool) -> None:
    if asked:
        from symfric.report.html.versions import package_version

        say(f"symfric {package_version('symfric')}")
        ctx.exit()


@click.command(
    "symfric", cls=Commands, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_show_version,
    help="Show the version and exit.",
)
@click.pass_context
def main(ctx: click.Context) -> None:
    """Vibration caused and damped by dry friction.

    \b
    Example: symfric study examples/belt.toml -o out/
    """
    if ctx.invoked_subcommand is None:
        say(ctx.get_help())
