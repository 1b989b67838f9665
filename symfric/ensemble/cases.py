"""Sweeps over a list of cases, in which values and starts change together."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from symfric.ensemble.grid import Grid, widths
from symfric.ensemble.progress import Meter
from symfric.ensemble.scheduler import Results, run_on_threads
from symfric.ensemble.worker import Task, make_program
from symfric.model.scene import Scene
from symfric.solve.case_values import workers_of
from symfric.solve.program import check_tolerance


@dataclass(frozen=True, eq=False)
class Cases(Grid):
    """A list of cases as rows of numbers, in place of a grid of axes.

    Attributes
    ----------
    rows : ndarray, shape (n, number of parameters and starts)
    """

    rows: np.ndarray

    def numbers(self, cases: np.ndarray) -> np.ndarray:
        """Return the numbers of some cases."""
        return np.asarray(self.rows[cases])


class Listed:
    """A scene prepared to run lists of cases.

    Parameters
    ----------
    scene : Scene
        With scalar outputs.
    names : tuple of str
        Parameters that vary; names unknown to the scene are ignored.
    tolerance : float
    """

    def __init__(self, scene: Scene, names: tuple[str, ...] = (), tolerance: float = 1e-9):
        self._width = widths({"": scene})
        self._states = tuple(s.name for s in scene.system.states)
        self._names = tuple(s.name for s in scene.parameters if s.name in names)
        self._task = Task(scene, check_tolerance(tolerance), None, self._names, tuple(self._width.values()))
        self._program = make_program(self._task)

    def run(
        self,
        values: Mapping[str, np.ndarray],
        starts: np.ndarray | None = None,
        jobs: int = 1,
        progress: Callable[[float], None] | None = None,
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Run a list of cases.

        Parameters
        ----------
        values : mapping of parameter to ndarray (n,)
        starts : ndarray, shape (n_x, n), optional
            Initial states, in place of that of the scene.
        jobs : int
            Threads.
        progress : callable ``(fraction) -> None``, optional

        Returns
        -------
        status : ndarray of int, shape (n,)
            Codes of `Status`, -1 for values that are not valid, -2 for an error.
        outputs : dict of str to ndarray
            Of shape (n,), of `End` (n_x, n); NaN where a run failed.
        """
        columns = [*(np.asarray(values[n], dtype=float) for n in self._names), *([] if starts is None else starts)]
        n = columns[0].size if columns else 1
        task = self._task if starts is None else replace(self._task, starts=self._states)
        rows = np.column_stack(columns) if columns else np.zeros((1, 0))
        scene_of = np.zeros(n, dtype=int)
        cases = Cases({"case": np.arange(n)}, (task.scene,), scene_of, self._names, self._width, rows)
        results = Results(n, sum(self._width.values()))
        meter = Meter(None if progress is None else lambda p: progress(p.done / p.total), 0, n)
        run_on_threads(cases, lambda _scene: task, results, min(workers_of(jobs, "jobs"), n), meter, {0: self._program})
        ends = np.cumsum(list(self._width.values()))[:-1]
        blocks = zip(self._width, np.split(results.values.T, ends), strict=True)
        return results.status, {name: block[0] if len(block) == 1 else block for name, block in blocks}
