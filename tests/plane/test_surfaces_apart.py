"""Contacts in the plane on surfaces that move apart: not all of them can stick, whatever the forces.

Each scene against the same with friction that rises over a small speed, by SciPy.
"""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf

q = x, y, theta = sp.symbols("x y theta", real=True)
u = v_x, v_y, omega = sp.symbols("v_x v_y omega", real=True)
t = sf.TIME
pytestmark = pytest.mark.filterwarnings("ignore:redundant contacts")
SHAKEN, STILL = (0.3 * sp.sin(1.3 * t), 0), (0, 0)
INERTIA, SPRING = (1.0, 1.0, 0.4), 0.3


def scene(feet, loads, belts, force, horizon):
    """Return a body on feet at places that do not turn, each on a surface of its own velocity."""
    slips = [(v_x - b * omega - m[0], v_y + a * omega - m[1]) for (a, b), m in zip(feet, belts, strict=True)]
    law = sf.laws.coulomb(0.3)
    contacts = [sf.Contact(f"foot {k}", s, N, law) for k, (s, N) in enumerate(zip(slips, loads, strict=True))]
    forces = [f - SPRING * e for f, e in zip(force, q, strict=True)]
    initial = dict.fromkeys((*q, *u), 0.0)
    outputs = {"path": sf.Trajectory(), "events": sf.Events()}
    return sf.Scene(sf.System(q, u, sp.diag(*INERTIA), forces), contacts, {}, initial, horizon, outputs)


def regularised(feet, loads, belts, force, horizon, eps):
    """Return the state at the horizon with friction that rises over the speed eps."""
    pushed = sp.lambdify(t, list(map(sp.sympify, force)))
    moved = [sp.lambdify(t, list(map(sp.sympify, m))) for m in belts]

    def rates(time, state):
        rate = np.array(pushed(time), dtype=float) - SPRING * state[:3]
        for (a, b), N, m in zip(feet, loads, moved, strict=True):
            row = np.array([[1, 0, -b], [0, 1, a]])
            slip = row @ state[3:] - m(time)
            rate -= 0.3 * N / math.hypot(*slip, eps) * row.T @ slip
        return np.concatenate([state[3:], rate / INERTIA])

    return solve_ivp(rates, (0, horizon), np.zeros(6), "Radau", rtol=1e-9, atol=1e-9 * eps).y[:, -1]


