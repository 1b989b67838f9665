"""What an output is: its place in a scene file, the observable that a run accumulates, and the value made of it.

An output of an expression states its observable (`Row`) and `reduce`, which turns the accumulated observable, or its
derivatives, into the value, or its derivatives.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import sympy as sp

from symfric.errors import SceneError
from symfric.model.rows import Row
from symfric.model.symbols import expression, finite, refuse_speed


@dataclass(frozen=True)
class Output:
    """Base of all outputs, the values of ``Scene.outputs``."""

    word: ClassVar[str] = ""  # its name in scene files
    keeps_path: ClassVar[bool] = False
    keeps_events: ClassVar[bool] = False
    scalar: ClassVar[bool] = False

    @property
    def latest(self) -> float:
        """Latest time at which the output needs the motion; 0 unless it has times of its own."""
        return 0.0

    @property
    def begins(self) -> float:
        """Time from which the output is accumulated, before the end of the run."""
        return 0.0

    def size(self, n_x: int) -> int | None:
        """Return how many numbers the output has.

        Parameters
        ----------
        n_x : int
            Number of states.

        Returns
        -------
        int or None
            None if the output is not numeric.

        Examples
        --------
        >>> import symfric as sf
        >>> sf.End().size(2), sf.StopTime().size(2), sf.Trajectory().size(2)
        (2, 1, None)
        """
        return 1 if self.scalar else None

    def value(self, run: Any, name: str) -> Any:
        """Return the output from a run that stored it.

        Parameters
        ----------
        run : Run
        name : str
            Under which the scene lists it.

        Returns
        -------
        float, ndarray or object

        Examples
        --------
        >>> import symfric as sf
        >>> run = sf.simulate(sf.scenes.coulomb_oscillator(0.1).wanting({"rest": sf.StopTime()}))
        >>> round(sf.StopTime().value(run, "rest"), 6) == round(run["rest"], 6)
        True
        """
        raise NotImplementedError

    def slopes(self, derivatives: Any, name: str) -> Any:
        """Return the derivatives of the output.

        Parameters
        ----------
        derivatives : Derivatives
            Of a run, see `symfric.solve.sensitivities`.
        name : str
            Under which the scene lists the output.

        Returns
        -------
        ndarray
            One column for each parameter or initial value; users find them in ``run.output_sensitivities``.

        Examples
        --------
        >>> import symfric as sf
        >>> scene = sf.scenes.coulomb_oscillator(0.1).wanting({"rest": sf.StopTime()})
        >>> run = sf.simulate(scene, sensitivities=["omega_n"])
        >>> round(float(run.output_sensitivities["rest"]["omega_n"]), 6) == round(-run["rest"], 6)
        True
        """
        raise NotImplementedError


@dataclass(frozen=True)
class OutputOfExpression(Output):
    """Base of outputs that reduce one expression of states, time and parameters along the run."""

    expr: sp.Expr
    scalar: ClassVar[bool] = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "expr", expression(self.expr, f"the expression of {type(self).__name__}"))
        refuse_speed(self.expr, f"the expression of {type(self).__name__}")

    def row(self, horizon: float) -> Row:
        """Return the observable to accumulate in a run.

        Parameters
        ----------
        horizon : float
            Up to which the run goes.

        Returns
        -------
        Row

        Examples
        --------
        >>> import symfric as sf
        >>> sf.Integral(sf.TIME**2).row(10.0).expr
        t**2
        """
        raise NotImplementedError

    def reduce(self, observable: Any) -> Any:
        """Return the output from the accumulated observable, or its derivatives from those of the observable.

        Unless a class says otherwise, it is the observable itself.

        Parameters
        ----------
        observable : pair, float or ndarray
            Smallest and largest value, an integral, or values with the times first.

        Returns
        -------
        float or ndarray

        Examples
        --------
        >>> import symfric as sf
        >>> sf.HalfRange(sf.TIME).reduce((1.0, 5.0))
        2.0
        """
        return observable

    def value(self, run: Any, name: str) -> Any:
        return self.reduce(run.raw.rows[name])

    def slopes(self, derivatives: Any, name: str) -> Any:
        return self.reduce(derivatives.of_row(name))

    def second_slopes(self, derivatives: Any, name: str, twice: Any) -> Any:
        """Return the second derivatives of the output from those of its observable.

        Parameters
        ----------
        derivatives : Derivatives
            Of a run, see `symfric.solve.sensitivities`.
        name : str
            Under which the scene lists the output.
        twice : ndarray
            One column for each pair of directions.

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import symfric as sf
        >>> scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=0.5)
        >>> x = scene.system.q[0]
        >>> run = sf.prepare(scene.wanting({"r": sf.RMS(x)}), sensitivities=["x"], order=2).run()
        >>> list(run.second_output_sensitivities["r"])
        [('x', 'x')]
        """
        return self.reduce(twice)


@dataclass(frozen=True)
class OutputAfter(OutputOfExpression):
    """Base of outputs that may leave out the start of a run, such as a transient."""

    after: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "after", finite(self.after, f"after of {type(self).__name__}"))
        if self.after < 0:
            raise SceneError(f"after of {type(self).__name__} is {self.after:g}; it must not be negative")

    @property
    def begins(self) -> float:
        """Its `after`."""
        return self.after
