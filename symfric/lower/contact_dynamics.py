"""The equations of motion of a scene with contacts, as CasADi graphs; they are written only here.

With the velocities u = q', the slips w = w(q, u, t), which are affine in u, and the friction forces lambda,

    M(q) u' = f + J^T lambda,   J = dw/du,   w' = J u' + c,   c = dw/dq u + dw/dt,

where contact i carries the load N_i >= 0, bears up to ``N_i mu_s`` while it sticks, and slips against
``lambda_i = -d_i N_i mu(d_i w_i)`` in the direction d_i = +-1, or, with a law with memory, always against
``lambda_i = -N_i mu(z, w_i, d_i)``, z its own states. Everything is smooth: kinks are switches, signs held as
data; see `symfric.lower.printer`.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import cached_property

import casadi as ca
import numpy as np
import sympy as sp

from symfric.lower.averaged_series import bridged
from symfric.lower.cell_edges import Edges, edges_of
from symfric.lower.clocks import Clocks
from symfric.lower.constraint_forces import AT_BOUND, HOLDS, constraint_basis
from symfric.lower.contact_space import ContactSpace, contact_space
from symfric.lower.held_velocities import held_velocities
from symfric.lower.linear_part import force_in, mass_in, rows_in
from symfric.lower.load_sharing import dependent, parallels
from symfric.lower.mode_layout import JUST_AFTER
from symfric.lower.planes import Plane, rows_of
from symfric.lower.printer import Printer, Switches
from symfric.lower.slider_sets import SliderSet
from symfric.lower.spring_sliders import Spring, with_forces
from symfric.lower.unilateral import Opening
from symfric.model.laws.memory import SIDE, SLIP
from symfric.model.outputs import dissipated_power, friction_force, normal_force, slip, stored_energy
from symfric.model.scene import Scene
from symfric.model.springs import spring_of
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, System


class ContactDynamics:
    """Equations of motion of one system: CasADi symbols and graphs of state, time, parameters and mode.

    Parameters
    ----------
    system : System
    contacts : sequence of Contact
        Along a line, or behind springs.
    parameters : sequence of Symbol
        Parameters that stay symbols in the equations.
    inputs : sequence of Symbol
        Sampled inputs.
    constants : mapping of Symbol to Expr
        Parameters that the graphs take as numbers instead.
    free : mapping of Symbol to SX
        Parameters that are other graphs, and change along a run.
    rows : mapping of Symbol to SX, optional
        Graphs in place of the rows of a linear part; forces and loads then do not show how they depend on the states.

    Attributes
    ----------
    y, t, p : SX
        State (n_x,), time, and parameters followed by start, value and slope of the sample interval of every input.
    q, u : SX, shape (n,)
        Coordinates and velocities in y.
    s, d : SX, shape (n_c,)
        Of every contact, whether it sticks, and the direction of its slip; see `symfric.lower.automaton`.
    slip, load : SX, shape (n_c,)
        w, and the normal load times the profile.
    parameters, inputs : tuple of Symbol
        Order of the entries of p.
    moving : set of Symbol
        What changes along a run.
    switches : Switches
        The kinks met so far.
    horizon : float
        Length of a run, a scale of time.
    contacts : tuple of Contact
        Those along a line; one in the plane is two of these, the components of its slip.
    planes : list of Plane
        The contacts in the plane.
    springs : list of Spring
        The contacts behind springs; their forces are among the applied ones. Then the normal directions of contacts
        that open, last the clocks.
    openings : list of Opening
        The contacts that open. Graphs contain symbols of their normal forces, see `symfric.lower.normal_forces`.
    """

    def __init__(
        self,
        system: System,
        contacts: Sequence[Contact],
        parameters: Sequence[sp.Symbol],
        inputs: Sequence[sp.Symbol] = (),
        constants: Mapping[sp.Symbol, sp.Expr] | None = None,
        free: Mapping[sp.Symbol, ca.SX] | None = None,
        rows: Mapping[sp.Symbol, ca.SX] | None = None,
        horizon: float = 1.0,
    ) -> None:
        self.contacts = tuple(row for c in contacts if c.along_line for row in rows_of(c))
        behind = tuple(c for c in contacts if not c.along_line and not c.frictionless)
        self.system, self.inputs = with_forces(system, behind), tuple(inputs)
        self.constants, free = dict(constants or {}), free or {}
        self.y, self.t = ca.SX.sym("y", len(system.states)), ca.SX.sym("t")
        n = len(system.q)
        self.q, self.u = self.y[:n], self.y[n : 2 * n]
        self.parameters = tuple(s for s in parameters if s not in self.constants and s not in free)
        own = len(self.parameters)
        self.p = ca.SX.sym("p", own + 3 * len(self.inputs))
        self.switches, self.horizon = Switches(horizon), horizon
        symbols = {TIME: self.t, **free}
        symbols |= dict(zip(system.states, ca.vertsplit(self.y), strict=True))
        symbols |= {s: self.p[i] for i, s in enumerate(self.parameters)}
        if system.linear is not None:
            symbols |= rows_in(system.linear, self.q, self.u) if rows is None else rows
        for k, s in enumerate(self.inputs):
            start, value, slope = ca.vertsplit(self.p[own + 3 * k : own + 3 * k + 3])
            symbols[s] = value + slope * (self.t - start)
        self.moving = {*system.states, *system.rows, TIME, *self.inputs, *free}
        self._print = Printer(symbols, self.moving, self.switches)
        self.openings = self._openings(contacts)
        self.planes: list[Plane] = []
        self.s, self.d = (ca.SX.sym(name, len(self.contacts)) for name in "sd")
        slips, loads, frictions = [], [], []
        for i, c in enumerate(self.contacts):
            slips.append(self.read(c.slip))
            loads.append(self.read(c.normal * c.profile))
            if c.law.memory:
                frictions.append(-loads[i] * self._remembered(c, slips[i], self.d[i], c.law.memory.force))
            elif c.across is not None:
                pair = ca.vertcat(slips[i], self.read(c.across))
                factors = None if c.ellipse is None else ca.vertcat(*map(self.read, c.ellipse))
                opens = next((e.mode for e in self.openings if e.line == i), None)
                self.planes.append(Plane(c.name, i, pair, self.s[i], self.t, factors, opens))
                frictions.append(self._in_plane(self.planes[-1], loads[i], 0))
            elif self.planes and self.planes[-1].row == i - 1:
                frictions.append(self._in_plane(self.planes[-1], loads[i], 1))
            else:
                frictions.append(-self.d[i] * loads[i] * self.kinetic(i, self.d[i] * slips[i]))
        self.slip, self.load, self._sliding = (_column(e) for e in (slips, loads, frictions))
        self.springs: list[Spring | SliderSet | Opening | Plane | Clocks] = [
            self._sliders(c) if c.law.memory else self._spring(c) for c in behind
        ]
        self.springs += [*self.planes, *self.openings]

    def _openings(self, contacts: Sequence[Contact]) -> list[Opening]:
        """Return the contacts that open, stops first; expressions read later may contain their normal forces."""
        openings, names = [], [row.name for row in self.contacts]
        for c in sorted((c for c in contacts if c.unilateral is not None), key=lambda c: not c.frictionless):
            assert c.unilateral is not None
            force, line = ca.SX.sym("normal"), -1 if c.frictionless else names.index(c.name)
            gap, restitution = self.read(c.unilateral.gap), self.read(c.unilateral.restitution)
            size = sum(ca.fabs(self.read(e)) for e in sp.Add.make_args(sp.expand(c.unilateral.gap)))
            size += ca.fabs(ca.jacobian(gap, self.q)) @ ca.fabs(self.q)
            openings.append(Opening(c.name, line, gap, size, restitution, force))
            self.define(normal_force(c.name), force)
            if c.frictionless:
                for nothing in (friction_force, slip, stored_energy, dissipated_power):
                    self.define(nothing(c.name), ca.SX(0))
        return openings

    def _spring(self, contact: Contact) -> Spring:
        """Return the equations of a contact behind a spring; expressions read later may contain its force."""
        place = self.system.states.index(spring_of(contact.name))
        limit, w = self.read(contact.normal * contact.profile * contact.law.stick), self.read(contact.slip)
        rising = ca.jacobian(limit, self.q) @ self.u + ca.jacobian(limit, self.t)
        spring = Spring(contact.name, place, self.y[place], w, limit, rising, self.read(contact.stiffness))
        self._define(contact, spring.force, w)
        self.define(stored_energy(contact.name), spring.stiffness * spring.z**2 / 2)
        power = -spring.force * spring.w - spring.stiffness * spring.z * spring.rate
        self.define(dissipated_power(contact.name), power)
        return spring

    def _sliders(self, contact: Contact) -> SliderSet:
        """Return the equations of the sliders of a contact; expressions read later may contain its force."""
        memory, w, load = contact.law.memory, self.read(contact.slip), self.read(contact.normal * contact.profile)
        assert memory is not None
        places = tuple(self.system.states.index(s) for s in contact.states)
        force = -load * self._remembered(contact, w, ca.SX(1), memory.force)
        limits = ca.vertcat(*(self.read(e) for e in memory.limits))
        sliders = SliderSet(contact.name, places, self.y[list(places)], limits, w, force)
        stored, gained = self._energy(contact, w, ca.SX(1), [rate for _, rate in sliders.rates])
        self._define(contact, force, w)
        self.define(stored_energy(contact.name), load * stored)
        self.define(dissipated_power(contact.name), -force * w - load * gained)
        return sliders

    def _define(self, contact: Contact, *values: ca.SX) -> None:
        for what, e in zip((friction_force, slip, normal_force), (*values, self.read(contact.normal)), strict=True):
            self.define(what(contact.name), e)

    @classmethod
    def of(cls, scene: Scene, constants: Mapping[sp.Symbol, sp.Expr] | None = None) -> "ContactDynamics":
        """Return the equations of a scene."""
        given = scene.system, scene.contacts, scene.parameters, tuple(scene.inputs)
        made = cls(*given, constants, horizon=scene.horizon)
        if scene.clocks:
            made.springs.append(Clocks.of(scene, made._print.symbols, made.constants, made.t, made.read))
        return made

    def copy(self) -> "ContactDynamics":
        """Return a copy, to which symbols and kinks can be added."""
        other = copy(self)
        other.switches, other.moving = self.switches.copy(), set(self.moving)
        other._print = self._print.copy(other.moving, other.switches)
        return other

    # Reading expressions of the scene

    def read(self, expr: sp.Expr) -> ca.SX:
        """Return the graph of an expression."""
        return self._print(sp.sympify(expr).xreplace(self.constants))

    def vector(self, exprs: Sequence[sp.Expr]) -> ca.SX:
        """Return the graphs of some expressions as a column."""
        return _column([self.read(e) for e in exprs])

    def define(self, symbol: sp.Symbol, graph: ca.SX) -> None:
        """Define a symbol as a graph that changes along a run, for expressions read later."""
        self._print.symbols[symbol] = graph
        self.moving.add(symbol)

    def unswitched(self, out: list[ca.SX]) -> list[ca.SX]:
        """Return expressions in which the signs of kinks are computed from their quantities instead of being data.

        Steps in time are taken as just after t, which is an instant of a step only to rounding.
        """
        if not self.switches.signs:
            return out
        signs, quantities = ca.vertcat(*self.switches.signs), ca.vertcat(*self.switches.quantities)
        for k in sorted(self.switches.steps):
            later = self.t + JUST_AFTER * (ca.fabs(self.t) + self.horizon)
            quantities[k] = ca.substitute(quantities[k], self.t, later)
        nested = ca.which_depends(quantities, signs, 1, True)
        for k in (k for k in reversed(range(len(nested))) if nested[k]):
            out = ca.substitute(out, [signs[k]], [ca.if_else(quantities[k] < 0, -1, 1)])
        plain = [k for k, depends in enumerate(nested) if not depends]
        if plain:
            out = ca.substitute(out, [signs[plain]], [ca.if_else(quantities[plain] < 0, -1, 1)])
        return out

    # The equations

    @cached_property
    def mass(self) -> ca.SX:
        """Mass matrix M, sparse, shape (n, n)."""
        part = self.system.linear
        numbers = None if part is None else mass_in(part)
        if self.system.mass is None:
            assert numbers is not None
            return numbers
        rows = self.system.mass.tolist()
        own = ca.sparsify(ca.vertcat(*(ca.horzcat(*(self.read(e) for e in row)) for row in rows)))
        return own if numbers is None else own + numbers

    @cached_property
    def force(self) -> ca.SX:
        """The applied forces f, those of contacts that open in their normal directions included, shape (n,)."""
        own = self.vector(self.system.force)
        if self.system.linear is not None:
            own += force_in(self.system.linear, self.read, self.q, self.u)
        return own + self._pressing @ self.pressed if self.openings else own

    @cached_property
    def pressed(self) -> ca.SX:
        """Symbols of the normal forces of contacts that open."""
        return ca.vertcat(*(e.force for e in self.openings))

    @cached_property
    def _pressing(self) -> ca.SX:
        """Forces on the coordinates by unit normal forces of contacts that open, shape (n, n_n)."""
        return ca.jacobian(ca.vertcat(*(e.gap for e in self.openings)), self.q).T

    @cached_property
    def z_rate(self) -> ca.SX:
        """The rates of the first-order states, shape (n_z,); those of contacts with memory come last."""
        first = 2 * len(self.system.q)
        rates = ca.vertcat(
            self.vector(self.system.z_rate[: len(self.system.z) - self.system.made]), ca.SX.zeros(self.system.made)
        )
        for contact, within in zip(self.contacts, self.rates_within, strict=True):
            for state, rate in zip(contact.states, within, strict=True):
                rates[self.system.states.index(state) - first] = rate
        for place, rate in (e for spring in self.springs for e in spring.rates):
            rates[place - first] = rate
        return rates

    @cached_property
    def rates_within(self) -> list[list[ca.SX]]:
        """The rates of the states of every contact along a line."""
        laws = [(c, self.slip[i], self.d[i], c.law.memory) for i, c in enumerate(self.contacts)]
        return [[self._remembered(c, w, d, e) for e in (law.rates if law else ())] for c, w, d, law in laws]

    def energy(self, i: int) -> tuple[ca.SX, ca.SX]:
        """Return the energy stored in contact i per normal load, and its rate."""
        if self.contacts[i].law.memory is None:
            return ca.SX(0), ca.SX(0)
        return self._energy(self.contacts[i], self.slip[i], self.d[i], self.rates_within[i])

    def _energy(self, contact: Contact, w: ca.SX, d: ca.SX, rates: list[ca.SX]) -> tuple[ca.SX, ca.SX]:
        memory = contact.law.memory
        assert memory is not None
        slopes = (self._remembered(contact, w, d, memory.stored.diff(z)) for z in memory.symbols)
        gained = [slope * rate for slope, rate in zip(slopes, rates, strict=True)]
        return self._remembered(contact, w, d, memory.stored), ca.sum1(ca.vertcat(*gained))

    @cached_property
    def slopes(self) -> ca.SX:
        """Jacobian of the slips, J = dw/du, shape (n_c, n)."""
        return ca.jacobian(self.slip, self.u) if self.contacts else ca.SX(0, self.u.numel())

    @cached_property
    def drift(self) -> ca.SX:
        """Slip accelerations at constant velocities, c = dw/dq u + dw/dt, shape (n_c,)."""
        return ca.jacobian(self.slip, self.q) @ self.u + ca.jacobian(self.slip, self.t)

    @cached_property
    def spread(self) -> ca.SX:
        """Accelerations by unit friction forces, M^-1 J^T, shape (n, n_c)."""
        return self.solve(self.slopes.T) if self.contacts else ca.SX(self.u.numel(), 0)

    @cached_property
    def static(self) -> ca.SX:
        """Static coefficients of friction, shape (n_c,)."""
        return self.vector([c.law.stick for c in self.contacts])

    @cached_property
    def at_rest(self) -> ca.SX:
        """Kinetic coefficients at slip zero, shape (n_c,)."""
        return self.vector([c.law.at_rest for c in self.contacts])

    def kinetic(self, i: int, speed: ca.SX) -> ca.SX:
        """Return the kinetic coefficient of contact i at a speed."""
        contact = self.contacts[i]
        known, law = {**self._print.symbols, SPEED: speed}, bridged(contact.law.where(self.constants))
        return Printer(known, {*self.moving, SPEED}, self.switches, scope=contact.name)(law)

    def _in_plane(self, plane: Plane, load: ca.SX, component: int) -> ca.SX:
        """Return a component of the friction of a contact in the plane while it slips."""
        return -load * self.kinetic(plane.row, plane.slip_speed) * plane.direction[component]

    def _remembered(self, contact: Contact, slip: ca.SX, side: ca.SX, expr: sp.Expr) -> ca.SX:
        """Return the graph of an expression of a law with memory, with the slip of its contact and its direction."""
        assert contact.law.memory is not None
        inside = {**self._print.symbols, SLIP: slip, SPEED: side * slip, SIDE: side}
        inside |= {own: inside[state] for own, state in zip(contact.law.memory.symbols, contact.states, strict=True)}
        show = Printer(inside, {*self.moving, *contact.law.memory.reserved}, self.switches, scope=contact.name)
        return show(expr.xreplace(self.constants))

    def solve(self, forces: ca.SX) -> ca.SX:
        """Return the accelerations by some forces, M^-1 forces."""
        return ca.ldl_solve(forces, *self._factors)

    @cached_property
    def _factors(self) -> tuple[ca.SX, ca.SX, list[int]]:
        return ca.ldl(self.mass)

    @cached_property
    def contact_space(self) -> ContactSpace | None:
        """Where sticking is decided if mass and slips are numbers: in as many directions as there are contacts."""
        constant = self.system.linear is not None and self.mass.is_constant() and self.slopes.is_constant()
        return contact_space(self.mass, self.slopes) if constant and self.contacts else None

    @cached_property
    def parallels(self) -> list[tuple[int, float | sp.Expr]]:
        """For each contact, the first contact of whose slip its own is a multiple, and the factor."""
        return parallels(self)

    @cached_property
    def dependent(self) -> list[bool]:
        """Whether the slip of each contact may depend linearly on those of others that are not multiples of it."""
        return dependent(self)

    @cached_property
    def edges(self) -> Edges:
        """The switches at which profiles jump; the load there is that of the side towards which a contact slips."""
        return edges_of(self)

    @cached_property
    def sliding(self) -> ca.SX:
        """Friction forces of contacts that slip in the direction d, shape (n_c,)."""
        sliding = ca.SX(self._sliding)
        for i in range(len(self.contacts)):
            sliding[i] = self.edges.towards(i, self.d[i], sliding[i])
        return sliding

    def given(self, i: int) -> ca.SX:
        """Return the friction force that contact i is told while it sticks, beside that of its own constraint."""
        if not self.dependent[i]:
            return ca.SX(0)
        if plane := next((p for p in self.planes if p.row <= i <= p.row + 1), None):
            return plane.told[i - plane.row]
        bound = self.edges.towards(i, self.d[i], self.load[i] * self.static[i])
        return ca.if_else(self.s[i] == AT_BOUND, -self.d[i] * bound, 0)

    def friction_unless_held(self, tested: bool) -> ca.SX:
        """Return the friction forces of all contacts but those that hold a constraint, in the mode held by (s, d)."""
        applied = ca.SX(self.sliding)
        for i, contact in enumerate(self.contacts):
            if not contact.law.smooth:
                given = ca.SX(0) if tested else self.given(i)
                applied[i] = ca.if_else(self.s[i] > 0.5, given, self.sliding[i])
        return applied

    @property
    def held_by_sticking(self) -> tuple[list[int], ca.SX, ca.SX]:
        """The contacts that can stick, their drift, and whether they hold a constraint."""
        sticking = [i for i, c in enumerate(self.contacts) if not c.law.smooth]
        return sticking, self.drift[sticking, :], self.s[sticking] == HOLDS

    def accelerations(self, tested: bool, defined: Callable[[ca.SX], ca.SX] = lambda e: e) -> tuple[ca.SX, ca.SX]:
        """Return u' and the friction forces of all contacts in the mode held by (s, d).

        `defined` is applied to what a mode may multiply by zero: the friction of a contact that slips, and its drift.
        With `tested`, the graph determines redundant sticking contacts by conditions on the state, and gives them no
        force; otherwise the mode marks them.
        """
        n = self.u.numel()
        if not self.contacts:
            return self.solve(self.force), ca.SX(0, 1)
        slipping = defined(self.friction_unless_held(tested))
        sticking, drift, holds = self.held_by_sticking
        rows, drift = self.slopes[sticking, :], defined(drift)
        space = self.contact_space
        if not sticking:
            if space is None:
                return self.solve(self.force + self.slopes.T @ slipping), slipping
            return self.solve(self.force) + space.response @ (space.factor @ slipping), slipping
        if space is not None:
            free = self.solve(self.force)
            pulled = space.factor @ slipping
            a, basis = space.felt @ free + pulled, space.basis(sticking, holds, tested)
        else:
            a = free = self.solve(self.force + self.slopes.T @ slipping)
            basis = constraint_basis(rows, self.solve(rows.T), holds, tested)
        held, gain = basis.forces(a, drift)
        rate = ca.densify(free + (gain if space is None else space.response @ (pulled + gain)))
        friction = ca.SX(slipping)
        velocities = held_velocities(rows, self.mass, basis, drift, ca.vertcat(self.y, self.t), space)
        for k, flag, own_rate in zip(velocities.places, velocities.held, velocities.rates, strict=True):
            rate[k] = ca.if_else(flag, own_rate, rate[k])
        for k, i in enumerate(sticking):
            friction[i] = slipping[i] + held[k]
            index, factor = self.anchor(i)
            if index >= 0:  # exact, so that a body held by the ground follows it without rounding
                rate[index - n] = ca.if_else(basis.own[k], -drift[k] / factor, rate[index - n])
        return rate, friction

    def anchor(self, i: int) -> tuple[int, float]:
        """Return the index in y of the one velocity on which slip i depends, and its factor; (-1, 0) if several."""
        system = self.system
        slopes = system.slopes(self.contacts[i].slip)
        present = [k for k, e in enumerate(slopes) if e != 0]
        if len(present) == 1 and (isinstance(slopes, np.ndarray) or slopes[present[0]].is_number):
            return len(system.q) + present[0], float(slopes[present[0]])
        return -1, 0.0


def _column(entries: list[ca.SX]) -> ca.SX:
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)