BAR = [(-0.7, 0.1), (0.7, -0.1)]
APART = {
    "one foot of two on a shaken table": (BAR, (1, 1.5), (STILL, SHAKEN), (0.05 * sp.sin(t), 0, 0)),
    "clamped between two tables": ([(0, 0), (0, 0)], (1, 1.5), (STILL, SHAKEN), (0.05, 0.02, 0)),
    "three feet": ([*BAR, (0.1, 0.6)], (1, 1.5, 0.8), (STILL, STILL, SHAKEN), (0.05, 0.1, 0)),
    "feet on one table": (BAR, (1, 1.5), (SHAKEN, SHAKEN), (0.05 * sp.sin(t), 0, 0)),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("which", APART)
def test_feet_on_surfaces_that_move_apart_do_not_stick_together(which):
    given = (*APART[which], 3.0)
    run = sf.simulate(scene(*given), tolerance=1e-10).checked()
    assert run.energy_residual() < 1e-8
    errors = [np.max(np.abs(regularised(*given, eps) - run.final)) for eps in (1e-3, 1e-4)]
    assert errors[1] < max(0.35 * errors[0], 1e-6)


@pytest.mark.long(beside="test_feet_on_surfaces_that_move_apart_do_not_stick_together")
@pytest.mark.parametrize("which", APART)
def test_tolerances_agree_on_surfaces_that_move_apart(which):
    loose, run = (sf.simulate(scene(*APART[which], 3.0), tolerance=e).checked() for e in (1e-8, 1e-10))
    assert loose.final == pytest.approx(run.final, abs=1e-6)


def test_surfaces_that_begin_to_move_apart_without_an_acceleration_are_said():
    """No acceleration at the start tells them apart; what is held at rest may not slide unseen."""
    belts = (STILL, (0.3 * (1 - sp.cos(1.3 * t)), 0))
    run = sf.simulate(scene([(0, 0), (0, 0)], (1, 1.5), belts, (0.05, 0.02, 0), 3.0))
    assert run.status is sf.Status.UNDECIDED


@pytest.mark.long(beside="test_feet_on_surfaces_that_move_apart_do_not_stick_together")
@pytest.mark.parametrize("seed", range(2))
def test_a_body_turns_about_the_foot_that_carries_more(seed):
    """Whatever rises, the force of the foot that keeps its place has no part in the start of the other.

    At rest under forces that grow with time, one foot of two gives way, or both: the forces that hold are then at their
    end, and the motion is that of regularised friction.
    """
    rng = np.random.default_rng(seed)
    push = [c * t for c in (*rng.normal(size=2) * 0.15, rng.choice([-1, 1]) * rng.uniform(0.2, 0.4))]
    given = (BAR, (3, 1), (STILL, STILL), push, 2.5)
    loose, run = (sf.simulate(scene(*given), tolerance=e).checked() for e in (1e-8, 1e-10))
    assert loose.final == pytest.approx(run.final, abs=1e-6)
    assert {e.kind for e in run.events} == {"slip"}
    errors = [np.max(np.abs(regularised(*given, eps) - run.final)) for eps in (1e-3, 1e-4)]
    assert errors[1] < max(0.35 * errors[0], 1e-6)


def pile(seed):
    """Return a body on three feet with another on three feet on it, both driven; turns are small."""
    n, m, rng = 6, 6, np.random.default_rng(seed)
    q, u = (sp.symbols(f"{s}:{n}", real=True) for s in "qu")
    masses, springs = rng.uniform(0.6, 1.6, n), rng.uniform(0.1, 1.5, n) * (rng.random(n) < 0.8)
    between = np.append(rng.uniform(0, 0.6, n - 1) * (rng.random(n - 1) < 0.5), 0.0)
    damping, wave = rng.uniform(0, 0.1, n), rng.normal(size=n) * rng.uniform(0.3, 0.9)
    steady, loads, mu = rng.normal(size=n) * 0.15, rng.uniform(0.3, 1.5, m), rng.uniform(0.2, 0.5, m)
    rng.random(m), rng.uniform(0.6, 0.95, m)  # of scenes in which friction drops
    swings = 0.3 * (rng.random(m) < 0.3)
    belt, shake = (rng.normal(size=2) * 0.3 * (rng.random() < p) for p in (0.5, 0.4))
    w = rng.uniform(0.5, 2.5)
    rng.normal()
    moves = rng.random() < 0.7
    initial = np.append(
        rng.normal(size=n) * (0.4 if moves else 0.3), rng.normal(size=n) * 0.6 if moves else np.zeros(n)
    )
    force = [steady[i] + wave[i] * sp.cos(w * t + i) - springs[i] * q[i] - damping[i] * u[i] for i in range(n)]
    for i in range(n - 1):
        force[i] -= between[i] * (q[i] - q[i + 1])
        force[i + 1] += between[i] * (q[i] - q[i + 1])
    angles = [0.3, 2.5, 4.4]
    lower = [(math.cos(a), math.sin(a)) for a in angles]
    contacts = []
    for k in range(m):
        a, b = lower[k % 3]
        if k < 3:
            slip = [
                u[0] - b * u[2] - belt[0] - shake[0] * sp.cos(w * t),
                u[1] + a * u[2] - belt[1] - shake[1] * sp.cos(w * t),
            ]
        else:
            a, b = 0.6 * a, 0.6 * b
            slip = [u[3] - b * u[5] - u[0] + (b - 0.1) * u[2], u[4] + a * u[5] - u[1] - (a + 0.2) * u[2]]
        load = loads[k] * (1 + swings[k] * sp.cos(w * t))
        contacts.append(sf.Contact(f"foot {k}", tuple(slip), load, sf.laws.coulomb(mu[k])))
    system = sf.System(q, u, sp.diag(*masses.tolist()), force)
    start = dict(zip([*q, *u], initial.tolist(), strict=True))
    return sf.Scene(system, contacts, {}, start, 8.0, {"path": sf.Trajectory(), "events": sf.Events()})


@pytest.mark.long(beside="test_feet_on_surfaces_that_move_apart_do_not_stick_together")
@pytest.mark.parametrize("seed", [1, 16])
def test_a_body_turns_about_a_foot_at_rest_on_a_body_that_slides(seed):
    scene = pile(seed)
    loose, run = (sf.simulate(scene, tolerance=e).checked() for e in (1e-9, 1e-11))
    assert loose.final == pytest.approx(run.final, abs=1e-8)
    assert [e.kind for e in loose.events] == [e.kind for e in run.events]
    assert run.energy_residual() < 1e-9
