"""The foreign reference of events at known times: right in closed form, and sharp enough to see a wrong one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from symfric_evidence.event_reference.known_instants import Friction, Instant, NoAnswer, SteppedSystem, stairs
from symfric_evidence.stress import InstantsComparison, instants_comparison
from tests.longer import longer


def slider(force, *, load=1.0, steps=(), instants=(), static=0.5, kinetic=0.4):
    """Return a mass without spring on the ground."""
    contact = Friction(np.array([1.0]), lambda t: 0.0, lambda t: load, static, lambda v: kinetic)
    return SteppedSystem(
        np.array([1.0]),
        lambda y, t, piece, memory: np.array([force(piece) + memory["c"]]),
        [contact],
        steps,
        instants,
        {"c": 0.0},
    )


def test_a_step_sets_a_mass_in_motion_and_friction_stops_it():
    # at rest until t = 1, then a = 0.6 for 2 s, then -0.4 until it rests after 3 s
    system = slider(stairs(0.45, [(1.0, 0.55), (3.0, -1.0)]), steps=(1.0, 3.0))
    found = system.run([0.0, 0.0], [0.9, 3.0, 5.0, 9.0])
    assert np.allclose(found[1], [0.0, 1.2, 0.4, 0.0], atol=1e-12)
    assert np.allclose(found[0], [0.0, 1.2, 1.2 + 2.4 - 0.8, 1.2 + 1.8], atol=1e-12)


def test_instants_of_one_time_keep_their_order():
    def put(value):
        return lambda y, memory: memory.update(c=value(memory["c"]))

    instants = [Instant(1.0, 1, put(lambda c: 2 * c)), Instant(1.0 + 1e-13, 0, put(lambda c: c + 0.7))]
    found = slider(lambda t: 0.0, instants=instants).run([0.0, 0.0], [2.0])
    assert found[1, 0] == pytest.approx(1.0, abs=1e-12)  # (0.7 * 2 - 0.4) for 1 s


def test_a_kick_and_a_reversal():
    kick = Instant(0.5, 2, lambda y, memory: y.__setitem__(1, y[1] - 1.0))
    found = slider(lambda t: 0.0, instants=[kick]).run([0.0, 0.4], [0.5, 1.0, 4.0])
    assert np.allclose(found[1], [0.2, -0.6, 0.0], atol=1e-12)
    assert found[0, -1] == pytest.approx(0.15 - 0.8, abs=1e-12)


def test_forces_that_are_no_numbers_are_said():
    with pytest.raises(NoAnswer):
        slider(lambda t: math.nan).run([0.0, 1.0], [1.0])


SEEN = [(3, "tF1", 1e-4), (2, "tF1", 1e-4), (29, "K", 1e-4)]  # seed of the structure, what is changed and by how much


@pytest.mark.parametrize("shorter", longer([(), instants_comparison._SHORTER], [instants_comparison._SHORTER]))
@pytest.mark.parametrize("case", longer(SEEN, SEEN[1:]))
def test_a_small_difference_is_seen(monkeypatch, case, shorter):
    monkeypatch.setattr(instants_comparison, "_SHORTER", shorter)  # steps by which the reference is tried again
    seed, name, change = case
    comparison = InstantsComparison("instants", seed)
    found = comparison.verdict(1)
    assert found.verdict == "agrees"
    assert found.second < 1e-8
    reference = comparison.plan.reference

    def otherwise(plan, draw):
        assert name in draw.values
        return reference(replace(draw, values=draw.values | {name: draw.values[name] + change}))

    monkeypatch.setattr(type(comparison.plan), "reference", otherwise)
    assert comparison.verdict(1).verdict == "silent failure"
