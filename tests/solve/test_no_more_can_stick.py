"""After an event no further contact can stick, though friction drops from rest to slip: against all combinations."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.solve.enumerated_modes import Friction, agrees, holding_more

T, ROUTES = sf.TIME, ("exact", "taylor", "integrators")
STATIC, Omega = 0.6, 2.0


class Structure:
    """Masses on springs with constant and harmonic forces, and contacts whose slips are rows times velocities.

    `surfaces` are rows, too: the surfaces of contacts move with the places of the masses.
    """

    def __init__(self, rows, order=None, surfaces=None):
        self.rows = np.asarray(rows, dtype=float)
        n_c, n = self.rows.shape
        self.surfaces = np.zeros((n_c, n)) if surfaces is None else np.asarray(surfaces, dtype=float)
        self.order = range(n_c) if order is None else order
        self.q, self.u = (sp.symbols(f"{name}1:{n + 1}", real=True) for name in "qu")
        self.loads, self.m, self.k = (
            sp.symbols(f"{name}1:{s + 1}", positive=True) for name, s in zip("Nmk", (n_c, n, n), strict=True)
        )
        self.c, self.A = (sp.symbols(f"{name}1:{n + 1}", real=True) for name in "cA")
        self.kinetic = sp.Symbol("mu_k", positive=True)
        law, slips = sf.laws.coulomb(STATIC, self.kinetic), sp.Matrix(np.asarray(rows)) * sp.Matrix(self.u)
        slips -= sp.Matrix(self.surfaces) * sp.Matrix(self.q) if surfaces is not None else sp.zeros(n_c, 1)
        contacts = [sf.Contact(f"c{i}", slips[i], self.loads[i], law) for i in self.order]
        force = [c + A * sp.sin(Omega * T) - k * q for c, A, k, q in zip(self.c, self.A, self.k, self.q, strict=True)]
        values = dict.fromkeys((*self.loads, *self.m, *self.k, *self.c, *self.A, self.kinetic), 0.5)
        start = dict.fromkeys((*self.q, *self.u), 0.0)
        self.scene = sf.Scene(sf.System(self.q, self.u, sp.diag(*self.m), force), contacts, values, start, 4.0)

    def draw(self, seed):
        """Return values and start; loads and masses that agree are likely."""
        rng, n = np.random.default_rng([seed, *self.rows.shape]), len(self.q)
        loads = rng.uniform(0.1, 1, len(self.loads))
        numbers = {
            self.loads: np.round(5 * loads) / 5 + 0.2 if rng.random() < 0.5 else loads,
            self.m: rng.uniform(0.3, 2, n) if rng.random() < 0.5 else np.ones(n),
            self.k: rng.uniform(0.05, 2, n),
            self.c: rng.uniform(-0.2, 0.2, n),
            self.A: rng.uniform(0, 2, n) * (rng.random(n) < 0.6),
            (self.kinetic,): [STATIC * rng.uniform(0.5, 1)],
        }
        start = dict.fromkeys((str(s) for s in self.u), 0.0) | _named(self.q, rng.uniform(-0.3, 0.3, n))
        return {name: v for symbols, values in numbers.items() for name, v in _named(symbols, values).items()}, start

    def friction(self, values):
        """Return the same numbers for the enumeration."""
        m, k, c, A, loads = (
            [values[str(s)] for s in symbols] for symbols in (self.m, self.k, self.c, self.A, self.loads)
        )
        n, loads = len(m), np.array(loads)
        belts, bounds = np.zeros(loads.size), (STATIC * loads, values["mu_k"] * loads)
        return Friction(
            np.array(m),
            np.diag(k),
            np.zeros((n, n)),
            np.array(c),
            np.array(A),
            Omega,
            self.rows,
            belts,
            *bounds,
            self.surfaces,
        )


def _named(symbols, values):
    return {str(s): float(v) for s, v in zip(symbols, values, strict=True)}


def chain(n):
    """Return the rows of masses in a row, each on the ground and on its neighbours."""
    return np.vstack([np.eye(n), np.eye(n)[:-1] - np.eye(n)[1:]]).astype(int)


def random_rows(seed):
    """Return the whole-numbered rows of some contacts more than velocities, or of as many."""
    rng = np.random.default_rng([5, seed])
    n = int(rng.integers(2, 5))
    rows = rng.integers(-2, 3, (int(rng.integers(n, min(n + 3, 6) + 1)), n))
    rows *= rng.random(rows.shape) < 0.6
    rows[~rows.any(axis=1), 0] = 1
    return rows


def check(structure, route, seeds):
    """Simulate and judge the mode after every event; return how many were judged, and in how many contacts slip."""
    program = sf.prepare(structure.scene, 1e-9 if route == "integrators" else 1e-11, route)
    judged, slipped = 0, 0
    for seed in seeds:
        values, start = structure.draw(seed)
        run, friction = program.run(values, start).checked(), structure.friction(values)
        times = np.unique([0.0, *(e.t for e in run.events)])
        for t in times[np.diff(times, prepend=-1.0) > 1e-5][:12]:
            k = np.searchsorted(run.t, t + 1e-7) - 1
            if k + 1 >= run.t.size or run.t[k + 1] - t < 1e-4:
                continue  # the next event follows
            (q, u), mode = np.split(run(t), 2), run.mode[:, k].astype(int)
            resting = np.abs(structure.rows @ u - structure.surfaces @ q) < 1e-8
            assert np.all(resting[mode == 0])
            assert agrees(friction, mode, resting, q, u, t), (seed, t, mode)
            assert not holding_more(friction, mode, resting, q, u, t), (seed, t, mode)
            judged, slipped = judged + 1, slipped + bool(np.any(resting & (mode != 0)))
    return judged, slipped


@pytest.mark.long(beside="test_where_another_lets_go_in_passing_no_further_contact_can_stick")
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize(("n", "runs"), [(2, 40), (3, 20)])
def test_in_chains_no_further_contact_can_stick(n, runs, route):
    judged, slipped = check(Structure(chain(n)), route, range(runs))
    assert judged > 4 * runs
    assert slipped > runs


@pytest.mark.long(beside="test_where_another_lets_go_in_passing_no_further_contact_can_stick")
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize(("n", "runs"), [(2, 400), (3, 300), (4, 150)])
def test_in_many_chains_no_further_contact_can_stick(n, runs, route):
    judged, slipped = check(Structure(chain(n)), route, range(100, 100 + runs))
    assert judged > 4 * runs
    assert slipped > runs


@pytest.mark.long(beside="test_where_another_lets_go_in_passing_no_further_contact_can_stick")
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("seed", [0, 8])
def test_beside_any_rows_no_further_contact_can_stick(seed, route):
    judged, slipped = check(Structure(random_rows(seed)), route, range(6))
    assert judged > 20
    assert slipped > 10


@pytest.mark.long(beside="test_where_another_lets_go_in_passing_no_further_contact_can_stick")
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("seed", range(5, 45))
def test_beside_many_rows_no_further_contact_can_stick(seed, route):
    check(Structure(random_rows(seed)), route, range(12))


def parted(seed):
    """Return a structure of contacts more than velocities whose surfaces meet at instants only."""
    rng = np.random.default_rng([6, seed])
    n = int(rng.integers(1, 4))
    rows = rng.integers(-1, 2, (int(rng.integers(n + 1, n + 3)), n))
    rows[~rows.any(axis=1), 0] = 1
    return Structure(rows, surfaces=rng.uniform(-2, 2, rows.shape) * (rng.random(rows.shape) < 0.7))


@pytest.mark.one_in(8)
@pytest.mark.parametrize("route", ROUTES[1:])
@pytest.mark.parametrize("seed", range(4))
def test_where_another_lets_go_in_passing_no_further_contact_can_stick(seed, route):
    """A slip that passes zero turns the friction of its contact, and others that stick may not bear that."""
    judged, slipped = check(parted(seed), route, range(20))
    assert judged > 20
    assert slipped > 10


@pytest.mark.long(beside="test_where_another_lets_go_in_passing_no_further_contact_can_stick")
@pytest.mark.parametrize("route", ROUTES[1:])
@pytest.mark.parametrize("seed", range(4, 44))
def test_at_many_instants_where_surfaces_meet_no_further_contact_can_stick(seed, route):
    check(parted(seed), route, range(30))


@pytest.mark.parametrize("route", ROUTES)
def test_parallel_contacts_stick_again_together(route):
    """Two contacts on one mass stop while a third lets go: neither alone can hold the mass beside the other's slip."""
    assert check(Structure(random_rows(29)), route, [11])[0] > 0


