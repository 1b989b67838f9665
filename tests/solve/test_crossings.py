"""Resets at guards, and held variables computed at crossings, against closed forms and chains of plain runs."""

import functools

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import symfric as sf

x, u = sp.symbols("x u", real=True)
c = sp.Symbol("c", real=True)
k, e, g, tau, C = sp.symbols("k e g tau C", positive=True)
HORIZON = 6.0


def plant(command, horizon=HORIZON, values=None, start=None, **more):
    rail = sf.Contact("rail", slip=u - 0.05, normal=1, law=sf.laws.stribeck(0.4, 0.3, 0.1))
    system = sf.System([x], [u], [[1]], [-2 * x - u / 20 + command])
    return sf.Scene(system, [rail], values or {}, start or {"x": 1.0, "u": 0.3}, horizon, {"end": sf.End()}, **more)


@functools.cache
def plain():
    scene = plant(c, values={c: 0.0}).wanting({"path": sf.Trajectory()})
    return sf.prepare(scene, 1e-13, "taylor")


class ByHand:
    """Plain runs, restarted at every instant; roots by Brent's method on their trajectories.

    The state is (x, u, command). `timed` are pairs of time and change of (self), `crossing` triples of an expression,
    its direction (0 for both), and a change of (self, side).
    """

    def __init__(self, timed, crossing, command=0.0, start=(1.0, 0.3), horizon=HORIZON):
        self.y, self.command, self.horizon = list(start), command, horizon
        self.timed = sorted(timed, key=lambda p: p[0])
        self.crossing = [(sp.lambdify((x, u), f), way, change) for f, way, change in crossing]
        self.sides = [np.sign(f(*self.y)) for f, _, _ in self.crossing]
        self.now = 0.0

    def end(self):
        while self.now < self.horizon:
            instant = min([t for t, _ in self.timed if t < self.horizon], default=self.horizon)
            run = plain().run({"c": self.command}, dict(zip("xu", self.y, strict=True))).checked()
            ahead = max(instant - self.now, 0.0)
            first, which = ahead, None
            grid = np.unique(np.append(run.t[run.t < ahead], np.linspace(0.0, ahead, 400)))
            for j, (f, _, _) in enumerate(self.crossing):
                wrong = np.flatnonzero(self.sides[j] * f(*run(grid)) < -1e-11)
                if wrong.size and wrong[0] > 0:
                    low, high = grid[wrong[0] - 1], grid[wrong[0]]
                    at = lambda s, f=f, j=j, run=run: self.sides[j] * f(*run(s)) + 1e-13  # noqa: E731
                    root = brentq(at, low, high, xtol=1e-15) if at(low) > 0 else low
                    if root < first:
                        first, which = root, j
            self.y, self.now = run(np.array(first)).tolist(), self.now + first
            if which is not None:
                self.cross(which)
                continue
            due = [p for p in self.timed if p[0] <= self.now + 1e-12 and self.now < self.horizon]
            for p in due:
                self.timed.remove(p)
                p[1](self)
                self.jump(None)
        return np.array([*self.y, self.command])

    def cross(self, j):
        _, way, change = self.crossing[j]
        self.sides[j] = -self.sides[j]
        if way in (0, self.sides[j]):
            change(self, self.sides[j])
            self.jump(j)

    def jump(self, own):
        """Cross what a change made jump across zero; its own return is no crossing."""
        for j, (f, _, _) in enumerate(self.crossing):
            if self.sides[j] * f(*self.y) < -1e-9:
                if j == own:
                    self.sides[j] = -self.sides[j]
                else:
                    self.cross(j)

    def later(self, delay, change):
        self.timed = sorted([*self.timed, (self.now + delay, change)], key=lambda p: p[0])


