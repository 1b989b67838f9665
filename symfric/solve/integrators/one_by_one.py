"""Many cases of a program that runs them one by one."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

from symfric.model.scene import Scene
from symfric.model.symbols import Key
from symfric.solve.batch import Batch, batch_of_runs
from symfric.solve.case_values import read_cases, refuse_lists, workers_of
from symfric.solve.run import Run


class OneByOne(ABC):
    """What the programs of this route share: many cases are so many runs."""

    scene: Scene

    @abstractmethod
    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start; see `symfric.solve.program.Compiled.run`."""

    def map(
        self,
        values: Mapping[Key, Any] | None = None,
        initial: Mapping[Key, Any] | None = None,
        threads: int = 1,
        progress: Callable[[float], None] | None = None,
    ) -> Batch:
        """Run many cases, with their derivatives if there are any; see `symfric.solve.program.Compiled.map`."""
        refuse_lists(self.scene.outputs)
        return batch_of_runs(self.scene, self.run, read_cases(values, initial), workers_of(threads), progress)
