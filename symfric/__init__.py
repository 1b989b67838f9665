"""Vibration caused and damped by dry friction: symbolic derivation, exact stick-slip simulation, optimal design.

The names listed in ``__init__.pyi`` are imported at their first use, so that a simulation does not load the modules of
designs and orbits.
"""

from symfric.interrupts import leave_at_interrupt

leave_at_interrupt()  # of the command, before anything else is loaded

from typing import Any  # noqa: E402

import lazy_loader  # noqa: E402

from symfric.model.public_names import unknown_name  # noqa: E402

__version__ = "0.1.0"

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Import a public name at its first use and keep it."""
    if name not in __all__:
        raise unknown_name(__name__, name, __all__)
    globals()[name] = value = _load(name)
    return value
