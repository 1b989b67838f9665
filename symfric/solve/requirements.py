"""Whether other values satisfy what the numbers of the contacts and of their laws must."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from symfric.model.numeric import numeric
from symfric.model.scene import Scene
from symfric.model.validation import requirements_of


class Requirements:
    """Numbers of the contacts of a scene that must be positive, or not negative, for other values.

    Attributes
    ----------
    names : frozenset of str
        Of the parameters on which they depend.
    """

    def __init__(self, scene: Scene) -> None:
        every = [e for c in scene.contacts for e in requirements_of(c)]
        self._scene = scene
        self._asked = [e for e in every if e.value.free_symbols and e.value.free_symbols <= scene.values.keys()]
        self._symbols = tuple(sorted({s for e in self._asked for s in e.value.free_symbols}, key=str))
        self.names = frozenset(s.name for s in self._symbols)

    @cached_property
    def _entries(self) -> Callable[..., Any]:
        return numeric(self._symbols, tuple(e.value for e in self._asked))

    def wrong(self, numbers: Mapping[str, Any]) -> tuple[np.ndarray, str]:
        """Return which cases are wrong, shape (n,) or (), and what is wrong in the first of them.

        Parameters
        ----------
        numbers : mapping of str to float or ndarray, shape (n,)
            What differs from the numbers of the scene.
        """
        own = self._scene.values
        given = [np.asarray(numbers.get(s.name, own[s]), dtype=float) for s in self._symbols]
        entries = [np.asarray(e) for e in self._entries(*given)]
        wrong, said = np.zeros(np.broadcast_shapes(*(e.shape for e in (*given, *entries))), dtype=bool), ""
        for asked, value in zip(self._asked, entries, strict=True):
            bad = ~asked.holds(value)
            if not said and np.any(bad):
                said = asked.complaint(float(value[bad][0]) if value.ndim else float(value))
            wrong |= bad
        return wrong, said
