"""The same scene in other units of mass, length and time: the same run in those units, to rounding."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer

TOLERANCE = 1e-12


def rescaled(seed, length=1.0, mass=1.0, time=1.0, horizon=8.0):
    """A scene of one to three masses and contacts drawn by the seed, in units that many times smaller."""
    rng = np.random.default_rng([9, seed])
    n, n_c = int(rng.integers(1, 4)), int(rng.integers(1, 4))
    q, u = (sp.symbols(f"{name}1:{n + 1}", real=True) for name in "xu")
    stiffness, force, speed = mass / time**2, mass * length / time**2, length / time
    values, forces = {}, []

    def number(name, low, high, unit):
        symbol = sp.Symbol(name, real=True)
        values[symbol] = float(rng.uniform(low, high)) * unit
        return symbol

    for i in range(n):
        e = -number(f"k{i}", 0.5, 2, stiffness) * q[i] - number(f"d{i}", 0, 0.1, mass / time) * u[i]
        if rng.random() < 0.4:
            e += number(f"F{i}", 0.2, 0.8, force) * sp.sin(number(f"Omega{i}", 0.5, 2, 1 / time) * sf.TIME)
        if rng.random() < 0.3:
            e -= number(f"h{i}", 0.2, 1, stiffness / length**2) * q[i] ** 3
        if i:
            e -= number(f"c{i}", 0.3, 1, stiffness) * (q[i] - q[i - 1])
        forces.append(e)
    contacts = []
    for i in range(n_c):
        k = int(rng.integers(n))
        slip = u[k] - number(f"v{i}", -0.3, 0.3, speed)
        if n > 1 and rng.random() < 0.5:
            slip -= u[k - 1]
        mu, drop = rng.uniform(0.2, 0.5), rng.choice([0.0, 0.1])
        v = number(f"s{i}", 0.1, 0.5, speed)
        law = [sf.laws.coulomb(mu + drop, mu), sf.laws.stribeck(mu + drop, mu, v), sf.laws.lorentz(mu, v, mu + drop)]
        load = number(f"N{i}", 0.3, 1.2, force)
        if rng.random() < 0.2:
            load *= 1 + number(f"a{i}", 0.1, 0.5, 1) * sp.sin(number(f"w{i}", 0.5, 3, 1 / time) * sf.TIME)
        contacts.append(sf.Contact(f"c{i}", slip, load, law[int(rng.integers(3))]))
    start = {e: rng.uniform(-1.5, 1.5) * length for e in q} | {
        e: rng.choice([0, rng.uniform(-1, 1)]) * speed for e in u
    }
    masses = sp.diag(*(number(f"m{i}", 0.5, 2, mass) for i in range(n)))
    wanted = {"end": sf.End(), "events": sf.Events(), "high": sf.Max(q[0])}
    system = sf.System(q, u, masses, forces)
    used = set().union(*(e.free_symbols for e in (*system.expressions, *(c.slip for c in contacts))))
    used |= set().union(*((c.normal.free_symbols | c.law.kinetic.free_symbols) for c in contacts))
    return sf.Scene(system, contacts, {s: v for s, v in values.items() if s in used}, start, horizon * time, wanted)


def in_units(run, length, time):
    """Return the end of a run, its largest value, and its events, without units."""
    n = run.final.size // 2
    events = [(e.contact, e.before, e.after) for e in run.events]
    end = run.final / np.repeat([length, length / time], n)
    return np.append(end, run["high"] / length), events, np.array([e.t for e in run.events]) / time


@pytest.mark.one_in(9)
@pytest.mark.parametrize("seed", longer(range(24), range(8, 24)))
def test_a_scene_in_other_units(seed):
    rng = np.random.default_rng([10, seed])
    one, events, times = in_units(sf.simulate(rescaled(seed), TOLERANCE).checked(), 1.0, 1.0)
    for _ in range(3):
        length, mass, time = 10.0 ** rng.integers(-6, 7, 3)
        run = sf.simulate(rescaled(seed, length, mass, time), TOLERANCE).checked()
        other, found, at = in_units(run, length, time)
        assert found == events
        assert at == pytest.approx(times, rel=1e-8, abs=1e-9)
        assert other == pytest.approx(one, rel=1e-9, abs=1e-9)


@pytest.mark.one_in(18)
@pytest.mark.parametrize(
    "units", [(1e-6, 1e-6, 1e6), (1e6, 1e6, 1e-6), (1, 1e-12, 1e6), (1e-6, 1e6, 1e6), (1, 1e-30, 1)]
)
@pytest.mark.parametrize("seed", [1, 3, 4])
def test_units_far_away(seed, units):
    one, events, _ = in_units(sf.simulate(rescaled(seed), TOLERANCE).checked(), 1.0, 1.0)
    other, found, _ = in_units(sf.simulate(rescaled(seed, *units), TOLERANCE).checked(), units[0], units[2])
    assert found == events
    assert other == pytest.approx(one, rel=1e-9, abs=1e-9)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("units", [(1e-6, 1, 1), (1e-6, 1e-6, 1e2), (1e6, 1, 1e-4), (1, 1e-12, 1e6)])
@pytest.mark.parametrize("seed", [1, 3, 4, 6])
def test_the_integrators_in_other_units(seed, units):
    one, events, _ = in_units(sf.simulate(rescaled(seed), TOLERANCE).checked(), 1.0, 1.0)
    length, _, time = units
    other, found, _ = in_units(sf.simulate(rescaled(seed, *units), 1e-8, "integrators").checked(), length, time)
    assert found == events
    assert other == pytest.approx(one, rel=1e-7, abs=1e-7)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("units", [(1e-6, 1e-6, 1e2), (1e-3, 1e4, 1e-5), (1e6, 1e-6, 1e6)])
def test_a_limit_cycle_in_other_units(units):
    def belt(length, mass, time):
        x, u = sp.symbols("x u", real=True)
        v, k, m, c, load = sp.symbols("v_b k m c load", positive=True)
        values = {v: 0.2 * length / time, k: mass / time**2, m: mass, c: 0.05 * mass / time}
        values[load] = mass * length / time**2
        law = sf.laws.stribeck(0.4, 0.25, 0.3 * length / time)
        system = sf.System([x], [u], [[m]], [-k * x - c * u])
        return sf.Scene(system, [sf.Contact("belt", u - v, load, law)], values, {x: 0, u: 0}, 100 * time)

    one, other = sf.limit_cycle(belt(1.0, 1.0, 1.0)), sf.limit_cycle(belt(*units))
    assert other.period / units[2] == pytest.approx(one.period, rel=1e-9)
    assert other.x_max / [units[0], units[0] / units[2]] == pytest.approx(one.x_max, rel=1e-9)
    assert other.stick_fraction == pytest.approx(one.stick_fraction, rel=1e-8)
    assert np.abs(other.multipliers) == pytest.approx(np.abs(one.multipliers), abs=1e-8)