def kick(by):
    def change(motion, *_):
        motion.y[1] += by

    return change


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", range(4))
def test_random_scenes_are_chains_of_plain_runs(seed):
    rng = np.random.default_rng(seed)
    place, rate, force = rng.uniform(-0.4, 0.4), rng.uniform(-0.5, 0.5), rng.uniform(0.2, 0.6)
    delay, period, hit = rng.uniform(0.05, 0.9), rng.uniform(0.3, 0.9), rng.uniform(-0.3, 0.3)
    guard, when = x - place - np.sign(hit) * abs(rate) * u / 4, x + rate * u  # no kick lifts its own guard
    relay = sf.Held("relay", -force * sp.sign(when), when=when, delay=delay, initial=0.1)
    resets = [sf.Reset(guard=guard, set={u: u + hit}), sf.Reset(every=period, offset=period / 2, set={u: u - hit / 2})]
    found = sf.simulate(plant(relay.symbol, held=[relay], resets=resets), 1e-13).checked()

    def switch(motion, side):
        motion.later(delay, lambda m: setattr(m, "command", -force * side))

    timed = [(t, kick(-hit / 2)) for t in np.arange(period / 2, HORIZON, period)]
    expected = ByHand(timed, [(when, 0, switch), (guard, -1, kick(hit))], 0.1).end()
    assert np.max(np.abs(found.final[:3] - expected)) < 1e-9


@pytest.mark.one_in(2)
@pytest.mark.parametrize("way", [1, -1])
def test_a_reset_at_the_instant_at_which_a_body_stops(way):
    start = {"x": way * 1.0, "u": way * 0.3}
    slips = sf.Contact("rail", slip=u, normal=1, law=sf.laws.coulomb(0.4, 0.3))
    system = sf.System([x], [u], [[1]], [-2 * x])

    def scene(*resets, start=start, horizon=3.0):
        return sf.Scene(system, [slips], {}, start, horizon, {"end": sf.End()}, resets=resets)

    reset = sf.Reset(guard=way * u, set={u: u + way * 0.2})
    found = sf.simulate(scene(reset), 1e-12).checked().final
    now, y = 0.0, dict(start)
    while now < 3.0:  # it stops at its turning points, where friction carries it or not
        run = sf.simulate(scene(start=y, horizon=3.0 - now).wanting({"path": sf.Trajectory()}), 1e-12).checked()
        speed = way * run(np.minimum(np.linspace(0, 3.0 - now, 4001), run.t_final))[1]
        falls = np.flatnonzero((speed[:-1] > 1e-12) & (speed[1:] <= 0.0))
        if not falls.size:
            expected = run.final
            break
        low, high = (falls[0] + np.arange(2)) * (3.0 - now) / 4000
        events = [event.t for event in run.events if low - 1e-12 <= event.t <= high + 1e-12]
        stop = events[0] if events else high
        now, y = now + stop, {"x": run(np.array(stop))[0], "u": way * 0.2}
    assert np.max(np.abs(found - expected)) < 1e-10


def bouncing(horizon=2.0, start=None, **more):
    system = sf.System([x], [u], [[1]], [-g])
    reset = sf.Reset(guard=x, set={u: -e * u})
    return sf.Scene(system, [], {e: 0.8, g: 9.81}, start or {x: 1.0, u: 0.0}, horizon, resets=[reset], **more)


def bounces(e, g, end):
    t = np.sqrt(2 / g)
    v = g * t
    while True:
        v *= e
        if t + 2 * v / g > end:
            return np.array([v * (end - t) - g * (end - t) ** 2 / 2, v - g * (end - t)])
        t += 2 * v / g


def test_a_bouncing_ball_and_its_derivatives():
    run = sf.simulate(bouncing(), 1e-12, sensitivities=["e", "g"])
    assert np.max(np.abs(run.final - bounces(0.8, 9.81, 2.0))) < 1e-14
    h = 1e-6
    by_e = (bounces(0.8 + h, 9.81, 2.0) - bounces(0.8 - h, 9.81, 2.0)) / (2 * h)
    by_g = (bounces(0.8, 9.81 + h, 2.0) - bounces(0.8, 9.81 - h, 2.0)) / (2 * h)
    assert np.max(np.abs(run.sensitivities["e"] - by_e)) < 1e-6
    assert np.max(np.abs(run.sensitivities["g"] - by_g)) < 1e-6


