"""Outputs of a scene: only those listed are computed and stored.

An output of an expression defines the observable that a solver accumulates (`Row`) and how the output follows from it.
`reduce` does the latter for values and for derivatives, so that a new output is one class here and one public name.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.rows import CROSSINGS, INTEGRAL, RANGE, VALUES, Row
from symfric.model.symbols import expression, finite, legible, refuse_speed


@dataclass(frozen=True)
class Output:
    """Base of all outputs, the values of ``Scene.outputs``."""

    word: ClassVar[str] = ""  # its name in scene files
    keeps_path: ClassVar[bool] = False
    keeps_events: ClassVar[bool] = False
    scalar: ClassVar[bool] = False

    @property
    def latest(self) -> float:
        """The last time at which a run has to be for the output; 0 unless it is given times."""
        return 0.0

    @property
    def begins(self) -> float:
        """The time from which on the run counts; it has to go on after it."""
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

    @property
    def _root(self) -> bool:
        """Whether the expression is a root, which has no series where it is zero."""
        return bool(self.expr.is_Pow and self.expr.exp == sp.S.Half)

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

    def reduce(self, found: Any) -> Any:
        """Return the output from the accumulated observable, or its derivatives from those of the observable.

        Unless a class says otherwise, it is the observable itself.

        Parameters
        ----------
        found : pair, float or ndarray
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
        return found

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
    """Base of outputs that may leave out the begin of a run, such as a transient."""

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


@dataclass(frozen=True)
class OutputOfRange(OutputAfter):
    """Base of outputs made of the smallest and the largest value of an expression.

    Of a root, such as the length of a vector, the extremes are the roots of those of its radicand, which has a series
    where it is zero.
    """

    def row(self, horizon: float) -> Row:
        magnitude = isinstance(self.expr, sp.Abs)
        plain = self.expr.args[0] if magnitude or self._root else self.expr
        return Row(RANGE, plain, magnitude=magnitude, start=self.after)

    def _of_ends(self, low: Any, high: Any) -> Any:
        """Return the output from the smallest and the largest value, or its derivative from theirs.

        Parameters
        ----------
        low, high : float or ndarray

        Returns
        -------
        float or ndarray
        """
        raise NotImplementedError

    def reduce(self, found: Any) -> Any:
        return self._of_ends(*((np.maximum(e, 0.0) ** 0.5 for e in found) if self._root else found))

    def slopes(self, derivatives: Any, name: str) -> Any:
        slopes = derivatives.of_row(name)
        if self._root:
            with np.errstate(divide="ignore", invalid="ignore"):
                slopes = [d / (2.0 * e**0.5) for d, e in zip(slopes, derivatives.ends(name), strict=True)]
        return self._of_ends(*slopes)


@dataclass(frozen=True)
class End(Output):
    """The final state, shape (n_x,).

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> (sf.simulate(oscillator.wanting({"end": sf.End()}))["end"]).round(6)
    array([0.572119, 0.195591])
    """

    word: ClassVar[str] = "end"

    def size(self, n_x: int) -> int | None:
        return n_x

    def value(self, run: Any, name: str) -> Any:
        return run.final

    def slopes(self, derivatives: Any, name: str) -> Any:
        return derivatives.of_end()


@dataclass(frozen=True)
class Max(OutputOfRange):
    """Largest value of an expression over the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Max(x)}))["size"], 6)
    1.0
    """

    word: ClassVar[str] = "max"

    def _of_ends(self, low: Any, high: Any) -> Any:
        return high


@dataclass(frozen=True)
class Min(OutputOfRange):
    """Smallest value of an expression over the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Min(x)}))["size"], 6)
    -0.8
    """

    word: ClassVar[str] = "min"

    def _of_ends(self, low: Any, high: Any) -> Any:
        return low


@dataclass(frozen=True)
class HalfRange(OutputOfRange):
    """(largest - smallest) / 2 of an expression over the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.HalfRange(x)}))["size"], 6)
    0.9

    The amplitude of a vibration that has settled:

    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> x = belt.system.q[0]
    >>> round(sf.simulate(belt.wanting({"settled": sf.HalfRange(x, after=50)}))["settled"], 6)
    0.286209
    """

    word: ClassVar[str] = "half_range"

    def _of_ends(self, low: Any, high: Any) -> Any:
        return 0.5 * (high - low)


