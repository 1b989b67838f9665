"""Two scenes that do not touch, as one scene: each moves as it does alone, with every feature beside every other."""

import itertools
from functools import cache

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer

t = sf.TIME
HORIZON, TOLERANCE = 6.0, 1e-10
TIMES = [1.5, 4.7, HORIZON]


def symbols(name, *letters):
    return [sp.Symbol(f"{letter}_{name}", real=True) for letter in letters]


def one_body(name, force, start, *, contact=None, mass=1, **more):
    """Return a scene of one coordinate; `contact` is slip, normal load and law."""
    x, u = symbols(name, "x", "u")
    contacts = [sf.Contact(f"contact {name}", *contact)] if contact else []
    system = sf.System([x], [u], [[mass]], [force])
    return sf.Scene(system, contacts, initial=dict(zip((x, u), start, strict=True)), horizon=HORIZON, **more)


def belt(name):
    (x, u), v_b = symbols(name, "x", "u"), sp.Symbol(f"v_{name}", positive=True)
    contact = (u - v_b, 1, sf.laws.stribeck(0.4, 0.25, 0.5))
    return one_body(name, -x - 0.05 * u, (0.1, 0), contact=contact, values={v_b: 0.2})


def ball_on_a_shaken_floor(name):
    (x,), e = symbols(name, "x"), sp.Symbol(f"e_{name}", positive=True)
    floor = sf.Unilateral(x - 0.05 * sp.sin(3 * t), restitution=e)
    return one_body(name, -1, (0.4, 0), contact=(None, floor), values={e: 0.7})


def ball_that_comes_to_rest(name):
    (x,), e = symbols(name, "x"), sp.Symbol(f"e_{name}", positive=True)
    return one_body(name, -1, (0.3, 0), contact=(None, sf.Unilateral(x, restitution=e)), values={e: 0.5})


def block_on_a_shaken_floor(name):
    (x, y, u, w), mu = symbols(name, "x", "y", "u", "w"), sp.Symbol(f"mu_{name}", positive=True)
    floor = sf.Unilateral(y - 0.1 * sp.sin(2.1 * t), restitution=0.3)
    contact = sf.Contact(f"contact {name}", u - 0.3, floor, sf.laws.coulomb(mu))
    system = sf.System([x, y], [u, w], sp.eye(2), [-0.5 * x, -1])
    return sf.Scene(system, [contact], {mu: 0.35}, {x: 0, y: 0.5, u: 0.6, w: 0}, HORIZON)


def sampled_controller(name):
    (x, u), k = symbols(name, "x", "u"), sp.Symbol(f"k_{name}", positive=True)
    command = sf.Held(f"command {name}", update=-k * x - 0.5 * u, every=0.17, delay=0.23)
    contact = (u, 0.1, sf.laws.coulomb(0.5, 0.3))
    return one_body(name, command.symbol - 0.2 * x, (0.8, 0), contact=contact, values={k: 1.3}, held=[command])


def relay_with_dead_time(name):
    (x, u), b = symbols(name, "x", "u"), sp.Symbol(f"b_{name}", positive=True)
    relay = sf.Held(f"relay {name}", update=-b * sp.sign(x), when=x, delay=0.2, initial=-0.5)
    return one_body(name, relay.symbol - 0.4 * u, (0.5, 0.1), values={b: 0.5}, held=[relay])


def reset_at_a_crossing(name):
    (x, u), r = symbols(name, "x", "u"), sp.Symbol(f"r_{name}", positive=True)
    bounce = sf.Reset(guard=x + 0.2, set={u: -r * u})
    return one_body(name, -1.1 * x, (0.5, 0), values={r: 0.8}, resets=[bounce])


def kicks(name):
    (x, u), period = symbols(name, "x", "u"), sp.Symbol(f"T_{name}", positive=True)
    kick = sf.Reset(every=period, offset=0.3, set={u: u + 0.7})
    contact = (u - 0.1 * x, 1, sf.laws.coulomb(0.2, 0.1))
    return one_body(name, -x, (0, 0), contact=contact, values={period: 1.73}, resets=[kick])


def block_in_the_plane(name):
    (x, y, u, w), mu = symbols(name, "x", "y", "u", "w"), sp.Symbol(f"mu_{name}", positive=True)
    contact = sf.Contact(f"contact {name}", (u - 0.2, w), 1, sf.laws.coulomb(mu, 0.2))
    system = sf.System([x, y], [u, w], sp.eye(2), [0.3 * sp.sin(1.3 * t) - 0.9 * x, -0.6 * y - 0.1])
    return sf.Scene(system, [contact], {mu: 0.25}, {x: 0.3, y: -0.4, u: 0, w: 0.3}, HORIZON)


