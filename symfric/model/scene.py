"""A scene: system, contacts, parameter values, initial state, horizon and outputs of one simulation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.contact_states import with_states, without_states
from symfric.model.gaps import check_gaps
from symfric.model.held import Held, in_order
from symfric.model.in_plane import refuse_planes
from symfric.model.laws.law import Shape
from symfric.model.outputs import Output, OutputOfExpression, read_outputs
from symfric.model.quantities import is_quantity, number_of, without_units
from symfric.model.resets import Reset, check_order, check_resets
from symfric.model.scene_reading import Parts, by_name, check_output_symbols, read_initial, read_values
from symfric.model.symbols import TIME, Key, counted, finite, listed, mapped, name_of, nearest, shortened
from symfric.model.system import Contact, Signal, System
from symfric.model.units import Units, check_outputs, units_of
from symfric.model.validation import check_contacts, check_continuous, check_start, check_times
from symfric.model.written_equations import equations_of, latex_of
from symfric.spelling import spelt

if TYPE_CHECKING:
    from symfric.report.study.study import Study

_NOTHING: Mapping[Any, Any] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Scene:
    """A simulation problem: system, contacts, values, initial state, horizon and outputs; independent of the solver.

    Parameters
    ----------
    system : System
    contacts : sequence of Contact
    values : mapping of parameter (symbol or name) to number
        Every parameter of every expression, and no others. None marks a value to be given later with `where`.
    initial : mapping of state to number or expression of parameters
        Every state in ``x = [q; u; z]``; those of contacts with memory are zero unless given.
    horizon : float
        Length of the run, in units of time; it starts at t = 0.
    outputs : mapping of name to Output, optional
        Results to compute; ``{"path": Trajectory()}`` unless given.
    inputs : mapping of symbol to Signal
        Sampled inputs.
    units : mapping of symbol or name to str, optional
        Units of states, parameters, inputs and "t" for time, such as ``{"x": "m", "k": "N/m"}``; those not given follow
        from the equations as far as they do. The numbers are used as they stand. Values, initial values and the horizon
        may be quantities of pint, which are converted to the units given, or bring their own.
    held : sequence of Held, optional
        Variables that change at sampling instants, or where an expression crosses zero, only; each is a state under its
        name. Only the route 'taylor' takes them, and resets.
    resets : sequence of Reset, optional
        Changes of states at known times, or where an expression falls through zero.

    Attributes
    ----------
    system, contacts, values, initial, horizon, outputs, inputs, units, held, resets
        The arguments, normalised: contacts as a tuple, held variables in the order of their dependence, numbers as
        floats, and values, initial and inputs keyed by the symbols of the expressions. Contacts with memory add their
        states to the system, ``<contact>.z``, and held variables theirs: ``<name>``, ``<name>.queue1``, and with `when`
        ``<name>.left1``. `units` are
        the texts by name, "" for plain numbers and empty for a scene without units; ``units.of(expr)`` is that of an
        expression.

    Raises
    ------
    SceneError
        If anything is missing, unused, misspelled, not finite or out of range; it names the thing and the cure.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> k, v_b = sp.symbols("k v_b", positive=True)
    >>> scene = sf.Scene(
    ...     system=sf.System(q=[x], u=[u], mass=[[1]], force=[-k * x]),
    ...     contacts=[sf.Contact("belt", slip=u - v_b, normal=1, law=sf.laws.coulomb(0.4, 0.3))],
    ...     values={k: 1.0, v_b: 0.2},
    ...     initial={x: 0.0, u: 0.0},
    ...     horizon=10.0,
    ...     outputs={"x_max": sf.Max(x)},
    ... )
    >>> faster = scene.where({"v_b": 0.3}).starting({"x": 0.1}).until(20.0).wanting({"end": sf.End()})
    >>> faster
    Scene(1 coordinate, contacts: belt; k=1, v_b=0.3; horizon 20)
    >>> scene.equations()[1]
    Eq(Derivative(u(t), t), -k*x(t) - 0.3*sign(-v_b + u(t)))
    >>> scene.regularised(1e-3).contacts[0].law.smooth
    True
    >>> scene.parameter("k"), sorted(s.name for s in scene.parameter_values()), len(scene.numbers())
    (k, ['k', 'v_b'], 4)
    >>> scene.written_out() is scene
    True
    >>> measured = sf.Scene(
    ...     scene.system, scene.contacts, scene.values, scene.initial, 10.0, units={"x": "mm", "t": "s", "k": "N/mm"}
    ... )
    >>> measured.units["v_b"], measured.units.of(k * x)
    ('mm/s', 'N')
    """

    system: System
    contacts: tuple[Contact, ...]
    values: Mapping[sp.Symbol, float | None]
    initial: Mapping[sp.Symbol, float | sp.Expr]
    horizon: float
    outputs: Mapping[str, Output]
    inputs: Mapping[sp.Symbol, Signal]
    units: Units
    held: tuple[Held, ...]
    resets: tuple[Reset, ...]

    @alone(SYMBOLIC)
    def __init__(
        self,
        system: System,
        contacts: Sequence[Contact] = (),
        values: Mapping[Key, float | None] = _NOTHING,
        initial: Mapping[Key, float | sp.Expr] = _NOTHING,
        horizon: float = 0.0,
        outputs: Mapping[str, Output] | None = None,
        inputs: Mapping[Key, Signal] = _NOTHING,
        units: Mapping[Key, str] = _NOTHING,
        held: Sequence[Held] = (),
        resets: Sequence[Reset] = (),
    ):
        """Check and normalise the arguments: keys become the symbols of the expressions, numbers become floats."""
        if not isinstance(system, System):
            raise SceneError(f"system is {shortened(system)}; give a sf.System")
        self._set("contacts", listed(contacts, "contacts"))
        for c in self.contacts:
            if not isinstance(c, Contact):
                raise SceneError(f"{shortened(c)} in contacts is no sf.Contact")
        check_contacts(without_states(system), self.contacts)
        texts = dict(by_name(units, "units"))
        for given, what in ((values, "values"), (initial, "initial"), (inputs, "inputs")):
            mapped(given, what, f"{what}={{name: ...}}")
        values, initial = without_units(values, texts), without_units(initial, texts)
        self._set("held", tuple(h.with_places(values) for h in in_order(held)))
        self._set("system", with_states(system, self.contacts, self.held))
        self._set("resets", check_resets(resets, {s.name for s in self.system.states}))
        length = finite(number_of(horizon, TIME.name, texts) if is_quantity(horizon) else horizon, "horizon")
        if length <= 0:
            raise SceneError(f"horizon is {length}; it must be positive")
        self._set("horizon", length)
        self._set("outputs", read_outputs(outputs))
        check_output_symbols(self._parts)
        check_times(self.outputs, length)
        numbers, signals = read_values(self._parts, values, initial, inputs)
        self._set("values", numbers)
        self._set("inputs", signals)
        self._set("initial", read_initial(self._parts, initial, numbers))
        self._set("units", units if isinstance(units, Units) and len(texts) == len(units) else units_of(self, texts))
        if None not in self.values.values():
            self._check_numbers()

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)  # assignment in a frozen class

    @property
    def _parts(self) -> Parts:
        return Parts(self.system, self.contacts, self.held, self.resets, self.outputs)

    def _check_numbers(self) -> None:
        numbers = self.numbers()
        for what, e in self._parts.named_expressions():
            check_continuous(e, {k: v for k, v in numbers.items() if k not in self.initial}, what)
        if self.system.linear:
            states, n = [numbers[s] for s in self.system.states], len(self.system.q)
            numbers |= self.system.linear.values(states[:n], states[n : 2 * n])
        start = {**numbers, TIME: 0.0, **{k: float(s(0.0)) for k, s in self.inputs.items()}}
        check_gaps(self.system, self.contacts, start, self.horizon)
        check_start(self.system, self.contacts, start, self.horizon)
        check_order(self.clocks, numbers)

    @alone(SYMBOLIC)
    def numbers(self) -> dict[sp.Symbol, float]:
        """Return every parameter and every initial state as a number; raise if a value is still to be given.

        Returns
        -------
        dict[Symbol, float]
        """
        numbers = self.parameter_values()
        for state, value in self.initial.items():
            number = value if isinstance(value, float) else value.subs(self.values)
            numbers[state] = finite(number, f"the initial value of {state.name}")
        return numbers

    def parameter_values(self) -> dict[sp.Symbol, float]:
        """Return every parameter as a number; raise if a value is still to be given.

        Returns
        -------
        dict[Symbol, float]

        Raises
        ------
        SceneError
            If a parameter has no value.
        """
        numbers = {k: v for k, v in self.values.items() if v is not None}
        missing = next((k for k in self.values if k not in numbers), None)
        if missing is not None:
            raise SceneError(
                f"no value for {missing.name}; add it to Scene.values, or scene.where({{'{missing.name}': ...}})"
            )
        return numbers

    @property
    def clocks(self) -> tuple[Held | Reset, ...]:
        """Held variables and resets."""
        return self._parts.clocks

    @property
    def timed(self) -> tuple[Held | Reset, ...]:
        """Those that act at known times; the others act where an expression crosses zero."""
        return tuple(part for part in self.clocks if part.crossing is None)

    @property
    def clocked(self) -> tuple[sp.Expr, ...]:
        """Every expression of held variables and resets, without previous values."""
        return self._parts.clocked

    @property
    def contacts_behind_springs(self) -> tuple[Contact, ...]:
        """Contacts with a stiffness, or with a law of sliders behind springs."""
        return tuple(c for c in self.contacts if not c.along_line and not c.frictionless)

    @property
    def contacts_that_open(self) -> tuple[Contact, ...]:
        """Contacts with a unilateral normal direction."""
        return tuple(c for c in self.contacts if c.unilateral is not None)

    @property
    def parameters(self) -> tuple[sp.Symbol, ...]:
        """Parameters in the order of `values`."""
        return tuple(self.values)

    def parameter(self, key: Key) -> sp.Symbol:
        """Return the parameter's symbol for a symbol or name; raise with the nearest known name.

        Parameters
        ----------
        key : symbol or name
            Of a parameter.

        Returns
        -------
        Symbol

        Raises
        ------
        SceneError
            If the scene has no such parameter.
        """
        name = name_of(key)
        for s in self.values:
            if s.name == name:
                return s
        raise SceneError(f"{name} is no parameter of the scene{nearest(name, [s.name for s in self.values])}")

    @spelt
    def where(self, values: Mapping[Key, float]) -> "Scene":
        """Return the scene with other numbers for some of its parameters.

        Parameters
        ----------
        values : mapping of symbol or name to number

        Returns
        -------
        Scene
        """
        changed = {self.parameter(k): v for k, v in self._plain(values).items()}
        return replace(self, values={**self.values, **changed})

    @spelt
    def starting(self, initial: Mapping[Key, float | sp.Expr]) -> "Scene":
        """Return the scene with other initial values of some of its states.

        Parameters
        ----------
        initial : mapping of symbol or name to number or Expr
            Of states; the others keep theirs.

        Returns
        -------
        Scene
        """
        start = by_name(self.initial, "initial") | by_name(self._plain(initial), "initial")
        return replace(self, initial=start, values=self._used_values(self._parts, start))

    @spelt
    def until(self, horizon: float, outputs: Mapping[str, Output] | None = None) -> "Scene":
        """Return the scene with another horizon.

        Parameters
        ----------
        horizon : float
            Length of the run.
        outputs : mapping of str to Output, optional
            Replaces the present outputs, whose times may be later than the new horizon; see `wanting`.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            If the horizon is not positive, or earlier than the time of an output.
        """
        (length,) = self._plain({TIME: horizon}).values()
        return self._with_outputs(self.outputs if outputs is None else read_outputs(outputs), length)

    def _plain(self, given: Mapping[Any, Any]) -> Mapping[Any, Any]:
        """Return values as numbers in the units of the scene; raise if it does not say in which."""
        for key, value in mapped(given, "values", "{'name': 1.0}").items():
            if is_quantity(value) and name_of(key) not in self.units:
                raise SceneError(
                    f"{name_of(key)} is {value}, and the scene does not say in which unit; give Scene.units"
                )
        return without_units(given, dict(self.units))

    @spelt
    def wanting(self, outputs: Mapping[str, Output]) -> "Scene":
        """Return the scene with other outputs.

        Parameters
        ----------
        outputs : mapping of str to Output
            What is to be computed; replaces the present outputs.

        Returns
        -------
        Scene
        """
        return self._with_outputs(read_outputs(outputs), self.horizon)

    def _with_outputs(self, outputs: Mapping[str, Output], horizon: float) -> "Scene":
        if outputs is self.outputs:
            return replace(self, horizon=horizon)
        check_outputs(self.units, outputs)
        used = self._used_values(replace(self._parts, outputs=outputs), self.initial)
        return replace(self, outputs=outputs, horizon=horizon, values=used)

    def _used_values(self, parts: Parts, initial: Mapping[Any, Any]) -> dict[sp.Symbol, float | None]:
        """Return the values that are still used with other parts or another start."""
        used = parts.symbols(initial)
        return {s: v for s, v in self.values.items() if s in used}

    @alone(SYMBOLIC)
    def written_out(self) -> "Scene":
        """Return the scene with expressions in place of matrices and rows, for closed forms; itself if it has none.

        Returns
        -------
        Scene
        """
        if self.system.linear is None:
            return self
        rows = self.system.row_values()
        contacts = tuple(c.rewritten(lambda e: e.xreplace(rows)) for c in self.contacts)
        read = {n: o for n, o in self.outputs.items() if isinstance(o, OutputOfExpression)}
        outputs = {**self.outputs, **{n: replace(o, expr=o.expr.xreplace(rows)) for n, o in read.items()}}
        return replace(self, system=self.system.written_out(), contacts=contacts, outputs=outputs)

    @alone(SYMBOLIC)
    def regularised(self, v_s: float | sp.Expr, shape: Shape = "linear") -> "Scene":
        """Return the scene with every contact's law made continuous; see `Law.regularised`.

        Parameters
        ----------
        v_s : float or Expr
            Speed below which a contact counts as sticking, > 0.
        shape : {"linear", "arctan", "tanh"}
            See `sf.Law`.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            If a contact is behind a spring: its law has no jump, its force follows from the spring. If one opens, or
            slides in the plane.
        """
        for c in (c for c in self.contacts if c.stiffness is not None):
            raise SceneError(
                f"contact {c.name!r} is behind a spring, whose force is continuous; there is no law to smooth"
            )
        for c in self.contacts_that_open:
            raise SceneError(
                f"contact {c.name!r} opens; a regularised law does not define friction in an impact, and its normal "
                "direction has none"
            )
        refuse_planes(self.contacts, "a regularised law")
        contacts = tuple(replace(c, law=c.law.regularised(v_s, shape)) for c in self.contacts)
        used = self._used_values(replace(self._parts, contacts=contacts), self.initial)
        return replace(self, contacts=contacts, values=used)

    @alone(SYMBOLIC)
    def equations(self) -> tuple[sp.Eq, ...]:
        """Return the equations of motion for reading, friction as ``sign(slip) * normal * mu(|slip|)``.

        Returns
        -------
        tuple[Equality, ...]
        """
        return equations_of(self.written_out())

    def study(self, progress: Callable[[str, float], None] | None = None) -> "Study":
        """Return what the page of a study holds: stability, onset, motion, amplitudes, designs.

        A scene that `sf.read` read from a file is studied with what the file asks for; another one without sweep and
        designs.

        Parameters
        ----------
        progress : callable ``(stage, fraction) -> None``, optional

        Returns
        -------
        Study
            With `result`, ``to_dict()``, ``html()`` and ``write(folder)``; shows its page in a notebook.

        Examples
        --------
        >>> import symfric as sf
        >>> sf.scenes.coulomb_oscillator(0.1).study().to_dict()["motion"]["status"]
        'OK'
        """
        # the only call of an upper layer, see tests/test_layers.py
        from symfric.report.study.study import study_of

        return study_of(self, progress)

    @alone(SYMBOLIC)
    def _repr_latex_(self) -> str:
        """Return the equations, the values, the start and the horizon."""
        return latex_of(self)

    def __repr__(self) -> str:
        names = ", ".join(c.name for c in self.contacts) or "none"
        values = ", ".join(f"{k}={'?' if v is None else format(v, 'g')}" for k, v in self.values.items())
        held = f"held: {', '.join(h.name for h in self.held)}; " if self.held else ""
        resets = f"{counted(len(self.resets), 'reset')}; " if self.resets else ""
        return (
            f"Scene({counted(len(self.system.q), 'coordinate')}, contacts: {names}; {held}{resets}{values}; "
            f"horizon {self.horizon:g})"
        )


def check_scene(scene: object) -> None:
    """Raise unless it is a scene, where a function takes one."""
    if not isinstance(scene, Scene):
        cure = "sf.read(...) reads a scene file" if isinstance(scene, str) else "give a sf.Scene"
        raise SceneError(f"scene is {shortened(scene)}, not a scene; {cure}")


def check_given_loads(scene: Scene, what: str) -> None:
    """Raise if a contact of the scene opens, where a function takes given normal loads only."""
    for c in scene.contacts_that_open:
        raise SceneError(f"{what} takes given normal loads, and contact {c.name!r} opens; simulate it instead")