@dataclass(frozen=True)
class Integral(OutputOfExpression):
    """Integral of an expression over time.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Integral(x**2)}))["size"], 6)
    2.006043
    """

    word: ClassVar[str] = "integral"

    def row(self, horizon: float) -> Row:
        return Row(INTEGRAL, self.expr)


@dataclass(frozen=True)
class Mean(OutputAfter):
    """Mean of an expression over time, to the end of the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Notes
    -----
    ``integral of expr from after to T, / (T - after)`` with the horizon T.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Mean(x, after=2.0)}))["size"], 6)
    -0.29641
    """

    word: ClassVar[str] = "mean"

    def row(self, horizon: float) -> Row:
        return Row(INTEGRAL, self.expr / (horizon - self.after), start=self.after)


@dataclass(frozen=True)
class RMS(OutputAfter):
    """Root of the mean square of an expression over time, to the end of the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Notes
    -----
    ``sqrt(integral of expr**2 from after to T, / (T - after))`` with the horizon T.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.RMS(x, after=2.0)}))["size"], 6)
    0.53982
    """

    word: ClassVar[str] = "rms"

    def row(self, horizon: float) -> Row:
        return Row(INTEGRAL, self.expr**2 / (horizon - self.after), start=self.after)

    def reduce(self, found: Any) -> Any:
        return found**0.5

    def slopes(self, derivatives: Any, name: str) -> Any:
        return derivatives.of_row(name) / (2.0 * derivatives.integral(name) ** 0.5)

    def second_slopes(self, derivatives: Any, name: str, twice: Any) -> Any:
        size, slopes = derivatives.integral(name) ** 0.5, self.slopes(derivatives, name)
        products = np.array([slopes[a] * slopes[b] for a, b in derivatives.columns.pairs])
        return (0.5 * twice - products) / size


@dataclass(frozen=True)
class Period(OutputAfter):
    """Mean time between the instants at which an expression rises through zero; NaN if there are fewer than two.

    It is the period of a settled motion whose expression does so once in every period, such as the velocity of a
    stick-slip vibration, or ``x - level``. See `sf.limit_cycle` for the period of the limit cycle itself.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Notes
    -----
    ``(t_n - t_1) / (n - 1)`` with the first and the last of n instants at which the expression, negative before,
    becomes positive. They are roots of the polynomials of the steps, or instants at which the expression jumps.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> u = belt.system.u[0]
    >>> round(sf.simulate(belt.wanting({"T": sf.Period(u, after=50)}))["T"], 6)
    6.799421
    >>> round(sf.limit_cycle(belt).period, 6)
    6.799421
    """

    word: ClassVar[str] = "period"

    def row(self, horizon: float) -> Row:
        return Row(CROSSINGS, self.expr, start=self.after)

    def reduce(self, found: Any) -> Any:
        first, last, count = found
        return (last - first) / np.where(np.asarray(count) > 1.0, count - 1.0, np.nan)

    def value(self, run: Any, name: str) -> Any:
        period = super().value(run, name)
        return period if period.ndim else float(period)


@dataclass(frozen=True)
class At(OutputOfExpression):
    """Value of an expression at a time, or at the end of the run; NaN if the run fails before.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    time : float or None
        Not after the horizon of the scene; its end unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(float(sf.simulate(oscillator.wanting({"size": sf.At(x, 2.0)}))["size"]), 6)
    -0.274532
    """

    word: ClassVar[str] = "at"
    time: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.time is not None:
            object.__setattr__(self, "time", finite(self.time, "the time of At"))
            if self.time < 0:
                raise SceneError(f"the time of At is {self.time:g}; it must not be negative")

    @property
    def latest(self) -> float:
        """Its time, 0 if that is the end of the run."""
        return self.time or 0.0

    def row(self, horizon: float) -> Row:
        taken = self.expr.args[0] if self._root else self.expr
        return Row(VALUES, taken, (horizon if self.time is None else min(self.time, horizon),))

    def reduce(self, found: Any) -> Any:
        return np.maximum(found[0], 0.0) ** 0.5 if self._root else found[0]

    def slopes(self, derivatives: Any, name: str) -> Any:
        slopes = derivatives.of_row(name)[0]
        if not self._root:
            return slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            return slopes / (2.0 * derivatives.values(name)[0] ** 0.5)

    def second_slopes(self, derivatives: Any, name: str, twice: Any) -> Any:
        if not self._root:
            return twice[0]
        size, slopes = derivatives.values(name)[0] ** 0.5, self.slopes(derivatives, name)
        products = np.array([slopes[a] * slopes[b] for a, b in derivatives.columns.pairs])
        with np.errstate(divide="ignore", invalid="ignore"):
            return (0.5 * twice[0] - products) / size


