"""Walk large expressions by their distinct parts: a part that stands in a hundred places is met once."""

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

import sympy as sp

Part = TypeVar("Part", bound=sp.Basic)


def distinct(expr: sp.Basic) -> Iterator[sp.Basic]:
    """Yield every part of an expression, itself included, each once.

    SymPy's own walks meet a part as often as it is written, so that a closed form of nested roots takes seconds.
    """
    seen, waiting = {expr}, [expr]
    while waiting:
        part = waiting.pop()
        yield part
        for argument in part.args:
            if argument not in seen:
                seen.add(argument)
                waiting.append(argument)


def parts_of(expr: sp.Basic, *kinds: type[Part]) -> set[Part]:
    """Return the parts of an expression that are of some kinds.

    Examples
    --------
    >>> import sympy as sp
    >>> x = sp.Symbol("x")
    >>> parts_of(sp.sin(x) + sp.cos(x), sp.sin)
    {sin(x)}
    """
    return {part for part in distinct(expr) if isinstance(part, kinds)}


def replaced(expr: sp.Expr, rule: Mapping[Any, Any]) -> sp.Expr:
    """Return `expr.xreplace(rule)`, where each part is rebuilt once.

    Examples
    --------
    >>> import sympy as sp
    >>> x, y = sp.symbols("x y")
    >>> replaced(sp.sin(x) + sp.cos(x), {x: y})
    sin(y) + cos(y)
    """
    if not rule:
        return expr
    made: dict[sp.Basic, sp.Basic] = dict(rule)
    waiting = [expr]
    while waiting:
        part = waiting[-1]
        missing = [argument for argument in part.args if argument not in made]
        if part in made or not missing:
            waiting.pop()
            if part not in made:
                arguments = [made[argument] for argument in part.args]
                made[part] = part if tuple(arguments) == part.args else part.func(*arguments)
        else:
            waiting += missing
    return made[expr]
