"""What upper layers do for objects of the model, offered as methods of these; the package connects them."""

from collections.abc import Callable
from typing import Any

_PROVIDED: dict[str, Callable[..., Any]] = {}


def provide(name: str, function: Callable[..., Any]) -> None:
    """Say which function a method calls.

    Parameters
    ----------
    name : str
    function : callable
    """
    _PROVIDED[name] = function


def service(name: str) -> Callable[..., Any]:
    """Return the function that was provided under a name.

    Parameters
    ----------
    name : str

    Returns
    -------
    callable
    """
    return _PROVIDED[name]