@dataclass(frozen=True)
class Samples(OutputOfExpression):
    """Values of an expression at given times, shape (n_t,), like the samples of a sensor.

    Parameters
    ----------
    expr : Expr
        Of states, time and parameters.
    times : sequence of float
        Increasing, not negative and not after the horizon of the scene; the values at those that a failed run does not
        reach are NaN.

    Raises
    ------
    SceneError
        If the times are none, or not in their order.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=3.0)
    >>> (x,) = scene.system.q
    >>> run = sf.simulate(scene.wanting({"x": sf.Samples(x, [0.0, 1.5, 3.0])}))
    >>> run["x"].round(6)
    array([ 1.      ,  0.163663, -0.790993])
    """

    word: ClassVar[str] = "samples"
    times: Sequence[float] | np.ndarray = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        try:
            times = tuple(finite(t, "a time of Samples") for t in np.atleast_1d(np.array(self.times, dtype=float)))
        except (TypeError, ValueError) as error:
            raise SceneError(f"the times of Samples are not a sequence of numbers: {error}") from None
        if not times:
            raise SceneError("the times of Samples are empty; give at least one")
        if times[0] < 0 or any(b <= a for a, b in pairwise(times)):
            raise SceneError("the times of Samples must increase and not be negative")
        object.__setattr__(self, "times", times)

    @property
    def latest(self) -> float:
        """The last of its times."""
        return self.times[-1]

    def row(self, horizon: float) -> Row:
        return Row(VALUES, self.expr, (*self.times[:-1], min(self.times[-1], horizon)))

    def size(self, n_x: int) -> int | None:
        return len(self.times)


@dataclass(frozen=True)
class StopTime(Output):
    """Time after which the system stays at rest until the horizon; NaN if it moves at the end, or the run fails.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0)
    >>> round(sf.simulate(oscillator.wanting({"rest": sf.StopTime()}))["rest"], 6)
    15.707963
    """

    word: ClassVar[str] = "stop_time"
    scalar: ClassVar[bool] = True

    def value(self, run: Any, name: str) -> Any:
        return run.raw.rest

    def slopes(self, derivatives: Any, name: str) -> Any:
        return derivatives.of_rest()


@dataclass(frozen=True)
class Trajectory(Output):
    """The trajectory: states, modes, events and dense output.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> run = sf.simulate(oscillator.wanting({"path": sf.Trajectory()}))
    >>> run.names
    ('x', 'u')
    >>> run(2.0).round(6)
    array([-0.274532, -0.818368])
    """

    word: ClassVar[str] = "trajectory"
    keeps_path: ClassVar[bool] = True
    keeps_events: ClassVar[bool] = True

    def value(self, run: Any, name: str) -> Any:
        return run.raw.path


@dataclass(frozen=True)
class Events(Output):
    """The list of events, without the trajectory between them.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0)
    >>> run = sf.simulate(oscillator.wanting({"events": sf.Events()}))
    >>> [e.kind for e in run["events"]]
    ['reverse', 'reverse', 'reverse', 'reverse', 'stick']
    """

    word: ClassVar[str] = "events"
    keeps_events: ClassVar[bool] = True

    def value(self, run: Any, name: str) -> Any:
        return run.events