def test_resets_that_pile_up_end_the_run_with_advice():
    run = sf.simulate(bouncing(10.0))
    assert run.status == sf.Status.CHATTER
    assert run.t_final == pytest.approx(np.sqrt(2 / 9.81) * 9, abs=1e-8)
    with pytest.raises(sf.RunFailed, match="a reset leaves its guard at zero"):
        run.checked()
    assert sf.simulate(bouncing(start={x: 0.0, u: 0.0})).status == sf.Status.CHATTER
    y, w = sp.symbols("y w", real=True)
    system = sf.System([x, y], [u, w], [[1, 0], [0, 1]], [0, 0])
    each_other = [sf.Reset(guard=x, set={x: 2, y: -1}), sf.Reset(guard=y, set={y: 1, x: -1})]
    start = {x: 1.0, u: -1.0, y: 2.0, w: 0.0}
    assert sf.simulate(sf.Scene(system, [], {}, start, 3.0, resets=each_other)).status == sf.Status.CHATTER


@pytest.mark.parametrize(("speed", "kicks"), [(-1.0, 1), (1.0, 0)])
def test_a_run_that_starts_at_zero_has_crossed_if_it_falls(speed, kicks):
    scene = sf.Scene(
        sf.System([x], [u], [[1]], [0]), [], {}, {x: 0.0, u: speed}, 1.0, resets=[sf.Reset(guard=x, set={u: u - 3})]
    )
    assert sf.simulate(scene).final[1] == speed - 3 * kicks
    side = sf.Held("side", sp.sign(x), when=x)
    assert sf.simulate(plant(side.symbol, 0.1, start={x: 0.0, u: speed}, held=[side])).final[2] == np.sign(speed)


def test_what_is_due_at_the_end_is_left_to_the_next_run():
    """One run is a chain of two whose first ends exactly at a sample, a kick, an arrival and a crossing."""
    still = sf.System([x], [u], [[1]], [0])
    relay = sf.Held("relay", sp.sign(x - 1), when=x - 1, delay=0.5, initial=0.0, waiting=1)
    count = sf.Held("count", sp.Symbol("count.previous", real=True) + 1, every=1.0)
    parts = {"held": [relay, count], "resets": [sf.Reset(every=2.0, set={u: u + 1}), sf.Reset(guard=3 - x, set={x: 0})]}
    scene = sf.Scene(still, [], {}, {x: 0.0, u: 0.0}, 8.0, **parts)
    whole = sf.simulate(scene).final
    for end in (1.0, 1.5, 2.0, 2.5, 3.0):
        first = sf.simulate(scene.until(end)).final
        if end == 1.0:
            assert np.array_equal(first, [1.0, 1.0, 0.0, 0.0, -1.0, 1.0])
        if end == 2.0:
            assert np.array_equal(first[:2], [2.0, 1.0])
    first = sf.simulate(scene.until(2.0)).final
    then = sf.simulate(scene.starting(dict(zip(scene.system.states, first, strict=True))).until(6.0)).final
    assert np.array_equal(then, whole)


def test_a_crossing_by_a_jump_happens_when_the_jump_does():
    y, w = sp.symbols("y w", real=True)
    system = sf.System([x, y], [u, w], [[1, 0], [0, 1]], [-g, -y])
    resets = [sf.Reset(guard=x, set={u: -u, y: y - 5}), sf.Reset(guard=y, set={w: w + u + y})]
    scene = sf.Scene(system, [], {g: 1.0}, {x: 1.0, u: 0.0, y: 2.0, w: 0.0}, 2.5, resets=resets)
    found = sf.simulate(scene, 1e-12, sensitivities=["g"]).sensitivities["g"]
    program, h = sf.prepare(scene, 1e-13), 1e-6
    slope = (program.run({g: 1 + h}).final - program.run({g: 1 - h}).final) / (2 * h)
    assert np.max(np.abs(found - slope)) < 1e-7


