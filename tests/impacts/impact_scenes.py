"""Random scenes of one to four contacts that open: structures with the numbers they take, for the package and the reference."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

import symfric as sf
from tests.impacts.impact_reference import Bodies, Equations, T, Touch

X, Y, TH, U, V, OM = sp.symbols("x y th u v om", real=True)
E1, E2, MU, MU2, G, GX, A, W, K, D = sp.symbols("e e2 mu mu2 g g_x A w k d", nonnegative=True)


@dataclass(frozen=True)
class Structure:
    """Bodies, and how their numbers are drawn: ``draw(rng) -> (values, start)`` by name, with a horizon."""

    name: str
    bodies: Bodies
    draw: Callable
    horizon: float

    @cached_property
    def equations(self):
        return Equations(self.bodies)

    def scene(self, values, start, order=None):
        """Return the scene; `order` permutes its contacts."""
        b = self.bodies
        states = [*b.q, *b.u]
        touches = b.touches if order is None else [b.touches[i] for i in order]
        clock = {T: sf.TIME}
        contacts = []
        for c in touches:
            normal = c.load if c.gap is None else sf.Unilateral(c.gap.subs(clock), restitution=c.e)
            slip = None if c.slip is None else c.slip.subs(clock)
            law = (
                None
                if slip is None
                else sf.laws.coulomb(c.sticks, c.mu)
                if c.mu_s is not None
                else sf.laws.coulomb(c.mu)
            )
            contacts.append(sf.Contact(c.name, slip, normal, law) if law else sf.Contact(c.name, slip, normal))
        system = sf.System(b.q, b.u, b.mass.tolist(), [f.subs(clock) for f in b.force])
        return sf.Scene(
            system,
            contacts,
            {p: values[p.name] for p in b.parameters},
            dict(zip(states, start, strict=True)),
            self.horizon,
        )

    def numbers(self, values):
        return [values[p.name] for p in self.bodies.parameters]


def restitution(rng):
    """Return a restitution, often one of its ends."""
    return float(rng.choice([0.0, 0.5, 1.0, rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 1)]))


def friction(rng):
    """Return a coefficient, sometimes none."""
    return float(rng.choice([0.0, 0.3, rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 1)]))


def made(name, q, u, mass, force, touches, parameters, draw, horizon):
    bodies = Bodies(list(q), list(u), sp.Matrix(mass), sp.Matrix(force), touches, list(parameters))
    return Structure(name, bodies, draw, horizon)


def ball_on_slope():
    floor = Touch("floor", Y, U + OM, E1, MU)

    def draw(rng):
        v = {"e": restitution(rng), "mu": friction(rng), "g_x": rng.uniform(-4, 4)}
        return v, [
            0,
            rng.choice([0.0, rng.uniform(0.05, 1)]),
            0,
            rng.uniform(-3, 3),
            rng.uniform(-2, 2) ** 2,
            rng.uniform(-3, 3),
        ]

    mass = sp.diag(1, 1, sp.Rational(2, 5))
    return made("ball_on_slope", [X, Y, TH], [U, V, OM], mass, [GX, -9.81, 0], [floor], [E1, MU, GX], draw, 2.0)


def ball_on_shaken_floor():
    floor = Touch("floor", Y - A * sp.sin(W * T), U + OM - 2 * A * W * sp.cos(W * T), E1, MU)

    def draw(rng):
        w = rng.uniform(5, 30)
        a = rng.uniform(0, 2.5) * 9.81 / w**2
        v = {"e": restitution(rng), "mu": friction(rng), "A": a, "w": w}
        rests = rng.random() < 0.4
        return v, [0, 0 if rests else rng.uniform(0.02, 0.3), 0, rng.uniform(-1, 1), a * w if rests else 0, 0]

    mass = sp.diag(1, 1, sp.Rational(1, 2))
    return made("ball_on_shaken_floor", [X, Y, TH], [U, V, OM], mass, [0, -9.81, 0], [floor], [E1, MU, A, W], draw, 1.0)


def sticky_block_on_shaken_floor():
    """A vibratory conveyor: static friction above the sliding one."""
    floor = Touch("floor", Y - A * sp.sin(W * T), U - A * W * sp.cos(W * T), E1, MU, MU + MU2)

    def draw(rng):
        w = rng.uniform(10, 40)
        a = rng.uniform(0, 1.8) * 9.81 / w**2
        v = {"e": restitution(rng), "mu": friction(rng), "mu2": rng.choice([0, rng.uniform(0, 0.3)]), "A": a, "w": w}
        return v, [0, 0, a * w + rng.choice([0, 0.2]), a * w]

    return made("sticky_block", [X, Y], [U, V], sp.eye(2), [0, -9.81], [floor], [E1, MU, MU2, A, W], draw, 0.8)


def disk_in_corner():
    floor = Touch("floor", Y, U + OM, E1, MU)
    wall = Touch("wall", 1 - X, V + OM, E2, MU2)

    def draw(rng):
        v = {"e": restitution(rng), "e2": restitution(rng), "mu": friction(rng), "mu2": friction(rng)}
        at = rng.choice(["rests", "flies", "hits both"])
        if at == "hits both":
            return v, [0, 1, 0, 2, -2 + 9.81 / 4, rng.uniform(-2, 2)]  # after half a unit of time
        return v, [0, 0 if at == "rests" else rng.uniform(0.1, 1), 0, rng.uniform(0.5, 4), 0, rng.uniform(-3, 3)]

    mass = sp.diag(1, 1, sp.Rational(1, 2))
    return made(
        "disk_in_corner", [X, Y, TH], [U, V, OM], mass, [0, -9.81, 0], [floor, wall], [E1, E2, MU, MU2], draw, 1.5
    )


def disk_in_box():
    touches = [
        Touch("floor", Y, U + OM, E1, MU),
        Touch("right", 1 - X, V + OM, E1, MU),
        Touch("left", 1 + X, -V + OM, E1, MU),
        Touch("ceiling", 1 - Y, -U + OM, E1, MU),
    ]

    def draw(rng):
        v = {"e": restitution(rng), "mu": friction(rng), "g": rng.choice([0, 9.81])}
        return v, [
            rng.uniform(-0.5, 0.5),
            rng.uniform(0.1, 0.6),
            0,
            rng.uniform(-4, 4),
            rng.uniform(-2, 2),
            rng.uniform(-3, 3),
        ]

    mass = sp.diag(1, 1, sp.Rational(1, 2))
    return made("disk_in_box", [X, Y, TH], [U, V, OM], mass, [0, -G, 0], touches, [E1, MU, G], draw, 1.0)


def rod_above_floor():
    s = sp.sin(TH)
    touches = [
        Touch("left", Y - s / 2, U + OM * s / 2, E1, MU),
        Touch("right", Y + s / 2, U - OM * s / 2, E1, MU),
    ]

    def draw(rng):
        v = {"e": restitution(rng), "mu": float(rng.choice([0.0, 0.3, rng.uniform(0, 1)]))}
        th = rng.choice([0.0, rng.uniform(-1.2, 1.2)])
        return v, [
            0,
            0.5 * abs(np.sin(th)) + rng.choice([0.0, rng.uniform(0.05, 0.5)]),
            th,
            rng.uniform(-2, 2),
            0,
            rng.uniform(-2, 2) * (th != 0),
        ]

    mass = sp.diag(1, 1, sp.Rational(1, 12))
    return made("rod_above_floor", [X, Y, TH], [U, V, OM], mass, [0, -9.81, 0], touches, [E1, MU], draw, 0.7)


def corners(half_width, half_height, shake):
    """Return gaps and slips of the lower corners of a block against a floor that moves sideways."""
    s, c = sp.sin(TH), sp.cos(TH)
    out = []
    for side in (-1, 1):
        dx, dy = side * half_width, -half_height
        gap = Y + dx * s + dy * c
        slip = U - OM * (dx * s + dy * c) - shake
        out.append((gap, slip))
    return out


def block_on_shaken_floor():
    (gl, sl), (gr, sr) = corners(sp.Rational(1, 5), sp.Rational(1, 2), A * W * sp.cos(W * T))
    touches = [Touch("left", gl, sl, E1, MU), Touch("right", gr, sr, E1, MU)]

    def draw(rng):
        w = rng.uniform(5, 20)
        v = {
            "e": float(rng.choice([0.0, 0.0, rng.uniform(0, 0.9)])),
            "mu": rng.uniform(0.05, 1.0),
            "A": rng.uniform(0, 8) / w**2,
            "w": w,
        }
        th = rng.choice([0.0, rng.uniform(-0.2, 0.2)])
        y = 0.5 * np.cos(th) + 0.2 * abs(np.sin(th))
        return v, [0, y, th, rng.choice([0.0, rng.uniform(-1, 1)]), 0, 0]

    mass = sp.diag(1, 1, sp.Rational(29, 300))
    return made(
        "block_on_shaken_floor", [X, Y, TH], [U, V, OM], mass, [0, -9.81, 0], touches, [E1, MU, A, W], draw, 0.8
    )


def oscillator_between_stops():
    touches = [Touch("low", X + 1, None, E1), Touch("high", D - X, None, E2)]

    def draw(rng):
        v = {
            "e": restitution(rng),
            "e2": restitution(rng),
            "A": rng.uniform(0, 4),
            "w": rng.uniform(0.3, 3),
            "d": rng.choice([0.0, 1.0, 0.5]),
        }
        return v, [rng.uniform(-1, 0), rng.uniform(-3, 3)]

    return made("oscillator", [X], [U], [[1]], [-X - U / 10 + A * sp.cos(W * T)], touches, [E1, E2, A, W, D], draw, 8.0)


def dry_oscillator_with_stop():
    touches = [
        Touch("stop", X + sp.Rational(1, 2), None, E1),
        Touch("pad", None, U - sp.Rational(1, 5), load=sp.S.One, mu=MU),
    ]

    def draw(rng):
        v = {"e": restitution(rng), "mu": friction(rng), "A": rng.uniform(0, 2), "w": rng.uniform(0.3, 3)}
        return v, [rng.uniform(-0.5, 1), rng.uniform(-2, 2)]

    return made("dry_oscillator", [X], [U], [[1]], [-X + A * sp.cos(W * T)], touches, [E1, MU, A, W], draw, 8.0)


def chain_with_stops():
    x, u = sp.symbols("x:3", real=True), sp.symbols("u:3", real=True)
    touches = [
        Touch("between 0 1", x[1] - x[0] + sp.Rational(1, 5), None, E1),
        Touch("between 1 2", x[2] - x[1] + sp.Rational(1, 5), None, E2),
        Touch("wall", D - x[2], None, E1),
        Touch("pad", None, u[1], load=sp.S.One, mu=MU),
    ]
    force = [-K * x[0] + A * sp.cos(W * T), -K * x[1], -K * x[2]]

    def draw(rng):
        v = {"e": restitution(rng), "e2": restitution(rng), "mu": friction(rng), "k": rng.uniform(0.3, 2)}
        v |= {"A": rng.uniform(0, 2), "w": rng.uniform(0.5, 3), "d": rng.uniform(0, 0.5)}
        return v, [0, 0, 0, *rng.uniform(-1, 1, 3)]

    return made("chain", x, u, sp.diag(1, 2, 1), force, touches, [E1, E2, MU, K, A, W, D], draw, 4.0)


def equal_balls_in_a_row():
    """Newton's cradle: several at once, equal and unequal masses."""
    x, u = sp.symbols("x:4", real=True), sp.symbols("u:4", real=True)
    m = sp.Symbol("m", positive=True)
    touches = [Touch(f"{i} {i + 1}", x[i + 1] - x[i], None, E1) for i in range(3)] + [Touch("wall", 1 - x[3], None, E2)]

    def draw(rng):
        v = {"e": restitution(rng), "e2": restitution(rng), "m": rng.choice([1.0, 2.0, 0.5])}
        return v, [rng.choice([-0.3, 0.0]) - rng.uniform(0, 0.2), 0, 0, 0.0, 1.0, 0, 0, 0]

    return made("cradle", x, u, sp.diag(1, m, 1, m), [0, 0, 0, 0], touches, [E1, E2, m], draw, 2.0)


