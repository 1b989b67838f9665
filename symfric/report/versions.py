"""Versions of the package and of what its numbers rest on."""

import platform
from importlib import metadata

BESIDE = ("casadi", "numpy", "scipy", "sympy", "numba", "control")


def package_version(name: str) -> str:
    """Return the installed version of a distribution."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def versions() -> dict[str, str]:
    """Return the versions a page should state."""
    found = {name: package_version(name) for name in ("symfric", *BESIDE)}
    return {"python": platform.python_version(), **found}