def test_send_on_delta():
    sent = sf.Held("sent", x, when=sp.Abs(x - sp.Symbol("sent", real=True)) - 0.25, initial=0.0)
    scene = sf.Scene(sf.System([x], [u], [[1]], [0]), [], {}, {x: 0.0, u: 1.0}, 1.1, held=[sent])
    assert sf.simulate(scene).final[2] == pytest.approx(1.0, abs=1e-14)
    assert sf.simulate(scene.starting({u: -1.0})).final[2] == pytest.approx(-1.0, abs=1e-14)


def monodromy(scene, orbit, skipped=()):
    base = dict(zip(orbit.run.names, orbit.start, strict=True))
    program, h = sf.prepare(scene.until(orbit.period), 1e-13), 1e-5

    def end(n, by):
        return program.run({}, {**base, n: base[n] + by}).final

    columns = [(4 * (end(n, h) - end(n, -h)) / (2 * h) - (end(n, 2 * h) - end(n, -2 * h)) / (4 * h)) / 3 for n in base]
    return np.linalg.eigvals(np.array(columns).T)


def delayed_relay(waiting=1):
    """x'' = -F sgn(x(t - tau)) - C sgn(x'), with F = 1."""
    relay = sf.Held("relay", -sp.sign(x), when=x, delay=tau, initial=-1, waiting=waiting)
    rail = sf.Contact("rail", slip=u, normal=1, law=sf.laws.coulomb(C))
    system = sf.System([x], [u], [[1]], [relay.symbol])
    return sf.Scene(system, [rail], {tau: 0.3, C: 0.4}, {x: 1.0, u: 0.0}, 100.0, held=[relay])


@pytest.mark.one_in(2)
@pytest.mark.parametrize("waiting", [1, 3])
def test_a_relay_with_dead_time_and_friction(waiting):
    scene = delayed_relay(waiting)
    run = sf.simulate(scene.until(300.0, {"path": sf.Trajectory()}), 1e-13)
    turns = [event.t for event in run.checked().events][-6:]
    assert np.max(np.abs(np.abs(run(np.array(turns))[0]) - 0.804335385359224)) < 1e-14
    assert np.max(np.abs(2 * np.diff(turns) - 5.53546276418555)) < 1e-13
    orbit = sf.limit_cycle(scene)
    assert orbit.half_range[0] == pytest.approx(0.804335385359224, abs=1e-12)  # twelve digits, as it closes
    assert orbit.period == pytest.approx(5.53546276418555, abs=5e-12)
    expected = sorted(np.abs(monodromy(scene, orbit)))
    assert np.max(np.abs(np.sort(np.abs(orbit.multipliers)) - expected)) < 1e-8
    assert orbit.multipliers.size == 3 + 2 * waiting


def test_its_derivatives_by_the_dead_time():
    scene = delayed_relay().until(20.0)
    run, h = sf.simulate(scene, 1e-12, sensitivities=["tau", "C"]), 1e-5
    program = sf.prepare(scene, 1e-13)
    for name, value in (("tau", 0.3), ("C", 0.4)):
        near, far = (
            (program.run({name: value + s}).final - program.run({name: value - s}).final) / (2 * s) for s in (h, 2 * h)
        )
        assert np.max(np.abs(run.sensitivities[name] - (4 * near - far) / 3)) < 1e-6


def test_continuation_in_the_dead_time():
    branch = sf.continue_cycle(delayed_relay(), "tau", span=(0.2, 0.5))
    assert [branch.values[0], branch.values[-1]] == pytest.approx([0.2, 0.5])
    last = sf.limit_cycle(delayed_relay().where({"tau": 0.5}))
    assert branch.orbits[-1].half_range[0] == pytest.approx(last.half_range[0], abs=1e-9)


def test_a_queue_that_is_too_short_says_so():
    fast = sf.Held("fast", -sp.sign(x), when=x, delay=2.0, initial=0.0, waiting=1)
    scene = sf.Scene(
        sf.System([x], [u], [[1]], [-9 * x + fast.symbol / 9]), [], {}, {x: 1.0, u: 0.0}, 10.0, held=[fast]
    )
    run = sf.simulate(scene)
    assert run.status == sf.Status.QUEUE_FULL
    with pytest.raises(sf.RunFailed, match=r"waiting=\.\.\."):
        run.checked()
    with pytest.raises(sf.NotFound, match="waiting"):
        sf.limit_cycle(scene)
    more = sf.Held("fast", -sp.sign(x), when=x, delay=2.0, initial=0.0)
    assert sf.simulate(sf.Scene(scene.system, [], {}, scene.initial, 10.0, held=[more])).status == sf.Status.OK


