"""Vibration caused and damped by dry friction: symbolic derivation, exact stick-slip simulation, optimal design.

The names listed in ``__init__.pyi`` are imported at their first use, so that a simulation does not load the modules of
designs and orbits.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
