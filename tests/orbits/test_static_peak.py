"""Branches with static above kinetic friction: onsets of sticking in closed form, against SciPy, and where orbits jump."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

import symfric as sf
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
F, W, V, MU_S = sp.symbols("F W v_b mu_s", positive=True)
C, MU_K = 0.1, 0.3


def floor(law, F_value=1.0, W_value=1.4, **values):
    """x'' + 0.1 x' + x = F cos Wt with friction on the ground."""
    system = sf.System([X], [U], [[1]], [-X - C * U + F * sp.cos(W * sf.TIME)])
    given = {F: F_value, W: W_value, **{sp.Symbol(n, positive=True): v for n, v in values.items()}}
    return sf.Scene(system, [sf.Contact("floor", slip=U, normal=1, law=law)], given, {X: 0.5, U: 0.0}, 200.0)


def onset(mu_s, w):
    """Return F at which the orbit that never stops needs all of static friction at its turns.

    From x = a, x' = 0 to x = -a, x' = 0 in half a period, in closed form; at the turn a - F cos(phase) = mu_s.
    """
    omega = np.sqrt(1 - C**2 / 4)
    response = 1 / (1 - w**2 + 1j * C * w)

    def rest(z):
        a, phase, load = z
        forced = lambda t: load * (response * np.exp(1j * (w * t + phase)))  # noqa: E731
        x_p, u_p = forced(0).real + MU_K, (1j * w * forced(0)).real
        b = a - x_p
        d = (-u_p + 0.5 * C * b) / omega
        t = np.pi / w
        e, c, s = np.exp(-0.5 * C * t), np.cos(omega * t), np.sin(omega * t)
        x = e * (b * c + d * s) + forced(t).real + MU_K
        u = e * ((-0.5 * C * b + omega * d) * c + (-0.5 * C * d - omega * b) * s) + (1j * w * forced(t)).real
        return x + a, u, a - load * np.cos(phase) - mu_s

    found, _, flag, _ = fsolve(rest, (0.25, 3.0, 0.5), xtol=1e-14, full_output=True)
    assert flag == 1 or np.max(np.abs(rest(found))) < 1e-12
    return found[2]


@pytest.fixture(scope="module")
def branch():
    return sf.continue_cycle(floor(sf.laws.coulomb(MU_S, MU_K), mu_s=0.4), "F", (0.42, 1.5))


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("mu_s", "known"), [(0.3, 0.471496913), (0.33, 0.478201935), (0.4, 0.495227415)])
def test_a_reversal_begins_to_stick_at_the_static_bound(mu_s, known):
    branch = sf.continue_cycle(floor(sf.laws.coulomb(mu_s, MU_K)), "F", (0.42, 1.5))
    assert branch.ends == ("span", "span")
    (special,) = branch.special
    assert special.kind == "stick-onset"
    assert not special.jump
    assert special.value == pytest.approx(onset(mu_s, 1.4), rel=1e-10)
    assert special.value == pytest.approx(known, abs=1e-9)
    assert np.all(np.diff(branch.values) > 0)
    sticks = np.array([orbit.stick_fraction > 0 for orbit in branch.orbits])
    assert np.array_equal(sticks, branch.values < special.value)


def test_the_onset_as_a_curve_of_two_parameters(branch):
    curve = sf.continue_special(branch.special[0], ("mu_s", "F"), ((0.31, 0.45), (0.3, 0.9)))
    assert curve.ends == ("span", "span")
    for mu_s in (0.32, 0.36, 0.4, 0.44):
        assert curve.at(mu_s) == pytest.approx([onset(mu_s, 1.4)], rel=1e-8)


def sticks_when_settled(scene):
    orbit = sf.limit_cycle(scene)
    return orbit.stick_fraction > 0


@pytest.mark.long(beside="test_a_reversal_begins_to_stick_at_the_static_bound")
def test_the_onset_by_bisection_of_motions():
    scene = floor(sf.laws.lorentz(0.3, 4.0, mu_s=0.37))
    special = next(s for s in sf.continue_cycle(scene, "F", (0.42, 1.5)).special if s.kind == "stick-onset")
    low, high = 0.42, 1.0
    assert sticks_when_settled(scene.where({F: low}))
    assert not sticks_when_settled(scene.where({F: high}))
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if sticks_when_settled(scene.where({F: middle})) else (low, middle)
    assert special.value == pytest.approx(low, abs=1e-8)


def law_of(rng):
    mu_s, share, speed = rng.uniform(0.3, 0.5), rng.uniform(0.5, 0.95), rng.uniform(0.2, 1.0)
    return (
        lambda: sf.laws.coulomb(mu_s, mu_s * share),
        lambda: sf.laws.gauss(0.8 * share * mu_s, speed, mu_s=mu_s),
        lambda: sf.laws.lorentz(0.8 * share * mu_s, speed, mu_s=mu_s),
        lambda: sf.laws.custom(share * mu_s * (0.7 + 0.3 * sp.exp(-sf.SPEED / speed)), mu_s),
    )[rng.integers(4)]()