def stacked_balls():
    y, v = sp.symbols("y:2", real=True), sp.symbols("v:2", real=True)
    m = sp.Symbol("m", positive=True)
    touches = [Touch("floor", y[0], None, E1), Touch("balls", y[1] - y[0], None, E2)]

    def draw(rng):
        v = {"e": restitution(rng), "e2": restitution(rng), "m": float(np.exp(rng.uniform(-2, 2)))}
        low = rng.choice([0.0, rng.uniform(0, 0.5)])
        return v, [low, low + rng.choice([0.0, rng.uniform(0, 0.5)]), 0, 0]

    return made("stacked_balls", y, v, sp.diag(1, m), [-9.81, -9.81 * m], touches, [E1, E2, m], draw, 0.8)


def disks_that_push():
    """Two disks on a floor that push each other, with friction in all three contacts."""
    x, y, a = sp.symbols("x:2", real=True), sp.symbols("y:2", real=True), sp.symbols("th:2", real=True)
    u, v, o = sp.symbols("u:2", real=True), sp.symbols("v:2", real=True), sp.symbols("om:2", real=True)
    # flat disks whose sides meet: the contact between them is a vertical line
    touches = [
        Touch("floor 0", y[0], u[0] + o[0], E1, MU),
        Touch("floor 1", y[1], u[1] + o[1], E1, MU),
        Touch("between", x[1] - x[0] - 2, v[0] - v[1] + o[0] + o[1], E2, MU2),
    ]

    def draw(rng):
        p = {
            "e": restitution(rng),
            "e2": restitution(rng),
            "mu": friction(rng),
            "mu2": friction(rng),
            "g_x": rng.uniform(0, 4),
        }
        return p, [
            0,
            2 + rng.choice([0.0, rng.uniform(0, 0.5)]),
            0,
            0,
            0,
            0,
            rng.uniform(0, 3),
            0,
            0,
            0,
            rng.uniform(-2, 2),
            0,
        ]

    q, w = [*x, *y, *a], [*u, *v, *o]
    mass = sp.diag(1, 1, 1, 1, sp.Rational(1, 2), sp.Rational(1, 2))
    force = [GX, 0, -9.81, -9.81, 0, 0]
    return made("disks_that_push", q, w, mass, force, touches, [E1, E2, MU, MU2, GX], draw, 1.0)