def words(of: type[Output] = Output) -> dict[str, type[Output]]:
    """Return the output classes by their names in scene files."""
    found: dict[str, type[Output]] = {}
    kinds: Sequence[type[Output]] = of.__subclasses__()
    for kind in kinds:
        found |= {kind.word: kind} if kind.word else {}
        found |= words(kind)
    return found


def friction_force(contact: str, component: int | None = None) -> sp.Symbol:
    """Return the friction force of a contact (on the body, along its slip) for use inside output expressions.

    Parameters
    ----------
    contact : str
        Its name.
    component : {0, 1}, optional
        Of the force of a contact in the plane, along the first or the second of its slips.

    Returns
    -------
    Symbol

    Raises
    ------
    SceneError
        If the component is neither 0 nor 1.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> v_b = belt.parameter("v_b")
    >>> run = sf.simulate(belt.wanting({"work": sf.Integral(sf.friction_force("belt") * v_b)}))
    >>> round(run["work"], 6)
    5.793097
    """
    if component not in (None, 0, 1):
        raise SceneError(f"the component of a friction force is {component!r}; in the plane there are 0 and 1")
    return sp.Symbol(f"friction_force({contact}{'' if component is None else f', {component}'})", real=True)


def slip(contact: str) -> sp.Symbol:
    """Return the slip velocity of a contact for use inside output expressions; in the plane the speed, zero in flight.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.simulate(belt.wanting({"fastest": sf.Max(sf.slip("belt"))}))["fastest"], 6)
    0.0
    """
    return sp.Symbol(f"slip({contact})", real=True)


def normal_force(contact: str) -> sp.Symbol:
    """Return the normal force of a contact, for use inside output expressions.

    That of a contact that opens may also stand in forces, loads and profiles, such as the load of another contact;
    they must be linear in it.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol

    Notes
    -----
    That of a contact that opens is the force between impacts. Over the last bounces of a body that comes to rest, which
    are lower than the tolerance, it is that of the closed contact: an integral of it is right to the root of the
    tolerance only.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> y, v = sp.symbols("y v", real=True)
    >>> block = sf.Scene(
    ...     system=sf.System(q=[y], u=[v], mass=[[2]], force=[-20 - sp.sin(sf.TIME)]),
    ...     contacts=[sf.Contact("floor", slip=None, normal=sf.Unilateral(y))],
    ...     initial={y: 0.0, v: 0.0},
    ...     horizon=3.0,
    ...     outputs={"largest": sf.Max(sf.normal_force("floor"))},
    ... )
    >>> round(sf.simulate(block)["largest"], 9)
    21.0
    """
    return sp.Symbol(f"normal_force({contact})", nonnegative=True)


def stored_energy(contact: str) -> sp.Symbol:
    """Return the energy stored in a contact, for use inside output expressions; zero unless its law has memory.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol
        Normal load times ``law.memory.stored``: force times length.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.stored_energy("belt")
    stored_energy(belt)
    """
    return sp.Symbol(f"stored_energy({contact})", real=True)


def dissipated_power(contact: str) -> sp.Symbol:
    """Return the power that becomes heat in a contact, for use inside output expressions.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol
        Power of the slip against friction less what the contact stores at the present load: force times velocity.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.Integral(sf.dissipated_power("belt"))
    Integral(expr=dissipated_power(belt))
    """
    return sp.Symbol(f"dissipated_power({contact})", real=True)


OF_CONTACTS = {f.__name__: f for f in (friction_force, slip, normal_force, stored_energy, dissipated_power)}


def read_outputs(outputs: Mapping[str, Output] | None) -> dict[str, Output]:
    """Return the outputs of a scene, the trajectory unless any are given; raise on what is none."""
    if outputs is None:
        return {"path": Trajectory()}
    if not isinstance(outputs, Mapping):
        raise SceneError(f"outputs is {outputs!r}; give a mapping of names to sf.End(), sf.Max(x), ...")
    for name, output in outputs.items():
        if not isinstance(name, str):
            raise SceneError(f"{name!r} is not the name of an output; use a string")
        legible(name, "an output")
        if not isinstance(output, Output):
            raise SceneError(f"output {name!r} is {output!r}; use sf.End(), sf.Max(x), ... with its brackets")
    return dict(outputs)
