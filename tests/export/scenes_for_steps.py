"""Small scenes of every kind that a step of fixed length takes."""

import sympy as sp

import symfric as sf

x, u, x2, u2 = sp.symbols("x u x2 u2", real=True)
v_b, k, a_g = sp.symbols("v_b k a_g", positive=True)
PUSH = -x + sp.cos(sp.Rational(13, 10) * sf.TIME) / 2
COULOMB = sf.laws.coulomb(0.3)


def one(force, contacts=(), values=None, start=1.0, **more):
    system = sf.System([x], [u], [[1]], [force])
    return sf.Scene(system, contacts, values or {}, {x: start, u: 0.0}, 12.0, **more)


def floor(law, **more):
    return [sf.Contact("floor", slip=u, normal=1, law=law, **more)]


def pair(first):
    system = sf.System([x, x2], [u, u2], [[1, 0], [0, sp.Rational(3, 2)]], [-x - k * (x - x2), -x2 - k * (x2 - x)])
    belt = sf.Contact("belt", slip=u2 - v_b, normal=1.5, law=sf.laws.stribeck(0.4, 0.25, 0.2))
    return sf.Scene(system, [first, belt], {v_b: 0.1, k: 1.3}, {x: 0.5, u: 0, x2: 0, u2: 0.05}, 12.0)


def commanded(*updates, force=PUSH, slip=u, load=1, resets=()):
    """Return a mass with held variables c1, c2, ... in its force, slip or load."""
    held = [sf.Held(f"c{n + 1}", *update) for n, update in enumerate(updates)]
    floor = sf.Contact("floor", slip=slip, normal=load, law=sf.laws.stribeck(0.4, 0.3, 0.2))
    return one(force, [floor], held=held, resets=resets)


def watched(*held, force=PUSH, resets=(), start=1.0, friction=0.3):
    """Return a mass with held variables and resets at crossings of zero."""
    return one(force, floor(sf.laws.coulomb(friction)), start=start, held=held, resets=resets)


def after(time, before, later):
    return sp.Piecewise((before, sf.TIME < time), (later, True))


def stepping():
    """Return two masses on belts that step at ends of steps of fixed length, the load and the law of one step, too."""
    law = sf.laws.coulomb(after(7, 0.4, 0.5), 0.3)
    first = sf.Contact("a", slip=u - u2 - after(3.1, 0.2, -0.3), normal=after(5.05, 1, 0.4), law=law)
    second = sf.Contact("b", slip=u2 - sp.sin(sf.TIME) / 8 - after(2, 0, 0.2), normal=0.5, law=sf.laws.coulomb(0.4))
    scene = pair(first)
    return sf.Scene(scene.system, [first, second], {k: 1.3}, scene.initial, 12.0)


SQUARE = sf.Contact(
    "a",
    slip=u - sp.sign(sp.sin(sf.TIME)) / 4,
    normal=1 + sp.Piecewise((1, sp.Mod(sf.TIME, 1) < 0.3), (0, True)),
    law=sf.laws.stribeck(0.4, 0.3, 0.1),
)
C1, C2 = sp.symbols("c1 c2", real=True)
C1_BEFORE = sp.Symbol("c1.previous", real=True)
SENT = sp.Symbol("sent", real=True)
RELAY = sf.Held(
    "relay", (sp.Symbol("relay.previous", real=True) - 8 * sp.sign(x - 0.1)) / 4, when=x - 0.1, delay=1.1, waiting=4
)
BOUNCE = sf.Reset(guard=x, set={u: -sp.Rational(4, 5) * u})
WAVE = sf.Signal([0.0, 1.0, -1.0, 0.5, -0.5, 0.8, 0.0] * 2, dt=0.8)
SHAKEN = sf.Contact(
    "table", slip=u - sp.cos(sf.TIME) / 3, normal=1 + sp.sin(2 * sf.TIME) / 2, law=sf.laws.coulomb(0.7, 0.5)
)
SCENES = {
    "belt": sf.scenes.mass_on_belt(v_b=0.2, horizon=12.0),
    "drop after rest": one(-x - u / 10 + sp.cos(1.3 * sf.TIME), floor(sf.laws.coulomb(0.3, 0.2))),
    "kink": one(-x - u / 10 - 10 * sp.Max(0, x - 0.3) + sp.cos(1.2 * sf.TIME)),
    "two slides": sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=1, fs1=7.8).until(12.0),
    "dahl": one(PUSH, floor(sf.laws.dahl(0.3, 20.0))),
    "sliders": one(PUSH, floor(sf.laws.maxwell_slip([10.0, 5.0], [0.1, 0.2]))),
    "behind a spring": one(PUSH, floor(COULOMB, stiffness=20.0)),
    "moving table": one(PUSH, [SHAKEN]),
    "pad between masses": pair(sf.Contact("pad", slip=u - u2, normal=0.3, law=sf.laws.stribeck(0.5, 0.3, 0.2))),
    "two belts": pair(sf.Contact("other", slip=u - v_b, normal=1, law=sf.laws.cubic(0.5, 0.3, 0.2))),
    "record": one(-x - u / 10 + a_g, floor(COULOMB), inputs={a_g: WAVE}),
    "sampled": commanded((-2 * x - u + C1_BEFORE / 4, 0.4), force=PUSH + C1),
    "late samples": commanded((-x - u, 0.4, 0.01, 1.0), (-C1 / 2 + sp.Max(0, x), 1.2, 0.02, 0.3), force=PUSH + C1 + C2),
    "rounded samples": commanded((-2 * x - u, 0.35, 0.0, 0.1, 0.0, 0.01), force=PUSH + C1),
    "commanded belt": commanded((sp.sign(sp.sin(sf.TIME)) / 3, 0.33), force=-x / 4, slip=u - C1),
    "commanded load": commanded((1 + sp.sin(sf.TIME) ** 2, 0.33), load=1 + C1 / 2),
    "kicked": commanded(
        resets=[
            sf.Reset(at=[0, 1.234, 3, 6], set={u: [u + 1, -u, 0, u - 1]}),
            sf.Reset(every=2, offset=0.5, set={x: x + 0.1}),
        ]
    ),
    "late relay": watched(RELAY, force=-2 * x + RELAY.symbol),
    "sent on change": watched(sf.Held("sent", update=x, when=sp.Abs(x - SENT) - 0.1), force=PUSH - SENT / 2),
    "escapement": watched(force=-x - u / 10, resets=[sf.Reset(guard=x, set={u: u - 0.3})], friction=0.05),
    "bouncing": watched(force=-x - 3 - sp.cos(sf.TIME), resets=[BOUNCE], friction=0.01).until(2.5),
    "put back": watched(resets=[sf.Reset(guard=x - 0.2, set={x: x + 0.3})]),
    "kicked while it sticks": watched(resets=[sf.Reset(guard=sp.sin(sf.TIME), set={u: u + 0.4})]),
    "two at one zero": watched(
        RELAY,
        force=PUSH + RELAY.symbol / 3,
        resets=[sf.Reset(guard=x - 0.1, set={u: u - 0.3}), sf.Reset(every=1, offset=0.3, set={x: x - 0.2})],
    ),
    "belts that step": stepping(),
    "square waves": one(-x / 4, [SQUARE], start=0.1),
}