def lugre(name):
    (x, u), mu = symbols(name, "x", "u"), sp.Symbol(f"mu_{name}", positive=True)
    contact = (u, 1, sf.laws.lugre(mu, 0.25, 0.1, 50.0, sigma1=0.5))
    return one_body(name, 0.4 * sp.cos(t) - x, (0.6, 0), contact=contact, values={mu: 0.4})


def dahl(name):
    (x, u), sigma = symbols(name, "x", "u"), sp.Symbol(f"sigma_{name}", positive=True)
    contact = (u, 0.2, sf.laws.dahl(0.5, sigma))
    return one_body(name, -x, (1.2, 0), contact=contact, values={sigma: 30.0})


def bouc_wen(name):
    (x, u), k = symbols(name, "x", "u"), sp.Symbol(f"k_{name}", positive=True)
    contact = (u, 0.2, sf.laws.bouc_wen(0.5, 30.0, 10.0, 1))
    return one_body(name, -k * x, (1.2, 0), contact=contact, values={k: 1.0})


def maxwell_slip(name):
    (x, u), k = symbols(name, "x", "u"), sp.Symbol(f"k_{name}", positive=True)
    contact = (u, 1, sf.laws.maxwell_slip([3.0, 2.0], [0.1, 0.15]))
    return one_body(name, -k * x, (1.2, 0), contact=contact, values={k: 1.0})


def steps_in_time(name):
    (x, u), t_on = symbols(name, "x", "u"), sp.Symbol(f"t_{name}", positive=True)
    force = -x - 0.1 * u + 0.5 * sp.Piecewise((1, t < t_on), (0, True))
    contact = (u - sp.Piecewise((0.1, t < 3), (-0.1, True)), 1, sf.laws.coulomb(0.2))
    return one_body(name, force, (0.1, 0), contact=contact, values={t_on: 2.3})


def sampled_force(name):
    (x, u, a), c = symbols(name, "x", "u", "a"), sp.Symbol(f"c_{name}", positive=True)
    record = sf.Signal(0.8 * np.sin(0.37 * np.arange(60)), 0.1)
    contact = (u, 1, sf.laws.coulomb(0.15, 0.1))
    return one_body(name, a - x - c * u, (0.1, 0), contact=contact, values={c: 0.1}, inputs={a: record})


def stop_of_rubber(name):
    (x, u), k = symbols(name, "x", "u"), sp.Symbol(f"k_{name}", positive=True)
    force = -x - k * sp.Max(0, x - 0.2) - x * u**2 / 2
    contact = (u, 0.3 + 0.1 * sp.Abs(x), sf.laws.stribeck(0.3, 0.2, 0.1))
    return one_body(name, force, (1.2, 0), contact=contact, mass=1 + x**2 / 2, values={k: 5.0})


def cells_of_a_floor(name):
    (x, u), m = symbols(name, "x", "u"), sp.Symbol(f"m_{name}", positive=True)
    profile = sp.Piecewise((0.5, x < 0.3), (1.5, True))
    contact = (u, 1, sf.laws.coulomb(0.2), profile)
    return one_body(name, -x / 10, (0, 0.42), contact=contact, mass=m, values={m: 1.0})


def state_of_a_controller(name):
    (x, u, z), k = symbols(name, "x", "u", "z"), sp.Symbol(f"k_{name}", positive=True)
    system = sf.System([x], [u], [[1]], [-x - z - 0.4 * u], z=[z], z_rate=[k * x])
    contact = sf.Contact(f"contact {name}", u, 0.2, sf.laws.coulomb(0.4, 0.2))
    return sf.Scene(system, [contact], {k: 0.2}, {x: 0.7, u: 0, z: 0}, HORIZON)


PARTS = {
    made.__name__: made
    for made in (
        ball_on_a_shaken_floor,
        ball_that_comes_to_rest,
        belt,
        block_in_the_plane,
        block_on_a_shaken_floor,
        bouc_wen,
        cells_of_a_floor,
        dahl,
        kicks,
        lugre,
        maxwell_slip,
        relay_with_dead_time,
        reset_at_a_crossing,
        sampled_controller,
        sampled_force,
        state_of_a_controller,
        steps_in_time,
        stop_of_rubber,
    )
}


REFUSED = ("block_in_the_plane", "cells_of_a_floor")  # a profile that jumps stands beside no contact in the plane
PAIRS = [pair for pair in itertools.combinations(PARTS, 2) if pair != REFUSED]


def watched(scene):
    """Return outputs of every coordinate."""
    kinds = {"max": sf.Max, "square": lambda x: sf.Integral(x**2), "samples": lambda x: sf.Samples(x, TIMES)}
    return {f"{kind} of {x}": made(x) for x in scene.system.q for kind, made in kinds.items()}


