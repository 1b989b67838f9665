"""A scene: system, contacts, parameter values, initial state, horizon and outputs of one simulation."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.contact_observables import observables_of, vector_words
from symfric.model.contact_states import with_states, without_states
from symfric.model.gaps import check_gaps
from symfric.model.held import Held, in_order
from symfric.model.in_plane import refuse_planes
from symfric.model.laws.law import Shape
from symfric.model.outputs import OF_CONTACTS, Output, OutputOfExpression, read_outputs
from symfric.model.quantities import is_quantity, number_of, without_units
from symfric.model.resets import Reset, check_order, check_resets, crossings_of
from symfric.model.symbols import (
    SPEED,
    TIME,
    Key,
    counted,
    expression,
    finite,
    legible,
    listed,
    mapped,
    name_of,
    nearest,
    refuse_speed,
    shortened,
)
from symfric.model.system import Contact, Signal, System
from symfric.model.units import Units, check_outputs, units_of
from symfric.model.validation import (
    check_contacts,
    check_continuous,
    check_instants,
    check_start,
    check_symbols,
    check_times,
    refuse_observables,
)
from symfric.model.written_equations import equations_of, latex_of

if TYPE_CHECKING:
    from symfric.report.study.study import Study

_Value = TypeVar("_Value")
_OBSERVED = tuple(f"{kind}(" for kind in OF_CONTACTS)  # how the names of their symbols begin
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
            raise SceneError(f"system is {system!r}; give a sf.System")
        self._set("contacts", listed(contacts, "contacts"))
        for c in self.contacts:
            if not isinstance(c, Contact):
                raise SceneError(f"{c!r} in contacts is no sf.Contact")
        check_contacts(without_states(system), self.contacts)
        texts = dict(_by_name(units, "units"))
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
        self._check_output_symbols()
        check_times(self.outputs, length)
        self._read_values(values, initial, inputs)
        self._read_initial(initial)
        self._set("units", units if isinstance(units, Units) and len(texts) == len(units) else units_of(self, texts))
        if None not in self.values.values():
            self._check_numbers()

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)  # assignment in a frozen class

    def _read_values(
        self, values: Mapping[Key, float | None], initial: Mapping[Any, Any], inputs: Mapping[Key, Signal]
    ) -> None:
        given = _by_name(values, "values")
        if len(given) < len(values):
            raise SceneError("a parameter is given twice in Scene.values, as a symbol and by name")
        signals = _by_name(inputs, "inputs")
        for name, signal in signals.items():
            if not isinstance(signal, Signal):
                raise SceneError(f"input {name} is {signal!r}; give a sf.Signal")
        symbols = self._symbols(self.contacts, initial, self.outputs)
        if any(s.name.startswith(_OBSERVED) for s in symbols):
            refuse_observables(self.system, self.contacts, _by_name(initial, "initial"), self.clocked)
        check_instants(self.clocks, set(self.system.states) | set(self.system.rows))
        found: dict[str, sp.Symbol] = {}
        for symbol in sorted(symbols, key=str):
            found.setdefault(symbol.name, symbol)
        rows = {s.name: s for s in self.system.rows}
        allowed = self._state_names() | rows | {name: found.get(name, sp.Symbol(name)) for name in signals}
        if clash := next((name for name in (*given, *signals) if name in self._state_names()), None):
            cure = "its start belongs in Scene.initial, not in Scene.values" if clash in given else "rename the input"
            raise SceneError(f"{clash} is a state; {cure}")
        reserved = self._contact_symbols() | {TIME.name: TIME}
        check_symbols(symbols, allowed | reserved, set(given))
        parameters = set(found) - set(allowed) - set(reserved)
        self._check_reserved([*given, *signals], found)
        for name in [*given, *signals]:
            where = "input" if name in signals else "value"
            legible(name, f"an {where}" if name in signals else f"a {where}")
            if name not in found:
                raise SceneError(f"{where} {name} is used by no expression{nearest(name, parameters)}")
        numbers = {found[n]: None if v is None else finite(v, f"the value of {n}") for n, v in given.items()}
        self._set("values", numbers)
        self._set("inputs", {found[n]: s for n, s in signals.items()})

    def _check_reserved(self, names: Sequence[str], found: Mapping[str, sp.Symbol]) -> None:
        """Raise if time or the sliding speed is given a value."""
        in_laws = any(SPEED in e.free_symbols for c in self.contacts for e in c.law.expressions)
        for name in names:
            if name == TIME.name:
                raise SceneError("t is given a value, and is sf.TIME, which runs from 0; rename your symbol t")
            if name == SPEED.name and name not in found and in_laws:
                raise SceneError(
                    "v is given a value, and in a law is sf.SPEED, the sliding speed; rename your symbol v"
                )

    def _still_used(
        self, contacts: Sequence[Contact], initial: Mapping[Any, Any], outputs: Mapping[str, Output]
    ) -> dict[sp.Symbol, float | None]:
        """Return the values that the scene still uses after some of its parts were replaced."""
        used = self._symbols(contacts, initial, outputs)
        return {s: v for s, v in self.values.items() if s in used}

    def _symbols(
        self, contacts: Sequence[Contact], initial: Mapping[Any, Any], outputs: Mapping[Any, Any]
    ) -> set[sp.Symbol]:
        """Return every symbol that some expression uses, the speed inside laws and previous values apart."""
        wanted = [o.expr for o in outputs.values() if isinstance(o, OutputOfExpression)]
        starts = [e for e in (*initial.values(), *(h.initial for h in self.held)) if isinstance(e, sp.Expr)]
        parts = [e.free_symbols for e in (*self.system.expressions, *self.clocked, *wanted, *starts)]
        return set().union(*parts, *(c.free_symbols for c in contacts)) - {h.previous for h in self.held}

    def _state_names(self) -> dict[str, sp.Symbol]:
        return {s.name: s for s in self.system.states}

    def _contact_symbols(self) -> dict[str, sp.Symbol]:
        return {s.name: s for c in self.contacts for s in observables_of(c.name, c.in_plane)}

    def _read_initial(self, initial: Mapping[Key, float | sp.Expr]) -> None:
        states = self._state_names()
        given = {s.name: 0.0 for c in self.contacts for s in c.states}
        for h in self.held:
            given |= h.starts
        given |= _by_name(initial, "initial")
        for name, value in given.items():
            if name not in states:
                raise SceneError(f"{name} in Scene.initial is no state{nearest(name, states)}")
            if isinstance(value, sp.Expr) and value.free_symbols:
                value = expression(value, f"the initial value of {name}")
                refuse_speed(value, f"the initial value of {name}")
                if value.free_symbols - set(self.values):
                    raise SceneError(f"the initial value of {name} is {value}; it may depend on parameters only")
                given[name] = value
            else:
                given[name] = finite(value, f"the initial value of {name}")
        if missing := next((name for name in states if name not in given), None):
            raise SceneError(f"no initial value for {missing}; add it to Scene.initial")
        self._set("initial", {s: given[s.name] for s in self.system.states})

    def _check_output_symbols(self) -> None:
        known = self._contact_symbols()
        for name, output in self.outputs.items():
            if isinstance(output, OutputOfExpression):
                for s in output.expr.free_symbols:
                    if s.name.startswith(_OBSERVED) and s.name not in known:
                        contacts, bare = [c.name for c in self.contacts], s.name.split("(", 1)[1][:-1]
                        if bare.removesuffix(", 0").removesuffix(", 1") in contacts:
                            raise SceneError(vector_words(name, bare))
                        raise SceneError(f"output {name!r} uses contact {bare!r}{nearest(bare, contacts)}")

    def _check_numbers(self) -> None:
        numbers = self.numbers()
        for what, e in self._named_expressions():
            check_continuous(e, {k: v for k, v in numbers.items() if k not in self.initial}, what)
        if self.system.linear:
            states, n = [numbers[s] for s in self.system.states], len(self.system.q)
            numbers |= self.system.linear.values(states[:n], states[n : 2 * n])
        start = {**numbers, TIME: 0.0, **{k: float(s(0.0)) for k, s in self.inputs.items()}}
        check_gaps(self.system, self.contacts, start, self.horizon)
        check_start(self.system, self.contacts, start, self.horizon)
        check_order(self.clocks, numbers)

    def _named_expressions(self) -> Iterator[tuple[str, sp.Expr]]:
        for i, e in enumerate(self.system.force):
            yield f"force[{i}]", e
        for i, e in enumerate(self.system.z_rate[: len(self.system.z) - self.system.made]):
            yield f"z_rate[{i}]", e
        for i, e in enumerate(self.system.linear.expressions if self.system.linear else ()):
            yield f"load[{i}]", e
        yield from crossings_of(self.clocks)

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
        return (*self.held, *self.resets)

    @property
    def timed(self) -> tuple[Held | Reset, ...]:
        """Those that act at known times; the others act where an expression crosses zero."""
        return tuple(part for part in self.clocks if part.crossing is None)

    @property
    def clocked(self) -> tuple[sp.Expr, ...]:
        """Every expression of held variables and resets, without previous values."""
        found = (e for part in self.clocks for e in part.expressions)
        return tuple(e.xreplace({h.previous: h.symbol for h in self.held}) for e in found)

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
        start = _by_name(self.initial, "initial") | _by_name(self._plain(initial), "initial")
        return replace(self, initial=start, values=self._still_used(self.contacts, start, self.outputs))

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
        used = self._still_used(self.contacts, self.initial, outputs)
        return replace(self, outputs=outputs, horizon=horizon, values=used)

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
        return replace(self, contacts=contacts, values=self._still_used(contacts, self.initial, self.outputs))

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


def _by_name(entries: Mapping[Key, _Value], what: str) -> dict[str, _Value]:
    return {name_of(k): v for k, v in mapped(entries, what, f"{what}={{...}}").items()}
