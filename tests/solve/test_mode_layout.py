"""Contacts of other kinds than those along a line: new layouts with a transition, in the same loop."""

from dataclasses import replace

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.lower.automaton import lower
from symfric.lower.mode_layout import ModeLayout, OtherContact
from symfric.lower.variational_equations import varied
from symfric.solve.loop.model import series_model
from symfric.solve.observables import Observables
from symfric.solve.taylor.program import variants_of

ORDER, TOLERANCE = 18, 1e-15
x, y, u, v, z = sp.symbols("x y u v z", real=True)
g, r, h = sp.symbols("g r h", positive=True)


def extended(automaton, contact, field, transition):
    """Return an automaton with one more contact.

    ``field(y, t, p, m) -> (rate, guards)`` replaces the rates and gives the guards of the contact, whose variables are
    the last of m; ``transition(y, t, p, m) -> (y, m)`` is what its events do.
    """
    layout = replace(automaton.layout, others=(contact,))
    old = automaton.field
    state, t, p = ca.SX.sym("y", old.size1_in(0)), ca.SX.sym("t"), ca.SX.sym("p", old.size1_in(2))
    m = ca.SX.sym("m", layout.n_mode)
    hit, zero = ca.SX.sym("hit", contact.guards), ca.SX.sym("zero", contact.guards)
    _, guards, rows = old(state, t, p, m[: layout.first_variable])
    rate, own = field(state, t, p, m[layout.first_variable :])
    out = [ca.densify(e) for e in (rate, ca.vertcat(guards, own), rows)]
    new_state, variables = transition(state, t, p, m[layout.first_variable :])
    taken = ca.mmax(hit) > 0.5
    after = [ca.if_else(taken, new_state, state), ca.vertcat(*ca.vertsplit(m)[: layout.first_variable], variables), hit]
    return replace(
        automaton,
        layout=layout,
        field=ca.Function("field", [state, t, p, m], out, old.name_in(), old.name_out()),
        transition=ca.Function("transition", [state, t, p, m, hit, zero], [ca.densify(e) for e in after]),
    )


def model_of(scene, automaton, variations=None):
    wanted = Observables((), {}, False, True)
    variants = variants_of(automaton, ORDER, -1)
    budgets, tolerances = (100_000, 10_000), (TOLERANCE, TOLERANCE)
    return series_model(scene, automaton, variants, wanted, budgets, tolerances, variations)


def test_places_are_all_different_and_fill_mode_and_guards():
    layout = ModeLayout(("a", "b", "c"), 2, ("b",), (OtherContact("floor", 1, 2), OtherContact("stop", 0, 1)))
    places = [*range(3), *(layout.direction(i) for i in range(3)), *(layout.sign(j) for j in range(2))]
    assert [*places, layout.first_variable] == list(range(layout.n_mode))
    guards = [*range(layout.slips.stop), *(layout.switch(j) for j in range(2)), layout.load("b")]
    assert [*guards, *(layout.first_other + k for k in range(3))] == list(range(layout.n_guards))
    assert layout.load("a") == -1
    assert layout.other_guards == [(0, layout.first_variable)] * 2 + [(1, -1)]
    assert layout.modes(np.array([1, 0, 0, -1, -1, 1, 1, 1, -1.0])).tolist() == [0, -1, 1, -1]


def ball():
    """A ball above a floor, dropped from the height h; the state z = r t only makes r a parameter."""
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[-g], z=[z], z_rate=[r])
    values = {g: 9.81, r: 0.9, h: 1.3}
    return sf.Scene(system=system, contacts=[], values=values, initial={x: h, u: 0, z: 0}, horizon=8.9)


def bouncing(scene, varying=frozenset()):
    automaton = lower(scene, (), varying)
    names = [s.name for s in automaton.parameters]

    def field(state, t, p, m):
        return automaton.field(state, t, p, ca.SX(0, 1))[0], state[0]

    def transition(state, t, p, m):
        return ca.vertcat(0, -p[names.index("r")] * state[1], state[2]), m

    return extended(automaton, OtherContact("floor", 0, 1), field, transition)


def flights(t, g, r, h):
    """Return position, velocity and number of impacts of a bouncing ball at a time, in closed form."""
    fall = mpmath.sqrt(2 * h / g)
    if t < fall:
        return h - g * t**2 / 2, -g * t, 0
    begin, speed, n = fall, r * g * fall, 1
    while t > begin + 2 * speed / g:
        begin, speed, n = begin + 2 * speed / g, r * speed, n + 1
    since = t - begin
    return speed * since - g * since**2 / 2, speed - g * since, n