def beside(*scenes):
    """Return one scene of several that have nothing in common."""
    systems = [scene.system for scene in scenes]
    together = {name: [e for s in systems for e in getattr(s, name)] for name in ("q", "u", "force")}
    for name in ("z", "z_rate"):  # without those that contacts and held variables add
        together[name] = [e for s in systems for e in getattr(s, name)[: len(s.z) - s.made]]
    system = sf.System(mass=sp.diag(*(sp.Matrix(s.mass) for s in systems)), **together)
    listed = {name: [e for s in scenes for e in getattr(s, name)] for name in ("contacts", "held", "resets")}
    mapped = {
        name: {k: v for s in scenes for k, v in getattr(s, name).items()} for name in ("values", "initial", "inputs")
    }
    outputs = {name: output for scene in scenes for name, output in watched(scene).items()}
    return sf.Scene(system, horizon=HORIZON, outputs=outputs, **listed, **mapped)


@cache
def alone(name):
    scene = PARTS[name](name)
    (parameter,) = (symbol.name for symbol in scene.values)
    return scene, parameter, sf.simulate(beside(scene), TOLERANCE, sensitivities=[parameter]).checked()


def differences(found, right):
    """Return the largest differences of final states and outputs, and of their derivatives, from those alone."""
    parameter = next(iter(right.sensitivities))
    places = [found.names.index(name) for name in right.names]
    plain = [found.final[places] - right.final, *(found.outputs[n] - e for n, e in right.outputs.items())]
    derived = [found.sensitivities[parameter][places] - right.sensitivities[parameter]]
    slopes = right.output_sensitivities[parameter]
    derived += [found.output_sensitivities[parameter][n] - e for n, e in slopes.items()]
    return [max(float(np.max(np.abs(e))) for e in es) for es in (plain, derived)]


def check(first, second):
    scenes, parameters, runs = zip(alone(first), alone(second), strict=True)
    scene = beside(*scenes)
    run = sf.simulate(scene, TOLERANCE, sensitivities=parameters).checked()
    assert run.stats["events"] == sum(right.stats["events"] for right in runs)
    for right in runs:
        plain, derived = differences(run, right)
        assert plain < 1e-8
        assert derived < 1e-6
    values = {symbol.name: np.full(2, float(value)) for symbol, value in scene.values.items()}
    program = sf.prepare(scene, TOLERANCE)
    cases, single = program.map(values=values), program.run()
    assert np.array_equal(cases.final[:, 1], single.final)
    assert all(np.array_equal(cases.outputs[name][..., 1], e) for name, e in single.outputs.items())


@pytest.mark.long(beside="test_pairs")
def test_in_the_plane_beside_a_single_clock():
    check("block_in_the_plane", "kicks")


@pytest.mark.one_in(154)
@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_pairs(first, second):
    check(first, second)


@pytest.mark.long(beside="test_pairs")
def test_a_profile_that_jumps_is_refused_in_the_plane():
    with pytest.raises(sf.SceneError, match="profile of contact 'contact cells_of_a_floor' jumps; beside contact"):
        beside(*(alone(name)[0] for name in REFUSED))


@pytest.mark.long(beside="test_pairs")
@pytest.mark.parametrize("law", longer(["bouc_wen", "dahl", "lugre"], ["dahl", "lugre"]))
def test_in_the_plane_beside_laws_with_memory(law):
    """Their slips turn round without sticking, also where contacts in the plane are decided together."""
    check("block_in_the_plane", law)


@pytest.mark.long(beside="test_pairs")
@pytest.mark.parametrize("beside_of", ["plane", "floor"])
def test_many_kinks_at_one_instant(beside_of):
    """Each kink starts on the side of its velocity, also beside contacts whose modes are tried one after the other."""
    x = sp.symbols("x:12", real=True)
    u = sp.symbols("u:12", real=True)
    kinks = [-a - 0.3 * sp.Abs(a) - 0.2 * sp.Abs(b) for a, b in zip(x, u, strict=True)]
    start = dict.fromkeys(x, 0) | dict.fromkeys(u, -0.5)
    many = sf.Scene(sf.System(x, u, sp.eye(12), kinks), initial=start, horizon=HORIZON)
    one = sf.Scene(sf.System(x[:1], u[:1], [[1]], kinks[:1]), initial={x[0]: 0, u[0]: -0.5}, horizon=HORIZON)
    other = PARTS["block_in_the_plane" if beside_of == "plane" else "ball_that_comes_to_rest"]("other")
    run = sf.simulate(beside(many, other), TOLERANCE).checked()
    right = sf.simulate(one, TOLERANCE).checked()
    for k, name in enumerate(right.names):
        places = [run.names.index(f"{name[0]}{i}") for i in range(12)]
        assert run.final[places] == pytest.approx(np.full(12, right.final[k]), abs=1e-8)