def pendulum_with_wall():
    """A double pendulum whose tip strikes a rough wall."""
    a, b, p, q = sp.symbols("a b p q", real=True)
    c = sp.cos(a - b)
    mass = [[2, c], [c, 1]]
    s = sp.sin(a - b)
    force = [-s * q**2 - 2 * G * sp.sin(a), s * p**2 - G * sp.sin(b)]
    tip_x, tip_y = sp.sin(a) + sp.sin(b), sp.cos(a) * p * 0 + p * sp.sin(a) + q * sp.sin(b)
    touches = [Touch("wall", D - tip_x, tip_y, E1, MU)]

    def draw(rng):
        v = {"e": restitution(rng), "mu": friction(rng) * 0.6, "g": 9.81, "d": rng.uniform(0.1, 0.8)}
        return v, [rng.uniform(-1, 0), rng.uniform(-1, 0), rng.uniform(-1, 1), rng.uniform(-1, 1)]

    return made("double_pendulum", [a, b], [p, q], mass, force, touches, [E1, MU, G, D], draw, 1.2)


def block_against_wall():
    floor = Touch("floor", Y, U, E2, MU)
    wall = Touch("wall", 1 - X, V, E1, MU2)

    def draw(rng):
        v = {
            "e": restitution(rng),
            "e2": restitution(rng),
            "mu": friction(rng),
            "mu2": friction(rng),
            "k": rng.choice([0.0, rng.uniform(0, 30)]),
        }
        return v, [0, 0, rng.uniform(1, 5), rng.choice([0.0, 0.0, rng.uniform(0, 2)])]

    return made(
        "block_against_wall",
        [X, Y],
        [U, V],
        sp.eye(2),
        [K * (1 - X), -9.81],
        [floor, wall],
        [E1, E2, MU, MU2, K],
        draw,
        1.5,
    )


def cam_follower():
    cam = Touch("cam", X - (1 - sp.cos(W * T)) / 100, None, E1)
    touches = [cam, Touch("guide", None, U, load=sp.S.One, mu=MU)]

    def draw(rng):
        return {"e": restitution(rng), "mu": friction(rng), "w": rng.uniform(30, 90)}, [rng.choice([0.0, 0.005]), 0]

    return made("cam", [X], [U], [[sp.Rational(1, 2)]], [-400 * (X + 0.02)], touches, [E1, MU, W], draw, 0.4)


MAKERS = [
    ball_on_slope, ball_on_shaken_floor, sticky_block_on_shaken_floor, disk_in_corner, disk_in_box, rod_above_floor,
    block_on_shaken_floor, oscillator_between_stops, dry_oscillator_with_stop, chain_with_stops, equal_balls_in_a_row,
    stacked_balls, disks_that_push, pendulum_with_wall, block_against_wall, cam_follower,
]  # fmt: skip

ENDLESS = {("disks_that_push", 117)}  # elastic disks that end in bounces of 1e-10, which no loss ends


def seeds_of(make, numbers):
    """Return the seeds among these numbers whose motions come to the end of the run."""
    return [seed for seed in numbers if (make.__name__, seed) not in ENDLESS]
