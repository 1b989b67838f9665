"""The equations of a scene while every contact slips one way: smooth, compiled once, with exact derivatives.

With J = dw/du the slip directions and s_i = sign(w_i) held fixed,

    M(q) u' = G(q, u, z) = force - sum_i J_i s_i N_i mu_i(s_i w_i),    z' = Z(q, u, z).

Steady sliding is u = 0, G = 0, Z = 0. Because u' = 0 there, derivatives of the accelerations follow from those of G
and M without inverting the mass matrix symbolically.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from typing import NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.numeric import numeric
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, System

Values = Mapping[sp.Symbol, float]


@dataclass(frozen=True, eq=False)
class Field:
    """Numeric functions of the sliding equations; every one takes states, parameters and slip signs as vectors.

    Attributes
    ----------
    states, parameters : tuples of Symbol
    n, n_z : int
        Coordinates and first-order states.
    contacts : tuple of Contact
    parts : tuple of Expr
        G and Z, length n + n_z.
    signs : tuple of Symbol
        Stand for sign(w) of each contact in `parts`.
    value, jacobian, mass, slip : callables ``(x, p, s) -> ndarray``
        (n + n_z,), (n + n_z, n_x), (n, n) and (n_c,).
    """

    states: tuple[sp.Symbol, ...]
    parameters: tuple[sp.Symbol, ...]
    n: int
    n_z: int
    system: System
    contacts: tuple[Contact, ...]
    parts: tuple[sp.Expr, ...]
    signs: tuple[sp.Symbol, ...]
    value: Callable
    jacobian: Callable
    mass: Callable
    slip: Callable

    def vector(self, values: Values) -> np.ndarray:
        """Return the parameters as a vector in the order of `parameters`."""
        return np.array([values[p] for p in self.parameters], dtype=float)

    def directions(self, x: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the sign of each slip; +1 where it vanishes, which only smooth laws may meet."""
        return np.where(self.slip(x, p, np.ones(len(self.contacts))) < 0, -1.0, 1.0)


@alone(SYMBOLIC)
def field_of(scene: Scene, vary: tuple[sp.Symbol, ...] = ()) -> Field:
    """Compile the sliding equations of a scene whose forces do not depend on time.

    Parameters
    ----------
    scene : Scene
    vary : tuple of Symbol
        Parameters that will change: an excitation that vanishes only for their present values counts as present.

    Raises
    ------
    SceneError
        If time or a sampled input enters the equations.
    """
    if scene.inputs:
        name = next(iter(scene.inputs)).name
        raise SceneError(f"the sampled input {name} depends on time; steady sliding needs a scene without inputs")
    scene.numbers()
    zero = {k: sp.Integer(0) for k, v in scene.values.items() if v == 0 and k not in vary}

    def still(expr: sp.Expr, what: str) -> sp.Expr:
        if TIME not in expr.free_symbols:
            return expr
        reduced = expr.subs(zero)
        if TIME in reduced.free_symbols:
            raise SceneError(
                f"{what} depends on time; use sf.separate(scene) for the slow motion under fast excitation"
            )
        return reduced

    system = scene.system
    force = [still(e, f"force[{i}]") for i, e in enumerate(system.force)]
    rates = [still(e, f"z_rate[{i}]") for i, e in enumerate(system.z_rate)]
    contacts = tuple(
        replace(
            c,
            slip=still(c.slip, f"slip of contact {c.name!r}"),
            normal=still(c.normal, f"normal of contact {c.name!r}"),
        )
        for c in scene.contacts
    )
    return _compiled(replace(system, force=force, z_rate=rates), contacts, scene.parameters)


@lru_cache(maxsize=32)
def _compiled(system: System, contacts: tuple[Contact, ...], parameters: tuple[sp.Symbol, ...]) -> Field:
    signs = tuple(sp.Dummy(f"s_{c.name}", real=True) for c in contacts)
    parts = [branches(e, system.states) for e in (*system.force, *system.z_rate)]
    for contact, sign in zip(contacts, signs, strict=True):
        friction = -friction_of(contact, sign, system.states)
        for i, u in enumerate(system.u):
            slope = contact.slip.diff(u)
            if not slope.is_zero:
                parts[i] += slope * friction
    states = system.states
    arguments = (*states, *parameters, *signs)
    n, n_z, n_x = len(system.q), len(system.z), len(states)
    rows = [e.diff(x) for e in parts for x in states]
    slips = [branches(c.slip, states) for c in contacts]
    mass = [branches(e, states) for e in system.mass]
    return Field(
        states,
        parameters,
        n,
        n_z,
        system,
        contacts,
        tuple(parts),
        signs,
        _function(arguments, parts, (n + n_z,)),
        _function(arguments, rows, (n + n_z, n_x)),
        _function(arguments, mass, (n, n)),
        _function(arguments, slips, (len(contacts),)),
    )