@pytest.mark.parametrize("route", ROUTES[:2])
def test_what_stops_with_another_sticks_though_rounding_has_left_it_a_speed(route):
    """Three contacts on one mass stop at once; the zero of two of them makes that of the third, which was not found."""
    assert check(Structure(random_rows(26)), route, [9])[0] > 0


def test_of_two_contacts_whose_surfaces_part_the_one_that_can_sticks():
    assert check(parted(9), "integrators", [3])[0] > 0


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [2, 3])
def test_what_sticks_does_not_depend_on_the_order_of_the_contacts(n):
    rows = chain(n)
    structures = [Structure(rows), Structure(rows, np.random.default_rng(n).permutation(len(rows)))]
    programs = [sf.prepare(s.scene, 1e-11, "taylor") for s in structures]
    for seed in range(80):
        run, other = (program.run(*structures[0].draw(seed)).checked() for program in programs)
        logs = [sorted((e.contact, e.before, e.after) for e in r.events) for r in (run, other)]
        assert logs[0] == logs[1]
        assert run.final == pytest.approx(other.final, abs=1e-8)


def pulled(load, route, end):
    """Return the run of two unit masses at rest whose first is pulled by t/2; ground loads .4 and .2, a joint's load."""
    (x, y), (u, v) = sp.symbols("x y", real=True), sp.symbols("u v", real=True)
    law = sf.laws.coulomb(STATIC, 0.5)
    contacts = [
        sf.Contact("first", u, 0.4, law),
        sf.Contact("second", v, 0.2, law),
        sf.Contact("joint", u - v, load, law),
    ]
    system = sf.System([x, y], [u, v], sp.eye(2), [T / 2, 0])
    return sf.simulate(sf.Scene(system, contacts, {}, dict.fromkeys((x, y, u, v), 0), end), 1e-10, route).checked()


