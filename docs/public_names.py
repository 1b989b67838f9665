"""The public names of the package, as the reference pages and the test of the docstrings see them."""

import inspect
from collections.abc import Iterator
from types import ModuleType

import symfric


def public_names() -> dict[str, object]:
    """Return every public name without its ``sf.``: ``simulate``, ``laws.coulomb``, ``theory.belt.onset_speed``.

    A thing with several names is listed once, under the first and shortest of them.
    """
    found: dict[str, object] = {}
    for name, thing in sorted(_below(symfric, ""), key=lambda item: item[0].count(".")):
        if not any(thing is other for other in found.values()):
            found[name] = thing
    return dict(sorted(found.items(), key=lambda item: item[0].lower()))


def offered(module: ModuleType) -> list[str]:
    """Return the names that a module offers: its ``__all__``, else what it defines itself."""
    own = [n for n, t in vars(module).items() if not n.startswith("_") and _home(t) == module.__name__]
    return list(getattr(module, "__all__", own))


def _home(thing) -> str:
    return getattr(thing, "__module__", "") if inspect.isclass(thing) or inspect.isfunction(thing) else ""


def _below(module: ModuleType, prefix: str) -> Iterator[tuple[str, object]]:
    for name in offered(module):
        thing = getattr(module, name)
        if isinstance(thing, ModuleType):
            yield from _below(thing, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", thing


def public_methods(kind: type) -> dict[str, object]:
    """Return the methods that a public class defines itself, inherited ones of the package included."""
    found = {}
    for name in dir(kind):
        method = inspect.getattr_static(kind, name)
        method = getattr(method, "__func__", method)
        if not name.startswith("_") and inspect.isfunction(method) and method.__module__.startswith("symfric"):
            found[name] = method
    return found