def test_a_ball_on_a_floor_through_twenty_impacts():
    scene = ball()
    with mpmath.workdps(40):
        exact = flights(*(mpmath.mpf(float(e)) for e in (scene.horizon, 9.81, 0.9, 1.3)))
    assert exact[2] >= 20
    automaton = bouncing(scene)
    start, p = np.array([1.3, 0.0, 0.0]), parameters_of(scene, automaton)
    status, (final, _, stats, raw) = model_of(scene, automaton).run(start, p, None)
    assert status == sf.Status.OK
    assert stats["events"] == exact[2] == len(raw.events[0])
    assert final[:2] == pytest.approx([float(e) for e in exact[:2]], abs=1e-12)
    assert raw.events[0][0] == pytest.approx(np.sqrt(2 * 1.3 / 9.81), abs=1e-15)


def parameters_of(scene, automaton):
    return np.array([float(scene.values[s]) for s in automaton.parameters])


def test_derivatives_through_twenty_impacts():
    scene = ball()
    directions = ("x", "u", "g", "r")
    automaton = bouncing(scene, frozenset(("g", "r")))
    variations = varied(automaton, scene, directions, 0)
    model = model_of(scene, variations.automaton, variations)
    columns = np.zeros((4, 3))
    columns[0, 0] = columns[1, 1] = 1.0
    start = np.concatenate([[1.3, 0.0, 0.0], columns.ravel()])
    workspace = model.workspace()
    status = workspace.drive(start, parameters_of(scene, automaton), None)
    assert status == sf.Status.OK
    assert workspace.arrays.counts.doubts == 0
    found = workspace.arrays.y[3:-1].reshape(4, 3)[:, :2]
    with mpmath.workdps(60):
        t, *given = (mpmath.mpf(float(e)) for e in (scene.horizon, 9.81, 0.9, 1.3))
        little = mpmath.mpf(10) ** -20
        for row, k in ((0, 2), (2, 0), (3, 1)):  # the height is where the ball starts
            ends = [flights(t, *(e + way * little * (i == k) for i, e in enumerate(given)))[:2] for way in (1, -1)]
            exact = [float((a - b) / (2 * little)) for a, b in zip(*ends, strict=True)]
            assert found[row] == pytest.approx(exact, rel=1e-11)


MU_S, MU_K, NUDGE = 0.5, 0.3, 1e-14


def pulled(t, sine, cosine):
    """Return a force that grows and turns."""
    size, angle = 0.2 + 0.3 * t, 0.8 * t
    return size * cosine(angle), size * sine(angle)


def test_a_block_in_a_plane_releases_and_slides():
    system = sf.System(q=[x, y], u=[u, v], mass=[[1, 0], [0, 1]], force=list(pulled(sf.TIME, sp.sin, sp.cos)))
    scene = sf.Scene(system=system, contacts=[], initial=dict.fromkeys((x, y, u, v), 0.0), horizon=4.0)
    plain = lower(scene)

    def field(state, t, p, m):
        rate = plain.field(state, t, p, ca.SX(0, 1))[0]
        force, sticks = rate[2:], m[0] < 0.5
        slip = ca.if_else(sticks, ca.SX([1.0, 0.0]), state[2:])  # of two components
        slides = force - MU_K * slip / ca.sqrt(ca.sumsqr(slip))
        disc = MU_S - ca.sqrt(ca.sumsqr(force))
        return ca.vertcat(state[2:], ca.if_else(sticks, 0 * slides, slides)), ca.if_else(sticks, disc, 1)

    def transition(state, t, p, m):
        force = plain.field(state, t, p, ca.SX(0, 1))[0][2:]
        return ca.vertcat(state[:2], NUDGE * force / ca.sqrt(ca.sumsqr(force))), 0 * m + 1

    block = extended(plain, OtherContact("plane", 1, 1), field, transition)
    status, (final, _, stats, raw) = model_of(scene, block).run(np.zeros(4), np.zeros(0), None)
    assert status == sf.Status.OK
    assert stats["events"] == 1
    released = (MU_S - 0.2) / 0.3
    assert raw.events[0] == pytest.approx([released], abs=1e-14)
    assert raw.events[1].tolist() == [[0, 0, 1]]

    def polar(t, state):  # speed and angle of the slip are smooth from the release on
        speed, angle = state[:2]
        fx, fy = pulled(t, np.sin, np.cos)
        along, across = fx * np.cos(angle) + fy * np.sin(angle), fy * np.cos(angle) - fx * np.sin(angle)
        return [along - MU_K, across / speed, speed * np.cos(angle), speed * np.sin(angle)]

    begin = 1e-9
    start = [(MU_S - MU_K) * begin, 0.8 * released, 0.0, 0.0]
    times = released + begin, scene.horizon
    expected = solve_ivp(polar, times, start, method="Radau", rtol=1e-12, atol=1e-15).y[:, -1]
    speed, angle = expected[:2]
    assert final[2:] == pytest.approx([speed * np.cos(angle), speed * np.sin(angle)], abs=1e-10)
    assert final[:2] == pytest.approx(expected[2:], abs=1e-10)
