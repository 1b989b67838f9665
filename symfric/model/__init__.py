"""Friction laws, mechanical systems, contacts and scenes: the SymPy layer, where every equation is written."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, ["control", "laws", "mechanics", "scenes"])