@pytest.mark.one_in(6)
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("load", [0.2, 0.2043, 0.21, 0.2166])
def test_the_second_mass_stays_at_rest_where_the_slipping_joint_cannot_move_it(load, route):
    """Both ground contacts reach their bounds at a pull of .36, the joint cannot carry the second mass along.

    Its friction falls to half its load then, less than what the second contact can hold.
    """
    begin, end = 0.72, 1.0
    speed = (end**2 - begin**2) / 4 - (0.2 + 0.5 * load) * (end - begin)
    run = pulled(load, route, end)
    assert run.final[1] == 0.0
    assert run.final[2:] == pytest.approx([speed, 0.0], abs=1e-9)
    assert {(e.contact, e.after) for e in run.events} == {("first", 1), ("joint", 1)}


@pytest.mark.one_in(9)
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("load", [0.2168, 0.22, 0.24, 0.25, 0.3])
def test_the_joint_slips_when_it_cannot_carry_the_second_mass_any_longer(load, route):
    """The masses go together from a pull of .36, and part where the joint would need more than it can hold.

    With the pull p they have the acceleration (p - .3)/2, the joint bears that of the second mass and .1.
    """
    begin, apart, end = 0.72, 2 * (2 * (STATIC * load - 0.1) + 0.3), 1.0
    together = ((apart**2 - begin**2) / 4 - 0.3 * (apart - begin)) / 2
    gained = (end**2 - apart**2) / 4 - (0.2 + 0.5 * load) * (end - apart)
    run = pulled(load, route, end)
    assert run.final[2:] == pytest.approx([together + gained, together + (0.5 * load - 0.1) * (end - apart)], abs=1e-9)
    assert [e.t for e in run.events] == pytest.approx([begin, begin, apart], abs=1e-9)
