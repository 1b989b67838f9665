"""The messages: every status of a run and every exception, with its cure, as the package itself words them."""

import inspect
import re
from pathlib import Path

from docs.files import put
from symfric import errors
from symfric.solve.status import ADVICE, Status, early_end

_TYPED = re.compile(
    r"(?<![\w`])(?:route=(?:sf\.\w+\([^)]*\)|'\w+')|max_\w+|run\.\w+(?:\[[^]]*\]|\(\))?|sf\.\w+(?:\.\w+)*)"
)
_SAID = {  # what people look for when they meet a status
    Status.OK: "finished, success, converged",
    Status.EVENT_BUDGET: "too many events, does not finish, takes for ever, chattering, Zeno",
    Status.STEP_BUDGET: "too slow, did not converge, does not finish, hangs, maximum number of steps, out of memory",
    Status.STEP_COLLAPSE: "did not converge, step size too small, stiff, singular, blows up",
    Status.CHATTER: "chattering, Zeno behaviour, infinitely many events, events do not advance",
    Status.NOT_FINITE: "nan, inf, overflow, division by zero, diverges, unstable",
    Status.LOST_CONTACT: "lift-off, separation, negative normal force, gap opens",
    Status.UNDECIDED: "no solution, complementarity problem, inconsistent friction",
    Status.INTEGRATOR: "did not converge, Newton failed, CVODES error, corrector convergence",
    Status.NO_DERIVATIVE: "nan sensitivities, gradient is nan, not differentiable, grazing",
    Status.QUEUE_FULL: "delay too long, dead time, buffer overflow",
    Status.PAINLEVE: "jamming, paradox, no solution, several solutions, tangential impact",
    Status.MANY_CONTACTS: "many bodies, pile, chain of balls, combinations, enumeration",
    Status.OVERLAP: "penetration, interpenetration, bodies inside each other, falls through the floor",
}


def write(folder: Path) -> None:
    """Write the page."""
    text = (folder / "messages.in.md").read_text(encoding="utf-8")
    text = text.replace("<!-- statuses -->", "\n".join(map(_status, Status)))
    put(folder / "messages.md", text.replace("<!-- errors -->", "\n".join(map(_error, _exceptions()))))


def _status(status: Status) -> str:
    """Return the section of a status: meaning and cure, as a run and as a function that makes runs say them."""
    said = _SAID[status]
    entries = "\n".join(f"```{{index}} single: {words.strip()}; {status.name}\n```\n" for words in said.split(","))
    meaning, _, cure = ADVICE[status].partition("; ")
    found = early_end("a motion", status).partition(": ")[2]
    parts = [f"### {status.name}\n", entries]
    if meaning:
        parts += [f"**Meaning**: {_sentence(meaning)}\n", f"**Cure**: {_sentence(cure or meaning)}\n"]
        parts += [f"Inside a function that makes its own runs: {_sentence(found)}\n"] if found != ADVICE[status] else []
    else:
        parts += [f"{_sentence(' '.join(_of_ok().split()))}\n"]
    return "\n".join([*parts, f"Also looked for as: {said}.\n"])


def _of_ok() -> str:
    """Return what the docstring says of a run that went well."""
    return (inspect.getdoc(Status) or "").split("OK : Status")[1].partition("\n\n")[0]


def _exceptions() -> list[type[Exception]]:
    return [e for _, e in inspect.getmembers(errors, inspect.isclass) if e.__module__ == errors.__name__]


def _error(error: type[Exception]) -> str:
    words, _, rest = (inspect.getdoc(error) or "").partition("\n\n")
    example = rest.partition("--------\n")[2].strip()
    return f"### {error.__name__}\n\n{' '.join(words.split())}\n\n```pycon\n{example}\n```\n"


def _sentence(text: str) -> str:
    """Return a text as a sentence, with what one types in the letters of code."""
    typed = _TYPED.sub(lambda found: f"`{found[0]}`", text[:1].upper() + text[1:].rstrip("."))
    return typed + "."
