"""Whether other values or another start leave the mass matrix positive definite."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from symfric.model.numeric import numeric
from symfric.model.scene import Scene


class Inertia:
    """The mass matrix of a scene at the start, for other numbers.

    Attributes
    ----------
    names : frozenset of str
        Of the parameters and states on which the mass depends; empty if it is constant.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        mass = scene.system.mass
        symbols: set[sp.Symbol] = set() if mass is None else mass.free_symbols
        self._symbols = tuple(sorted(symbols, key=str))
        self.names = frozenset(s.name for s in self._symbols)

    @cached_property
    def _entries(self) -> Callable[..., Any]:
        return numeric(self._symbols, tuple(self._scene.system.mass))

    def definite(self, numbers: Mapping[str, Any]) -> np.ndarray:
        """Return whether each case has a positive definite mass, shape (n,) or ().

        Parameters
        ----------
        numbers : mapping of str to float or ndarray, shape (n,)
            What differs from the numbers of the scene.
        """
        own = self._scene.numbers()
        entries = self._entries(*(numbers.get(s.name, own[s]) for s in self._symbols))
        system = self._scene.system
        mass = np.stack(entries, axis=-1).reshape(*entries[0].shape, *system.mass.shape)
        if system.linear is not None:
            mass = mass + system.linear.M.toarray()
        finite = np.all(np.isfinite(mass), axis=(-2, -1))
        mass[~finite] = -1.0
        return np.linalg.eigvalsh(mass)[..., 0] > 0
