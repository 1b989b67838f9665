"""What a route and a prepared program are."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.symbols import Key, name_of
from symfric.solve.batch import Batch, batch_of_runs
from symfric.solve.case_values import CaseValues, read_cases, refuse_lists, workers_of
from symfric.solve.lowered import LoweredScene
from symfric.solve.run import Run


@dataclass(frozen=True)
class Answer:
    """Answer of a route: whether it takes a scene, and why.

    Attributes
    ----------
    takes : bool
    preferred : bool
        Whether no other route that takes the scene is faster by itself; of several, the first in the list is chosen.
    words : str
        The reason.
    """

    takes: bool
    preferred: bool
    words: str


class Route(ABC):
    """Settings of one solver, with the methods that check and compile a scene for it, with its derivatives or without.

    Attributes
    ----------
    name : str
        In `prepare` and scene files.
    """

    name: ClassVar[str]

    @abstractmethod
    def declines(self, scene: LoweredScene) -> str:
        """Return why this route does not take a scene with the derivatives asked for; empty if it takes it.

        Parameters
        ----------
        scene : LoweredScene

        Returns
        -------
        str

        Examples
        --------
        >>> import symfric as sf
        >>> from symfric.solve.lowered import LoweredScene
        >>> sf.Exact().declines(LoweredScene(sf.scenes.mass_on_belt(v_b=0.2)))
        "the friction law is not made of straight lines (contact 'belt')"
        """

    def answer(self, scene: LoweredScene) -> Answer:
        """Return whether this route takes a scene, whether it is the fastest, and why.

        Parameters
        ----------
        scene : LoweredScene

        Returns
        -------
        Answer

        Examples
        --------
        >>> import symfric as sf
        >>> from symfric.solve.lowered import LoweredScene
        >>> lowered = LoweredScene(sf.scenes.coulomb_oscillator(0.1))
        >>> [route.answer(lowered).takes for route in (sf.Exact(), sf.Taylor(), sf.Integrators())]
        [True, True, True]
        """
        refusal = self.declines(scene)
        return Answer(False, False, refusal) if refusal else Answer(True, *self._merits(scene))

    @abstractmethod
    def _merits(self, scene: LoweredScene) -> tuple[bool, str]:
        """Return `preferred` and `words` for a scene that the route takes."""

    @abstractmethod
    def build(self, scene: LoweredScene, tolerance: float) -> "Program":
        """Compile a scene that the route takes, with the derivatives asked for.

        Parameters
        ----------
        scene : LoweredScene
        tolerance : float
            See `sf.prepare`.

        Returns
        -------
        Program

        Raises
        ------
        NoRoute
            If this route cannot take the scene.

        Examples
        --------
        >>> import symfric as sf
        >>> from symfric.solve.lowered import LoweredScene
        >>> lowered = LoweredScene(sf.scenes.coulomb_oscillator(0.1))
        >>> [route.build(lowered, 1e-9).run().status.name for route in (sf.Exact(), sf.Taylor(), sf.Integrators())]
        ['OK', 'OK', 'OK']
        """


class Program(ABC):
    """A scene compiled by a route, which can be run many times, from any thread.

    Attributes
    ----------
    scene : Scene
    tolerance : float
    settings : Route
    directions : tuple of str
        Parameters, and states for their initial values, by which runs are differentiated.
    varied : frozenset of str
        Parameters that are free although their values could be built in.
    built_in : dict of str to float
        Parameters that the equations contain as numbers.
    wider : dict of frozenset of str to Program
        Programs with some of these parameters free, compiled when first needed.
    """

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: Route):
        self.scene, self.tolerance, self.settings = lowered.scene, tolerance, settings
        self.directions, self.varied, self._derivative_order = lowered.directions, lowered.varied, lowered.order
        self.built_in = lowered.built_in
        self.wider: dict[frozenset[str], Program] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as what it was made of; machine code is compiled or loaded when unpickled."""
        made_of = self.scene, self.varied, self.directions, self._derivative_order
        return _build, (self.settings, self.tolerance, *made_of)

    def widened(self, values: Mapping[Key, float]) -> "Program | None":
        """Return a program in which the parameters named in `values` are free, or None if they are free in this one.

        It is prepared once and kept, one for every set of names that were built in, so that a run does not depend on
        the runs before it.
        """
        built_in = self.built_in
        for key, value in values.items():
            name = name_of(key)
            if name in built_in and built_in[name] != value:
                break
        else:
            return None
        names = frozenset(map(name_of, values)).intersection(built_in)
        if names not in self.wider:
            with SYMBOLIC:
                if names not in self.wider:
                    made_of = self.scene, self.varied | names, self.directions, self._derivative_order
                    self.wider[names] = self._rebuilt(LoweredScene(*made_of))
        return self.wider[names]

    def _rebuilt(self, lowered: LoweredScene) -> "Program":
        """Return the program of the same scene with more of its parameters free."""
        return self.settings.build(lowered, self.tolerance)

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start.

        Parameters
        ----------
        values, initial : mapping of symbol or name to number
            Changes to the scene's own. The first change of a parameter that was zero, or that a law's mean over fast
            vibration contains, compiles again, for all values of it.
        progress : callable, optional
            Called with the completed fraction of the horizon, about once per million steps.

        Returns
        -------
        Run
        """
        wider = self.widened(values) if values else None
        if wider is not None:
            return wider.run(values, initial, progress)
        return self._run(dict(values or {}), dict(initial or {}), progress)

    @abstractmethod
    def _run(
        self, values: dict[Key, float], initial: dict[Key, float], progress: Callable[[float], None] | None
    ) -> Run:
        """Run with values that differ from none of those that are built in."""

    @logged
    def map(
        self,
        values: Mapping[Key, Any] | None = None,
        initial: Mapping[Key, Any] | None = None,
        threads: int = 1,
        progress: Callable[[float], None] | None = None,
    ) -> Batch:
        """Run many cases, where the route can in compiled code, with arrays of values and arrays of results.

        Parameters
        ----------
        values, initial : mapping of symbol or name to a number or a row (n,)
            Changes to the scene's own; a number holds for all cases.
        threads : int
            How many share the cases; -1 for as many as there are processors.
        progress : callable, optional
            Called now and then with the fraction done, in this thread.

        Returns
        -------
        Batch
            In the order of the cases. A case has the bits of ``run`` with its numbers, whatever the other cases, their
            order and the threads; one that fails has its status and NaN. A program that was prepared with
            `sensitivities` adds the derivatives.

        Raises
        ------
        SceneError
            If the scene wants a trajectory or a list of events, a name is unknown, rows have different lengths, or
            something is no finite number.

        Examples
        --------
        >>> import numpy as np
        >>> import symfric as sf
        >>> scene = sf.scenes.coulomb_oscillator(0.1)
        >>> (x,) = scene.system.q
        >>> program = sf.prepare(scene.wanting({"stop": sf.StopTime(), "least": sf.Min(x)}))
        >>> batch = program.map({"delta": np.array([0.02, 0.05, 0.1])})
        >>> batch["least"].round(6)
        array([-0.96, -0.9 , -0.8 ])
        """
        refuse_lists(self.scene.outputs)
        return self._map(read_cases(values, initial), workers_of(threads), progress)

    def _map(self, cases: CaseValues, threads: int, progress: Callable[[float], None] | None) -> Batch:
        """Run cases one by one, unless the route knows better."""
        return batch_of_runs(self.scene, self.run, cases, threads, progress)


@alone(SYMBOLIC)
def _build(settings: Route, tolerance: float, *made_of: Any) -> Program:
    """Build a pickled program again."""
    return settings.build(LoweredScene(*made_of), tolerance)
