"""Public names of a package: `dir` lists them alone, and the error of a misspelled one names the nearest."""

import sys
from collections.abc import Callable
from typing import NoReturn


def names_of(package: str) -> tuple[Callable[[], list[str]], Callable[[str], NoReturn]]:
    """Return ``__dir__`` and ``__getattr__`` of a module.

    Type checkers must not see the latter, which would let every name pass.

    Parameters
    ----------
    package : str
        Its ``__name__``; without ``__all__`` it offers what it defines itself.
    """

    def listed() -> list[str]:
        known = vars(sys.modules[package])
        own = (n for n, thing in known.items() if n[0] != "_" and getattr(thing, "__module__", "") == package)
        return sorted(known.get("__all__", own))

    def unknown(name: str) -> NoReturn:
        raise unknown_name(package, name, listed())

    return listed, unknown


def unknown_name(package: str, name: str, known: list[str]) -> AttributeError:
    """Return the error of a name that a package does not have."""
    if name.startswith("_"):  # of a protocol
        return AttributeError(f"{package} has no attribute {name!r}")
    from symfric.model.symbols import nearest  # SymPy, which an import of the package does not load

    return AttributeError(f"{package.replace('.model.', '.')} has no name {name!r}{nearest(name, known)}")