def shaken(seed):
    """Return a random forced oscillator on the floor or on a belt, the parameter to follow and its span."""
    rng = np.random.default_rng(seed)
    moves = bool(seed % 2)
    slip = U - V if moves else U
    force = -X - rng.uniform(0.02, 0.2) * U - rng.choice([0.0, 0.3]) * X**3 + F * sp.cos(W * sf.TIME)
    values = {F: rng.uniform(0.8, 2.5), W: rng.uniform(0.8, 2.2), **({V: rng.uniform(0.3, 1.0)} if moves else {})}
    contact = sf.Contact("belt", slip=slip, normal=1, law=law_of(rng))
    scene = sf.Scene(sf.System([X], [U], [[1]], [force]), [contact], values, {X: 1.5, U: 0.0}, 200.0)
    name = "v_b" if moves and rng.random() < 0.5 else "F"
    at = scene.values[scene.parameter(name)]
    return scene, name, (0.35 * at, 1.6 * at)


def follow_by_scipy(scene, start, period):
    """Return the end of a period and, at every end of a slip, the time, the direction, and the static friction left.

    One mode at a time: slips with kinetic friction until the slip is zero, rests relative to the belt until the force
    needed exceeds the static bound.
    """
    (contact,) = scene.contacts
    numbers = {s: scene.values[s] for s in scene.values}
    force = sp.lambdify((X, U, sf.TIME), scene.system.force[0].subs(numbers))
    belt = float(-contact.slip.subs(U, 0).subs(numbers))
    law, bound = sp.lambdify(sf.SPEED, contact.law.kinetic.subs(numbers)), float(contact.law.stick)
    y, t, ends = np.array(start, dtype=float), 0.0, []
    hold = lambda t, y: -force(y[0], belt, t)  # noqa: E731
    slip = y[1] - belt
    way = 0 if abs(slip) < 1e-9 and abs(hold(0.0, y)) < bound else int(np.sign(slip))
    if abs(slip) < 1e-9 and way == 0:
        y[1] = belt
    while t < period:
        if way:
            rate = lambda t, y, way=way: [y[1], force(y[0], y[1], t) - way * law(max(way * (y[1] - belt), 0.0))]  # noqa: E731
            event = lambda t, y, way=way: way * (y[1] - belt)  # noqa: E731
            event.direction = -1
        else:
            rate = lambda t, y: [belt, 0.0]  # noqa: E731
            event = lambda t, y: bound - abs(hold(t, y))  # noqa: E731
            event.direction = -1
        event.terminal = True
        run = solve_ivp(rate, (t, period), y, method="DOP853", rtol=1e-11, atol=1e-13, max_step=0.05, events=event)
        t, y = run.t[-1], run.y[:, -1]
        if run.status == 0:
            break
        need = hold(t, y)
        if way:
            y[1] = belt
            ends.append((t, way, 1.0 - way * need / bound))
            way = 0 if abs(need) < bound else -way
            y[1] += way * 1e-14
        else:
            way = -int(np.sign(need))
            y[1] = belt + way * 1e-14
    return y, ends


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", longer([0, 1, 3, 4, 6, 9, 11, 13], [0, 4, 6, 9, 11, 13]))
def test_random_branches_against_scipy(seed):
    scene, name, span = shaken(seed)
    branch = sf.continue_cycle(scene, name, span)
    assert all(span[0] <= s.value <= span[1] for s in branch.special)
    assert all(span[0] <= v <= span[1] for v in branch.values)
    marks = np.column_stack([branch.values, [o.start for o in branch.orbits], [o.x_max for o in branch.orbits]])
    apart = np.linalg.norm((marks[:, None] - marks) / np.ptp(marks, axis=0), axis=-1) + np.eye(len(marks))
    assert np.min(apart) > 0  # none is met twice
    stable = [orbit for orbit in branch.orbits if orbit.stable]
    for orbit in stable[:: max(1, len(stable) // 3)]:
        end, _ = follow_by_scipy(orbit.scene, orbit.start, orbit.period)
        assert end == pytest.approx(orbit.start, abs=2e-7)
    for special in branch.special:
        if special.condition.turn is None or special.condition.side == 0:
            continue
        orbit = special.orbit
        end, ends = follow_by_scipy(orbit.scene, orbit.start, orbit.period)
        left = ends[special.condition.turn[1]][2]
        assert left == pytest.approx(0.0, abs=2e-5)  # the orbit is 3e-6 of both bounds away
        assert np.sign(left) == special.condition.side
        assert end == pytest.approx(orbit.start, abs=1e-5)


def test_where_the_orbits_jump():
    """A mass that slips all the time on a slow belt touches its speed: it sticks for a while at once."""
    law = sf.laws.coulomb(0.4, 0.25)
    system = sf.System([X], [U], [[1]], [-X - C * U + F * sp.cos(W * sf.TIME)])
    contact = sf.Contact("belt", slip=U - V, normal=1, law=law)
    scene = sf.Scene(system, [contact], {F: 0.2, W: 0.6, V: 0.5}, {X: 0.0, U: 0.0}, 200.0)
    branch = sf.continue_cycle(scene, "F", (0.1, 1.5))
    first = branch.special[0]
    swing = 0.6 / np.hypot(1 - 0.6**2, C * 0.6)  # of the velocity, for F = 1
    assert (first.kind, first.jump) == ("stick-onset", True)
    assert first.value == pytest.approx(0.5 / swing, rel=1e-9)
    k = int(np.searchsorted(branch.values, first.value))
    before, after = branch.orbits[k - 1], branch.orbits[k + 1]
    assert before.stick_fraction == 0
    assert after.stick_fraction > 0.02
    there = scene.where({F: after.scene.values[F]}).starting(dict(zip("xu", before.start.tolist(), strict=True)))
    settled = sf.simulate(there.until(40 * after.period).wanting({"end": sf.End()}), 1e-11)
    again = there.starting(dict(zip("xu", settled.final.tolist(), strict=True))).until(after.period)
    assert sf.simulate(again.wanting({"size": sf.HalfRange(X)}), 1e-11)["size"] == pytest.approx(
        after.half_range[0], rel=1e-7
    )
    assert "with a jump" in repr(branch)
    assert branch.to_dict()["special"][0]["jump"] is True


@pytest.mark.long(beside="test_where_the_orbits_jump")
def test_a_jump_to_rest_ends_the_branch():
    """From a belt's unstable cycle without sticking the motion settles to steady sliding beyond the touch."""
    law = sf.laws.custom(0.18 + 0.08 * sp.exp(-2.5 * sf.SPEED), 0.38)
    scene = sf.scenes.mass_on_belt(law, v_b=0.3, beta=0.04)
    start = sf.hopf(scene, "v_b", (0.05, 1.2))
    assert start.kind == "subcritical"
    branch = sf.continue_cycle(scene, "v_b", (0.05, 1.2), start=start)
    assert branch.special[-1].jump
    assert branch.ends == ("hopf", "jump")
    touching = branch.special[-1].orbit
    assert touching.stick_fraction == 0
    assert touching.x_max[1] == pytest.approx(branch.special[-1].value, rel=1e-4)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("mu_s", [0.36, 0.45])
def test_the_last_orbit_that_is_released_at_the_peak_of_the_load(mu_s):
    """It rests at x = a until the load is largest, a + F = mu_s, and slides from there to x = -a."""
    branch = sf.continue_cycle(floor(sf.laws.coulomb(mu_s, MU_K)), "F", (0.2, 1.5))
    assert branch.ends[0] in ("grazing", "jump")
    w = 1.4

    def rest(load):
        a = mu_s - load
        turns = lambda t, y: y[1]  # noqa: E731
        turns.terminal, turns.direction = True, -1
        rate = lambda t, y: [y[1], -y[0] - C * y[1] + load * np.cos(w * t) - MU_K]  # noqa: E731
        run = solve_ivp(rate, (0, 10), [-a, 1e-14], rtol=1e-12, atol=1e-14, events=turns)
        return run.y[0, -1] - a

    found = [s.value for s in branch.special if s.kind == "grazing"]
    edge = brentq(rest, 0.9 * found[0], mu_s - 1e-9, xtol=1e-13) if rest(0.9 * found[0]) < 0 else np.nan
    assert found[0] == pytest.approx(edge, rel=1e-4)


@pytest.mark.long(beside="test_a_reversal_begins_to_stick_at_the_static_bound")
def test_two_contacts_that_share_the_load_stick_as_one():
    laws = sf.laws.coulomb(0.4, 0.3), sf.laws.coulomb(0.35, 0.2)
    system = sf.System([X], [U], [[1]], [-X - C * U + F * sp.cos(W * sf.TIME)])
    contacts = [sf.Contact(name, slip=U, normal=0.5, law=law) for name, law in zip("ab", laws, strict=True)]
    both = sf.Scene(system, contacts, {F: 1.0, W: 1.4}, {X: 0.5, U: 0.0}, 200.0)
    one = sf.Scene(
        system,
        [sf.Contact("ab", slip=U, normal=1, law=sf.laws.coulomb(0.375, 0.25))],
        dict(both.values),
        {X: 0.5, U: 0},
        200.0,
    )
    found = [
        next(s for s in sf.continue_cycle(s, "F", (0.38, 1.5)).special if s.kind == "stick-onset") for s in (both, one)
    ]
    assert found[0].value == pytest.approx(found[1].value, rel=1e-9)