def friction_of(contact: Contact, sign: sp.Expr, states: tuple[sp.Symbol, ...]) -> sp.Expr:
    """Return ``sign * N * profile * mu(sign * w)``, the friction opposing a slip of the given sign."""
    kinetic = branches(contact.law.kinetic, (SPEED,)).subs(SPEED, sign * branches(contact.slip, states))
    return sign * branches(contact.normal * contact.profile, states) * kinetic


def branches(expr: sp.Expr, states: tuple[sp.Symbol, ...]) -> sp.Expr:
    """Write kinks in the states as Piecewise, whose derivatives are taken branch by branch and hold no impulses."""

    def kink(build):
        def rewrite(*arguments):
            kept = build.func(*arguments)
            return build.pieces(arguments) if kept.free_symbols & set(states) else kept

        return rewrite

    for build in _KINKS:
        expr = expr.replace(build.func, kink(build))
    return expr


class _Kink(NamedTuple):
    func: type
    pieces: Callable


def _absolute(arguments):
    (e,) = arguments
    return sp.Piecewise((-e, e < 0), (e, True))


def _largest(arguments):
    return reduce(lambda a, b: sp.Piecewise((a, a > b), (b, True)), arguments)


def _smallest(arguments):
    return reduce(lambda a, b: sp.Piecewise((a, a < b), (b, True)), arguments)


_KINKS = (_Kink(sp.Abs, _absolute), _Kink(sp.Max, _largest), _Kink(sp.Min, _smallest))


def _function(arguments, entries, shape):
    """Compile a list of expressions to ``f(x, p, s) -> ndarray`` of the given shape."""
    compiled = numeric(arguments, entries)

    def evaluate(x, p, s):
        return np.array(compiled(*np.concatenate([x, p, s])), dtype=float).reshape(shape)

    return evaluate


@lru_cache(maxsize=32)
@alone(SYMBOLIC)
def curvature(field: Field) -> Callable:
    """Compile the second and third derivatives of G, Z and M with respect to the states.

    Returns
    -------
    callable ``(x, p, s) -> (G2, G3, M1, M2)``
        Shapes (n + n_z, n_x, n_x), (n + n_z, n_x, n_x, n_x), (n, n, n_x) and (n, n, n_x, n_x), symmetric in the last
        axes.
    """
    n, n_x = field.n, len(field.states)
    parts = field.parts
    mass = tuple(branches(e, field.states) for e in field.system.mass)
    blocks: tuple[tuple[tuple[sp.Expr, ...], int, tuple[int, ...]], ...] = (
        *((parts, 2, (len(parts), n_x, n_x)), (parts, 3, (len(parts), n_x, n_x, n_x))),
        *((mass, 1, (n * n, n_x)), (mass, 2, (n * n, n_x, n_x))),
    )
    entries, places = [], []
    for block, (rows, order, _) in enumerate(blocks):
        for index, derivative in _derivatives(rows, field.states, order):
            places.append((block, index))
            entries.append(derivative)
    arguments = (*field.states, *field.parameters, *field.signs)
    numbers = _function(arguments, entries, (len(entries),))

    def evaluate(x, p, s):
        arrays = [np.zeros(shape) for _, _, shape in blocks]
        for (block, (row, columns)), value in zip(places, numbers(x, p, s), strict=True):
            for permuted in set(itertools.permutations(columns)):
                arrays[block][(row, *permuted)] = value
        second, third, mass_1, mass_2 = arrays
        return second, third, mass_1.reshape(n, n, n_x), mass_2.reshape(n, n, n_x, n_x)

    return evaluate


def _derivatives(rows, states, order):
    """Yield ((row, columns), derivative) of the nonzero derivatives, columns in increasing order."""
    for row, expr in enumerate(rows):
        level: dict[tuple[int, ...], sp.Expr] = {(): expr}
        for _ in range(order):
            level = {
                (*columns, j): e.diff(states[j])
                for columns, e in level.items()
                for j in range(columns[-1] if columns else 0, len(states))
                if states[j] in e.free_symbols
            }
            level = {columns: e for columns, e in level.items() if not e.is_zero}
        for columns, e in level.items():
            yield (row, columns), e