def escapement(**more):
    system = sf.System([x], [u], [[1]], [-x - u / 10])
    pivot = sf.Contact("pivot", slip=u, normal=1, law=sf.laws.coulomb(0.05))
    kick = sf.Reset(guard=x, set={u: u - k})
    return sf.Scene(system, [pivot], {k: 0.3}, {x: 1.0, u: 0.0}, 100.0, resets=[kick], **more)


def test_the_limit_cycle_of_an_escapement():
    scene = escapement()
    orbit = sf.limit_cycle(scene)
    assert np.max(np.abs(np.sort(orbit.multipliers) - np.sort(monodromy(scene, orbit)))) < 1e-7
    branch = sf.continue_cycle(scene, "k", span=(0.28, 0.5))
    assert branch.values[-1] == pytest.approx(0.5) or branch.values[0] == pytest.approx(0.5)
    found = sf.lyapunov(orbit.scene, 100 * orbit.period)
    assert found.exponents[1] == pytest.approx(np.log(orbit.multipliers[1]) / orbit.period, rel=5e-3)


def test_map_equals_runs():
    program = sf.prepare(escapement(outputs={"end": sf.End()}).until(20.0))
    kicks = np.linspace(0.2, 0.5, 7)
    assert np.array_equal(program.map({"k": kicks}).final.T, [program.run({"k": v}).final for v in kicks])


@pytest.mark.one_in(2)
@pytest.mark.parametrize("made", [escapement, lambda: delayed_relay(3)])
def test_the_route_exact_takes_crossings_and_integrators_decline_them(made):
    scene = made().until(20.0)
    exact, series = (sf.simulate(scene, 1e-14, route).checked() for route in ("exact", "taylor"))
    assert exact.stats["events"] == series.stats["events"] > 4
    assert np.max(np.abs(exact.final - series.final)) < 2e-14
    with pytest.raises(sf.NoRoute, match="waits for a crossing"):
        sf.prepare(scene, route="integrators")


def refused(match, **parts):
    with pytest.raises(sf.SceneError, match=match):
        plant(sp.S.Zero, **parts)


def test_what_is_refused():
    with pytest.raises(sf.SceneError, match="either a sampling period"):
        sf.Held("a", x)
    with pytest.raises(sf.SceneError, match="either a sampling period"):
        sf.Held("a", x, every=1.0, when=x)
    with pytest.raises(sf.SceneError, match="offset"):
        sf.Held("a", x, when=x, offset=1.0)
    with pytest.raises(sf.SceneError, match="crosses zero never"):
        sf.Held("a", x, when=1)
    with pytest.raises(sf.SceneError, match="whole number"):
        sf.Held("a", x, when=x, delay=1.0, waiting=0)
    with pytest.raises(sf.SceneError, match="too few"):
        sf.Held("a", x, every=1.0, delay=3.5, waiting=2)
    with pytest.raises(sf.SceneError, match="more than 64"):
        sf.Held("a", x, every=1.0, delay=65.0)
    with pytest.raises(sf.SceneError, match="guard=x"):
        sf.Reset(guard=x, every=1.0, set={u: 0})
    with pytest.raises(sf.SceneError, match="guard of a reset is 0"):
        sf.Reset(guard=0, set={u: 0})
    refused("which only outputs know", resets=[sf.Reset(guard=sf.slip("rail"), set={u: 0})])
    refused("may depend on parameters only, not on x", held=[sf.Held("a", x, when=x, delay=x)])
    refused("jumps by", resets=[sf.Reset(guard=sp.Piecewise((1, x < 0), (2, True)), set={u: 0})])
    refused("no value for c", resets=[sf.Reset(guard=x - c, set={u: 0})])
