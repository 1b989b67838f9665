"""Name the argument that a failed call could not use, by the types that the docstring of the function states."""

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from numbers import Integral, Real
from os import PathLike

import sympy as sp

_LISTS = {"array", "array_like", "iterable", "list", "lists", "matrix", "ndarray", "sequence", "sequences", "tuple"}
_KINDS: tuple[tuple[set[str], Callable[[object], bool]], ...] = (  # words of a docstring, what they let through
    ({"float", "number", "numbers"}, lambda v: isinstance(v, Real | sp.Number)),
    ({"int", "integer"}, lambda v: isinstance(v, Integral)),
    ({"expr", "expression", "expressions"}, lambda v: isinstance(v, Real | sp.Expr)),
    ({"symbol", "symbols"}, lambda v: isinstance(v, sp.Basic)),
    (_LISTS, lambda v: isinstance(v, Iterable) and not isinstance(v, str | Mapping)),
    ({"mapping", "dict"}, lambda v: isinstance(v, Mapping)),
    ({"str", "name", "names"}, lambda v: isinstance(v, str)),
    ({"path"}, lambda v: isinstance(v, str | PathLike)),
    ({"callable"}, callable),
    ({"bool"}, lambda v: isinstance(v, bool)),
)


def blamed(function: Callable, args: tuple, kwargs: Mapping[str, object]) -> str | None:
    """Return ``name, value and what it takes`` of the first argument of another kind than the docstring says.

    Parameters
    ----------
    function : callable
    args : tuple
    kwargs : mapping of str to object
        What it was called with.

    Returns
    -------
    str or None
        None if every argument is of its kind: then the fault is elsewhere.
    """
    try:
        given = inspect.signature(function).bind(*args, **kwargs).arguments
    except TypeError:
        return None
    stated = stated_types(function)
    for name, value in given.items():
        if name in stated and not _accepted(stated[name], value):
            return f"{name} is {shortened(value)}; it takes {stated[name].removesuffix(', optional')}"
    return None


def stated_types(function: Callable) -> dict[str, str]:
    """Return the types in the section ``Parameters`` of a docstring, by argument."""
    owner = function.__qualname__.rpartition(".")
    text = inspect.getdoc(function) or ""
    if owner[2] == "__init__":
        text = inspect.cleandoc(getattr(inspect.getmodule(function), owner[0]).__doc__ or "")
    section = re.search(r"^(?:Parameters|Attributes)\n-+\n(.*?)(?=^\S[^\n]*\n-+\n|\Z)", text, re.MULTILINE | re.DOTALL)
    if section is None:
        return {}
    entries = re.findall(r"^(\S[^:\n]*) : ([^\n]+)$", section[1], re.MULTILINE)
    return {name.strip(): kind for names, kind in entries for name in names.split(",")}


def shortened(value: object) -> str:
    """Return the text of a value in one line of at most 60 letters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def _accepted(stated: str, value: object) -> bool:
    """Whether a value may be meant by the words of a docstring; true if they say nothing that can be checked."""
    if value is None:
        return True
    outer = stated.split(" of ")[0]  # of "sequence of symbol" only the sequence
    words = set(re.findall(r"[A-Za-z_]+", outer))
    small = {w.lower() for w in words}
    small |= {"tuple"} if "(" in outer else set()
    checks = [check for names, check in _KINDS if names & small]
    checks += [lambda v: isinstance(v, str)] if '"' in stated or "'" in stated else []
    classes = {w for w in words if w[0].isupper() and w not in ("None", "True", "False", "Expr", "Symbol")}
    if classes:
        checks.append(lambda v: any(kind.__name__ in classes for kind in type(v).__mro__))
    return not checks or any(check(value) for check in checks)
