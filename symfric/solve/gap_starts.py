"""Whether other values or another start leave gaps open or closed, and restitutions between 0 and 1."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from symfric.model.numeric import numeric
from symfric.model.scene import Scene
from symfric.model.symbols import TIME

_WITHIN = 1e-9  # of the sizes of coordinates: a gap as negative counts as closed, since the end of a run may be a start


class GapStarts:
    """Gaps and restitutions of a scene at the start, for other numbers.

    Attributes
    ----------
    names : frozenset of str
        Of the parameters and states on which they depend; empty without contacts that open.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._opening = [(c.name, c.unilateral) for c in scene.contacts if c.unilateral is not None]
        used: set[sp.Symbol] = set().union(*(u.free_symbols for _, u in self._opening))
        known = {*scene.values, *scene.system.states}
        self._symbols = tuple(sorted(used & known, key=str))
        self._signals = {s: float(signal(0.0)) for s, signal in scene.inputs.items() if s in used}
        self._whole = used <= known | {TIME} | self._signals.keys()  # not the rows of a structure
        self.names = frozenset(s.name for s in self._symbols) if self._whole else frozenset()

    @cached_property
    def _entries(self) -> Callable[..., Any]:
        fixed = {TIME: sp.S.Zero, **self._signals}
        parts = [e.xreplace(fixed) for _, u in self._opening for e in (u.gap, u.restitution)]
        return numeric(self._symbols, tuple(parts))

    def wrong(self, numbers: Mapping[str, Any]) -> tuple[np.ndarray, str]:
        """Return which cases are wrong, shape (n,) or (), and what is wrong in the first of them.

        Parameters
        ----------
        numbers : mapping of str to float or ndarray, shape (n,)
            What differs from the numbers of the scene.
        """
        own = self._scene.numbers()
        given = [numbers.get(s.name, own[s]) for s in self._symbols]
        entries = self._entries(*given)
        size = 1e-300 + sum(np.abs(g) for g in given)
        lost, said = np.zeros(np.shape(entries[0]), dtype=bool), ""
        for k, (name, _) in enumerate(self._opening):
            gap, e = entries[2 * k], entries[2 * k + 1]
            below, beyond = ~(gap >= -_WITHIN * size), ~((e >= 0) & (e <= 1))
            for bad, value, what, cure in (
                (below, gap, "gap", "at the start; it must not be negative"),
                (beyond, e, "restitution", "; it must lie between 0 and 1"),
            ):
                if not said and np.any(bad):
                    shown = np.ravel(np.broadcast_to(value, bad.shape))[np.argmax(np.ravel(bad))]
                    said = f"{what} of contact {name!r} is {shown:.6g}{'' if cure[0] == ';' else ' '}{cure}"
                lost |= bad
        return lost, said
