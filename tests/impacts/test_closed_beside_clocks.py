"""A body at rest on a shaken floor: instants at which something else jumps do not lift it."""

import math

import pytest
import sympy as sp

import symfric as sf

y, w, q, v = sp.symbols("y w q v", real=True)
t = sf.TIME
OMEGA = 2.1
TURN = 2.5 * math.pi / OMEGA  # the floor turns round: it has no speed, and the errors of the run are all there is


def shaken(clock, instant, kick=sp.S.Zero, gap=None):
    """Return a scene of the body and of another one, to which something happens at an instant."""
    held, resets, force = [], [], 0
    if clock == "reset":
        resets = [sf.Reset(at=[instant], set={v: v + 1, w: w + kick})]
    else:
        delay = instant / 11 * 1.4 if clock == "delayed" else 0
        held = [sf.Held("command", update=-q, every=instant / 11, delay=delay)]
        force = held[0].symbol
    floor = sf.Unilateral(y - sp.sin(OMEGA * t) / 10 if gap is None else gap, restitution=0.3)
    system = sf.System([y, q], [w, v], sp.eye(2), [-1, force])
    contacts = [sf.Contact("floor", slip=None, normal=floor)]
    outputs = {"end": sf.End(), "events": sf.Events()}
    return sf.Scene(system, contacts, {}, {y: 0.3, w: 0, q: 1, v: 0}, 6.0, outputs, held=held, resets=resets)


def kinds(run):
    return [e.kind for e in run.checked().events if e.kind != "impact"]


@pytest.mark.one_in(9)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-10])
@pytest.mark.parametrize("clock", ["sampled", "delayed", "reset"])
@pytest.mark.parametrize("late", [0.0, 1e-6, 1e-3, 1.0])
def test_it_stays_closed(clock, late, tolerance):
    assert kinds(sf.simulate(shaken(clock, TURN + late), tolerance)) == ["close"]


@pytest.mark.parametrize("kick", [0.1, 1e-3])
def test_a_kick_of_its_own_lifts_it(kick):
    run = sf.simulate(shaken("reset", TURN, kick=sp.Float(kick)), 1e-10)
    assert kinds(run)[:2] == ["close", "open"]
    (opened,) = [e.t for e in run.events if e.kind == "open"]
    assert opened == pytest.approx(TURN, abs=1e-12)


def test_a_floor_that_drops_away_leaves_it():
    """Its speed steps down at an instant, and the gap opens; the state of the body is the same before and after."""
    gap = y + sp.Piecewise((0, t < 4), (t - 4, True)) / 10
    run = sf.simulate(shaken("reset", 4.0, gap=gap), 1e-10)
    assert kinds(run) == ["close", "open", "close"]
    landed = next(e.t for e in run.events if e.t > 4.1)
    assert landed == pytest.approx(4.2, abs=1e-10)  # it falls by t^2/2 while the floor sinks by t/10
    assert run.final[0] == pytest.approx(-0.2, abs=1e-10)
