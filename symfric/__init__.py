"""Vibration caused and damped by dry friction: symbolic derivation, exact stick-slip simulation, optimal design.

What ``__init__.pyi`` lists is loaded when it is asked for, so that a simulation does not wait for the design and the
orbits.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
