"""Vibration caused and damped by dry friction: symbolic derivation, exact stick-slip simulation, optimal design.

The names listed in ``__init__.pyi`` are imported at their first use, so that a simulation does not load the modules of
designs and orbits.
"""

from symfric.interrupts import leave_at_interrupt

leave_at_interrupt()  # of the command, before anything else is loaded

import lazy_loader  # noqa: E402

from symfric.model.offering import guarded, offer  # noqa: E402
from symfric.model.services import provide  # noqa: E402

__version__ = "0.1.0"

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str):
    """Import a public name at its first use and keep it."""
    globals()[name] = found = guarded(_load(name), __name__)
    return found


def _study(scene, progress=None):
    """Return the study of a scene; see `Scene.study`."""
    from symfric.report.study.study import study_of

    return study_of(scene, progress)


provide("study", _study)
offer(__name__)
