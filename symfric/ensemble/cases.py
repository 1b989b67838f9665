"""Cases that are listed one by one: values, starts and scenes that change together, by the machinery of sweeps."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from symfric.ensemble.grid import Grid, widths
from symfric.ensemble.scheduler import Board
from symfric.ensemble.sweep import run_left, workers_of
from symfric.locks import SYMBOLIC, alone
from symfric.model.scene import Scene
from symfric.solve.program import check_tolerance


@dataclass(frozen=True, eq=False)
class Cases(Grid):
    """Rows of numbers in place of the product of axes.

    Attributes
    ----------
    rows : ndarray, shape (n, number of parameters)
    """

    rows: np.ndarray

    def numbers(self, cases: np.ndarray) -> np.ndarray:
        """Return the rows of some cases."""
        return self.rows[cases]


@alone(SYMBOLIC)
def with_starts(scene: Scene, states: Sequence[str]) -> tuple[Scene, dict[str, str]]:
    """Return the scene with parameters as the starts of some states, and their names by the states'."""
    symbols = {n: sp.Symbol(f"{n}(0)", real=True) for n in states}
    initial = {s.name: symbols.get(s.name, v) for s, v in scene.initial.items()}
    values = {**scene.values, **dict.fromkeys(symbols.values(), 1.0)}  # not zero: that would be built in
    return replace(scene, initial=initial, values=values), {n: s.name for n, s in symbols.items()}


def run_cases(
    scenes: Sequence[Scene],
    columns: Mapping[str, np.ndarray] | None = None,
    *,
    starts: np.ndarray | None = None,
    jobs: int = 1,
    progress: Callable[[float], None] | None = None,
    tolerance: float = 1e-9,
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Run cases whose values, starts and scenes change together.

    Parameters
    ----------
    scenes : sequence of Scene
        One for all cases, or one for each; with the same scalar outputs.
    columns : mapping of parameter to ndarray (n,), optional
    starts : ndarray, shape (n_x, n), optional
        In place of those of the scenes.
    jobs, progress, tolerance
        See `symfric.ensemble.sweep.sweep`; `progress` gets the fraction done.

    Returns
    -------
    status : ndarray of int, shape (n,)
        Codes of `Status`, -1 for values that the scene refuses, -2 for an error.
    outputs : dict of str to ndarray
        Of shape (n,), of `End` (n_x, n); NaN where a run failed.
    """
    named = {n: np.asarray(c, dtype=float) for n, c in (columns or {}).items()}
    if starts is not None:
        states = [s.name for s in scenes[0].system.states]
        started = [with_starts(scene, states) for scene in scenes]
        scenes = [scene for scene, _ in started]
        named |= {started[0][1][n]: row for n, row in zip(states, starts, strict=True)}
    n = max([len(scenes), *(c.size for c in named.values())])
    rows = np.column_stack(list(named.values())) if named else np.zeros((n, 0))
    scene_of = np.arange(n) if len(scenes) > 1 else np.zeros(n, dtype=int)
    width = widths({str(k): scene for k, scene in enumerate(scenes)})
    cases = Cases({"case": np.arange(n)}, tuple(scenes), scene_of, tuple(named), width, rows)
    board = Board(n, sum(width.values()))
    report = None if progress is None else lambda p: progress(p.done / p.total)
    run_left(cases, board, check_tolerance(tolerance), None, min(workers_of(jobs), n), None, report)
    found, place = {}, 0
    for name, count in width.items():
        block = board.values[:, place : place + count]
        found[name], place = (block[:, 0] if count == 1 else block.T), place + count
    return board.status, found
