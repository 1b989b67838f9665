"""Pulses of commanded width against pieces between their edges by SciPy, and derivatives, cycles and other ways."""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric_evidence.event_reference.known_instants import Friction, SteppedSystem

x, u = sp.symbols("x u", real=True)
K, T, d = sp.symbols("K T d", positive=True)
HORIZON, PUSH = 5.01, 2.0


def driven(duty, held, values, horizon=HORIZON, damping=0.0):
    pulses = sf.control.pwm(duty, every=T)
    system = sf.System([x], [u], [[1]], [PUSH * pulses[-1].symbol - x / 2 - damping * u])
    guide = sf.Contact("guide", u, 1, sf.laws.coulomb(0.3, 0.2))
    wanted = {"end": sf.End()}
    return sf.Scene(system, [guide], {T: 0.1, **values}, {x: 0.0, u: 0.0}, horizon, wanted, held=[*held, *pulses])


def pieces(duty, period, horizon=HORIZON):
    """Return the end of a motion whose pulses have a share of the period, known at its start from the state."""
    state = [0.0, 0.0]
    friction = [Friction(np.eye(1)[0], lambda t: 0.0, lambda t: 1.0, 0.3, lambda v: 0.2)]
    for k in range(math.ceil(horizon / period - 1e-9)):
        end = min(max(duty(state), 0.0), 1.0) * period
        force = lambda y, t, piece, memory, end=end: np.array([PUSH * (piece < end) - y[0] / 2])  # noqa: E731
        system = SteppedSystem(np.ones(1), force, friction, [end], [], {})
        state = system.run(state, [min(period, horizon - k * period)])[:, -1]
    return state


COMMANDS = {
    "within its limits": (sp.Max(0, sp.Min(1, K * (1 - x) - u / 2)), lambda s: 2 * (1 - s[0]) - s[1] / 2),
    "beyond them": (K * (1 - x) - u / 2, lambda s: 2 * (1 - s[0]) - s[1] / 2),
    "none or all": ((1 - sp.sign(x - K / 4)) / 2, lambda s: 0.5 * (1 - math.copysign(1, s[0] - 0.5))),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_commanded_width_is_that_of_the_pulses(name):
    update, duty = COMMANDS[name]
    command = sf.Held("command", update, every=T)
    scene = driven(command.symbol, [command], {K: 2.0})
    expected = pieces(duty, 0.1)
    for route in ("taylor", "exact"):
        run = sf.simulate(scene, 1e-12, route).checked()
        assert np.max(np.abs(run.final[:2] - expected)) < 1e-13


@pytest.mark.parametrize("share", [0.0, 1e-9, 0.3, 1 - 1e-6, 1.0, 1.5])
def test_a_known_width_is_that_of_a_piecewise(share):
    pulses = sp.Piecewise((1, sp.Mod(sf.TIME, T) < d * T), (0, True))
    system = sf.System([x], [u], [[1]], [PUSH * pulses - x / 2])
    scene = driven(d, [], {d: share})
    other = replace(scene, system=system, held=[], initial={x: 0.0, u: 0.0}, values={T: 0.1, d: share})
    ends = [sf.simulate(s, 1e-13).checked().final[:2] for s in (scene, other)]
    assert np.max(np.abs(ends[0] - ends[1])) < (1e-13 if share in (0.0, 0.3, 1.0, 1.5) else 1e-11)


def test_derivatives_by_gain_and_period():
    command = sf.Held("command", K * (1 - x) - u / 2, every=T)
    scene = driven(command.symbol, [command], {K: 2.0})
    run, program = sf.simulate(scene, 1e-12, sensitivities=["K", "T"]), sf.prepare(scene, 1e-13)
    for name, value, step in (("K", 2.0, 1e-6), ("T", 0.1, 1e-7)):
        near = [program.run({name: value + s * step}).final for s in (1, -1)]
        difference = (near[0] - near[1]) / (2 * step)
        assert run.sensitivities[name] == pytest.approx(difference, rel=1e-6, abs=1e-6)


def test_a_saw_tooth_may_be_compared_with_the_state_at_every_time():
    scene = driven(K * (1 - x) - u / 2, [], {K: 2.0})
    ends = [sf.simulate(scene, 1e-12, route).checked().final for route in ("taylor", "exact")]
    assert np.max(np.abs(ends[0] - ends[1])) < 1e-13
    sampled = sf.Held("command", K * (1 - x) - u / 2, every=T)
    assert abs(ends[0][0] - sf.simulate(driven(sampled.symbol, [sampled], {K: 2.0})).final[0]) > 1e-3


def test_limit_cycles_and_many_cases():
    command = sf.Held("command", K * (1 - x) - u / 2 + sp.sin(sp.pi * sf.TIME) / 4, every=T, delay=0.15)
    scene = driven(command.symbol, [command], {K: 2.0}, damping=0.2)
    orbit = sf.limit_cycle(scene.until(100.0))
    assert orbit.period == pytest.approx(2.0)
    program = sf.prepare(scene.until(2.0), 1e-13)
    base = dict(zip(orbit.names, orbit.start.tolist(), strict=True))
    end = lambda n, h: program.run({}, {**base, n: base[n] + h}).checked().final  # noqa: E731
    columns = [(end(n, 1e-6) - end(n, -1e-6)) / 2e-6 for n in base]
    expected = np.linalg.eigvals(np.array(columns).T)
    assert np.sum(orbit.multipliers) == pytest.approx(np.sum(expected), abs=1e-6)
    gains = np.linspace(1, 3, 5)
    batch = program.map({"K": gains})
    ends = np.array([program.run({"K": float(k)}).final for k in gains]).T
    assert np.array_equal(batch.outputs["end"], ends)
