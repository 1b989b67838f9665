"""Closed forms: a function that states its formula gives numbers, unless the formula itself is asked for."""

import inspect
import re
from collections.abc import Callable
from functools import wraps
from types import UnionType
from typing import Any, ParamSpec, TypeVar, get_args

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC
from symfric.model.arguments import flag
from symfric.spelling import spelt

P = ParamSpec("P")
R = TypeVar("R")
#: What the arguments of closed forms mean, where the docstring of a function does not say it itself.
ARGUMENTS = {
    "scene": "scene : Scene, optional\n    A `sf.scenes.mass_on_belt` with the cubic law.",
    "order": "order : {1, 2}\n    Order of the approximation; 2 is closer.",
    "mass_ratio": "mass_ratio : float, optional\n    ``m2/m1`` > 0.",
    "mu1": "mu1 : float, optional\n    Half the slope of the force over the speed below the corner.",
    "lam": "lam : float, optional\n    Force of the spring at the stop less the kinetic friction at rest.",
    "symbolic": "symbolic : bool\n    Return the formula in `SYMBOLS` instead of a number.",
}


def closed_form(evaluate: Callable[..., Any]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function that returns a formula so that it returns the number, except with ``symbolic=True``.

    Parameters
    ----------
    evaluate : callable
        ``evaluate(formula, *arguments)``, with the arguments of the function but `symbolic`: returns the number, and
        raises where arguments are missing or the formula does not hold.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        formula_of = spelt(function)

        @wraps(function)
        def evaluated(*args: P.args, **kwargs: P.kwargs) -> R:
            symbolic = flag(kwargs.get("symbolic", False), "symbolic")
            with SYMBOLIC:
                formula = formula_of(*args, **kwargs)
                others = {name: value for name, value in kwargs.items() if name != "symbolic"}
                return formula if symbolic else evaluate(formula, *args, **others)

        evaluated.__doc__ = _completed(function)
        return evaluated

    return decorate


def _completed(function: Callable[..., Any]) -> str:
    """Return the docstring of a closed form with all its arguments, see `ARGUMENTS`, and with what it returns."""
    summary, *sections = re.split(r"\n\n(?=[A-Z]\w+\n---)", inspect.getdoc(function) or "")
    signature = inspect.signature(function)
    entries: dict[str, str] = {}
    if sections and sections[0].startswith("Parameters"):
        _, _, own = sections.pop(0).split("\n", 2)
        entries = {re.split("[ ,]", entry, maxsplit=1)[0]: entry for entry in re.split(r"\n(?=\S)", own)}
    known = {name for entry in entries.values() for name in entry.split(" :")[0].split(", ")}
    entries |= {name: ARGUMENTS[name] for name in signature.parameters if name not in known}
    listed = "\n".join(entries[name] for name in signature.parameters if name in entries)
    if not any(section.startswith("Returns") for section in sections):
        kind = signature.return_annotation
        names = " or ".join(e.__name__ for e in (get_args(kind) if isinstance(kind, UnionType) else (kind,)))
        sections.insert(0, f"Returns\n-------\n{names}")
    return "\n\n".join([summary, f"Parameters\n----------\n{listed}", *sections])


def needed(value: Any, name: str) -> Any:
    """Return an argument that a number requires and the symbolic formula does not; raise if it is missing."""
    if value is None:
        raise SceneError(f"no {name}; give a number, or ask for the formula with symbolic=True")
    return value
