"""Check of the parameters of the ready laws."""

import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec

from symfric.model.laws.law import Law
from symfric.model.symbols import refuse_speed

_Given = ParamSpec("_Given")


def without_speed(make: Callable[_Given, Law]) -> Callable[_Given, Law]:
    """Return a law's function that refuses parameters in which the sliding speed stands."""
    names = tuple(inspect.signature(make).parameters)

    @functools.wraps(make)
    def checked(*args: _Given.args, **kwargs: _Given.kwargs) -> Law:
        for name, value in (*zip(names, args, strict=False), *kwargs.items()):
            refuse_speed(value, f"{name} of {make.__name__}")
        return make(*args, **kwargs)

    return checked
