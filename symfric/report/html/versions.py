"""Versions of the package and of the packages that it uses."""

import platform
from collections.abc import Mapping
from importlib import metadata

BESIDE = ("casadi", "numpy", "scipy", "sympy", "numba", "control")


def package_version(name: str) -> str:
    """Return the installed version of a distribution."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def versions() -> dict[str, str]:
    """Return the versions shown on a page."""
    installed = {name: package_version(name) for name in ("symfric", *BESIDE)}
    return {"python": platform.python_version(), **installed}


def used(versions: Mapping[str, str]) -> str:
    """Return the installed packages among those given, with their versions."""
    return ", ".join(f"{name} {version}" for name, version in versions.items() if version != "not installed")
