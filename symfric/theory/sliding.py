"""The smooth equations of a scene while every contact slips in a fixed direction, compiled with exact derivatives.

With J = dw/du the slip directions and s_i = sign(w_i) held fixed,

    M(q) u' = G(q, u, z) = force - sum_i J_i s_i N_i mu_i(s_i w_i),    z' = Z(q, u, z).

Steady sliding is u = 0, G = 0, Z = 0. Because u' = 0 there, derivatives of the accelerations follow from those of G
and M without inverting the mass matrix symbolically.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache, reduce
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.constant_parameters import vanishing
from symfric.model.contact_states import coefficient, rates_by_side
from symfric.model.in_plane import refuse_planes
from symfric.model.scene import Scene, check_given_loads, check_scene
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, System
from symfric.theory.springs_with_sliders import Spring, replaced

Values = Mapping[sp.Symbol, float]


class Field:
    """The sliding equations, from the contact dynamics; numeric functions take states, parameters and slip signs.

    Parameters
    ----------
    system : System
        Without time.
    contacts : tuple of Contact
    parameters : tuple of Symbol
    held : tuple of Spring
        Springs whose sliders are taken to stick.

    Attributes
    ----------
    states : tuple of Symbol
    n, n_z : int
        Coordinates and first-order states.
    signs : tuple of Symbol
        Stand for sign(w) of each contact in `parts`.
    """

    def __init__(
        self,
        system: System,
        contacts: tuple[Contact, ...],
        parameters: tuple[sp.Symbol, ...],
        held: tuple[Spring, ...] = (),
    ):
        self.system, self.contacts, self.parameters, self.held = system, contacts, parameters, held
        self.states, self.n, self.n_z = system.states, len(system.q), len(system.z)
        self.signs = tuple(sp.Dummy(f"s_{c.name}", real=True) for c in contacts)
        model = self._model = ContactDynamics(system, contacts, parameters)
        self.planes = tuple(plane.row for plane in model.planes)
        sides = model.force + model.slopes.T @ model.sliding if contacts else model.force
        self._sides, self._mass = model.unswitched([ca.vertcat(sides, model.z_rate), ca.densify(model.mass)])
        for plane in model.planes:  # it slips
            data = ca.vertcat(plane.flag, plane.variables)
            self._sides = ca.substitute(self._sides, data, ca.SX.zeros(data.numel()))
        out = [self._sides, ca.jacobian(self._sides, model.y), self._mass, *model.unswitched([_unscaled(model)])]
        self._value, self._slopes, self._mass_of, self._slip = (self._function(e) for e in out)

    def value(self, x: np.ndarray, p: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Return G and Z, shape (n + n_z,)."""
        return np.asarray(self._value(x, p, s).toarray().ravel())

    def jacobian(self, x: np.ndarray, p: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Return the derivatives of G and Z by the states, shape (n + n_z, n_x)."""
        return np.asarray(self._slopes(x, p, s).toarray())

    def mass(self, x: np.ndarray, p: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Return M, shape (n, n)."""
        return np.asarray(self._mass_of(x, p, s).toarray())

    def slip(self, x: np.ndarray, p: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Return the slips, shape (n_c,), of contacts in the plane both components."""
        return np.asarray(self._slip(x, p, s).toarray().ravel())

    def slips(self, x: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the slips of a state without any directions."""
        return self.slip(x, p, np.ones(self._model.d.numel()))

    def speeds(self, x: np.ndarray, p: np.ndarray) -> list[float]:
        """Return the slip of every contact, of those in the plane the speed."""
        slips, speeds = self.slips(x, p), []
        rows = iter(range(len(slips)))
        for k in rows:
            if k in self.planes:
                speeds.append(float(np.hypot(slips[k], slips[next(rows)])))
            else:
                speeds.append(float(slips[k]))
        return speeds

    def vector(self, values: Values) -> np.ndarray:
        """Return the parameters as a vector in the order of `parameters`."""
        return np.array([values[p] for p in self.parameters], dtype=float)

    def directions(self, x: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the sign of each slip; +1 where it is zero, which occurs for smooth laws only."""
        return np.where(self.slips(x, p) < 0, -1.0, 1.0)

    @alone(SYMBOLIC)
    def curvature(self, x: np.ndarray, p: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the second and third derivatives of G and Z, and the first and second of M, by the states.

        Returns
        -------
        G2, G3, M1, M2 : ndarray
            Shapes (n + n_z, n_x, n_x), (n + n_z, n_x, n_x, n_x), (n, n, n_x) and (n, n, n_x, n_x), symmetric in the
            last axes.
        """
        n, n_x = self.n, len(self.states)
        arrays = [np.zeros((count, *[n_x] * order)) for count, order, _, _ in self._curved]
        for array, (_, _, places, function) in zip(arrays, self._curved, strict=True):
            values = function(x, p, s).toarray().ravel()
            for (row, *columns), value in zip(places, values, strict=True):
                for permuted in itertools.permutations(columns):
                    array[(row, *permuted)] = value
        second, third, mass_1, mass_2 = arrays
        return second, third, mass_1.reshape(n, n, n_x), mass_2.reshape(n, n, n_x, n_x)

    @cached_property
    def parts(self) -> tuple[sp.Expr, ...]:
        """G and Z as expressions of the states, `parameters` and `signs`, length n + n_z."""
        refuse_planes(self.contacts, "a criterion in symbols")
        rates = rates_by_side(self.system, self.contacts, self.signs)
        parts = [branches(e, self.states) for e in (*self.system.force, *rates)]
        for contact, sign in zip(self.contacts, self.signs, strict=True):
            friction = -friction_of(contact, sign, self.states)
            for i, u in enumerate(self.system.u):
                slope = contact.slip.diff(u)
                if not slope.is_zero:
                    parts[i] += slope * friction
        return tuple(parts)

    @cached_property
    def _curved(self) -> list[tuple[int, int, list[tuple[int, ...]], ca.Function]]:
        """Number of equations, order, indices (row, increasing columns) and values of the nonzero derivatives."""
        rows = ((self._sides, (2, 3)), (ca.vec(self._mass.T), (1, 2)))
        curved = []
        for graph, orders in rows:
            for order, (places, entries) in enumerate(_derivatives(graph, self._model.y, max(orders)), 1):
                if order in orders:
                    curved.append((graph.numel(), order, places, self._function(entries)))
        return curved

    def _function(self, graph: ca.SX) -> ca.Function:
        model = self._model
        return ca.Function("sliding", [model.y, model.p, model.d], [ca.densify(graph)])


def _derivatives(graph: ca.SX, y: ca.SX, order: int) -> Any:
    """Yield indices and entries of the derivatives of order 1, 2, ..., each combination of columns once."""
    places: list[tuple[int, ...]] = [(row,) for row in range(graph.numel())]
    entries = ca.densify(graph)
    for _ in range(order):
        slopes = ca.jacobian(entries, y)
        rows, columns = slopes.sparsity().get_triplet()
        kept = [k for k, (r, c) in enumerate(zip(rows, columns, strict=True)) if c >= max(places[r][1:], default=0)]
        places = [(*places[rows[k]], columns[k]) for k in kept]
        entries = ca.vertcat(*(slopes.nz[k] for k in kept)) if kept else ca.SX(0, 1)
        yield places, entries


@alone(SYMBOLIC)
def field_of(scene: Scene, vary: tuple[sp.Symbol, ...] = ()) -> Field:
    """Compile the sliding equations of a scene whose forces do not depend on time.

    Parameters
    ----------
    scene : Scene
        Springs with sliders are replaced, see `symfric.theory.springs_with_sliders`.
    vary : tuple of Symbol
        Parameters that will change; an excitation that is zero only for their present values counts as present.

    Raises
    ------
    SceneError
        If time or a sampled input enters the equations.
    """
    check_scene(scene)
    if scene.clocks:
        raise SceneError("steady sliding needs a scene without held variables and resets")
    check_given_loads(scene, "steady sliding")
    if scene.inputs:
        name = next(iter(scene.inputs)).name
        raise SceneError(f"the sampled input {name} depends on time; steady sliding needs a scene without inputs")
    scene.numbers()
    zero = vanishing(scene, frozenset(s.name for s in vary))

    def still(expr: sp.Expr, what: str) -> sp.Expr:
        if TIME not in expr.free_symbols:
            return expr
        reduced = expr.subs(zero)
        if TIME in reduced.free_symbols:
            cure = "steady sliding needs a scene without excitation"
            if not any(c.in_plane for c in scene.contacts):
                cure = "use sf.separate(scene) for the slow motion under fast excitation"
            raise SceneError(f"{what} depends on time; {cure}")
        return reduced

    for c in scene.contacts:
        for e in c.law.expressions:
            still(e, f"the law of contact {c.name!r}")
    near = replaced(scene.system, scene.contacts, scene.parameter_values())
    system = near.system
    force = [still(e, f"force[{i}]") for i, e in enumerate(system.force)]
    rates = [still(e, f"z_rate[{i}]") for i, e in enumerate(system.z_rate)]
    contacts = tuple(
        replace(
            c,
            slip=still(c.slip, f"slip of contact {c.name!r}"),
            normal=still(c.normal, f"normal of contact {c.name!r}"),
            across=None if c.across is None else still(c.across, f"slip of contact {c.name!r}"),
        )
        for c in near.contacts
    )
    linear = system.linear
    if linear is not None:
        loads = tuple((still(e, "a load of the structure"), row) for e, row in linear.loads)
        scaled = tuple((still(e, "a factor of a matrix"), matrix) for e, matrix in linear.scaled)
        linear = (
            replace(linear, loads=loads, scaled=scaled) if (loads, scaled) != (linear.loads, linear.scaled) else linear
        )
    return _field(replace(system, force=force, z_rate=rates, linear=linear), contacts, scene.parameters, near.held)


def _unscaled(model: ContactDynamics) -> ca.SX:
    """Return the slips, those of a contact with an ellipse without its factors."""
    w = ca.SX(model.slip)
    for plane in model.planes:
        if plane.factors is not None:
            w[plane.rows] /= plane.factors
    return w


_field = lru_cache(maxsize=32)(Field)


def friction_of(contact: Contact, sign: sp.Expr, states: tuple[sp.Symbol, ...]) -> sp.Expr:
    """Return ``sign * N * profile * mu(sign * w)``, the friction opposing a slip of the given sign."""
    if contact.law.memory:
        return branches(contact.normal * contact.profile * coefficient(contact, sign), states)
    kinetic = branches(contact.law.kinetic, (SPEED,)).subs(SPEED, sign * branches(contact.slip, states))
    return sign * branches(contact.normal * contact.profile, states) * kinetic


def branches(expr: sp.Expr, states: tuple[sp.Symbol, ...]) -> sp.Expr:
    """Write kinks in the states as Piecewise, whose derivatives are taken in each branch and contain no impulses."""

    def kink(build: Any) -> Any:
        def rewrite(*arguments: Any) -> Any:
            kept = build.func(*arguments)
            return build.pieces(arguments) if kept.free_symbols & set(states) else kept

        return rewrite

    for build in _KINKS:
        expr = expr.replace(build.func, kink(build))
    return expr


class _Kink(NamedTuple):
    func: type
    pieces: Callable[..., Any]


def _absolute(arguments: Any) -> Any:
    (e,) = arguments
    return sp.Piecewise((-e, e < 0), (e, True))


def _largest(arguments: Any) -> Any:
    return reduce(lambda a, b: sp.Piecewise((a, a > b), (b, True)), arguments)


def _smallest(arguments: Any) -> Any:
    return reduce(lambda a, b: sp.Piecewise((a, a < b), (b, True)), arguments)


_KINKS = (_Kink(sp.Abs, _absolute), _Kink(sp.Max, _largest), _Kink(sp.Min, _smallest))
