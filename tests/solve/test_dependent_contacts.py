"""More sticking contacts than independent slips: they hold as long as any forces within their bounds do."""

from itertools import permutations

import numpy as np
import pytest
import sympy as sp
from scipy import optimize

import symfric as sf
from tests.longer import longer

X, Y, U, V = sp.symbols("x y u v", real=True)
T = sf.TIME
ORDERS = list(permutations(range(3)))


def two_masses(pull, ratio, order=(0, 1, 2), bounds=(1.0, 1.0, 0.5), **more):
    """Two unit masses on the ground, and rubbing on each other; `ratio` is kinetic over static friction."""
    slips = {"first": U, "second": V, "between": U - V}
    contacts = [
        sf.Contact(n, s, 1, sf.laws.coulomb(b, ratio * b)) for (n, s), b in zip(slips.items(), bounds, strict=True)
    ]
    system = sf.System([X, Y], [U, V], [[1, 0], [0, 1]], pull)
    values = more.pop("values", {})
    return sf.Scene(system, [contacts[k] for k in order], values, {X: 0, Y: 0, U: 0, V: 0}, 3.0, **more)


def pulled(start, ratio):
    """Return place and speed at t = 3 of a unit mass under t, less kinetic friction of `ratio` times `start`."""
    u = (9 - start**2) / 2 - ratio * start * (3 - start)
    return (27 - start**3) / 6 - start**2 / 2 * (3 - start) - ratio * start * (3 - start) ** 2 / 2, u


@pytest.mark.one_in(6)
@pytest.mark.parametrize("route", ["taylor", "exact", "integrators"])
@pytest.mark.parametrize("ratio", [1.0, 0.6])
def test_masses_start_where_no_forces_hold_them_whatever_the_order(route, ratio):
    """Ground and neighbour carry 1.5 together; what the neighbour takes, the ground below it carries on."""
    x, u = pulled(1.5, ratio)
    for order in ORDERS if route == "taylor" else ORDERS[::3]:
        run = sf.simulate(two_masses([T, 0], ratio, order), 1e-11 if route != "integrators" else 1e-9, route).checked()
        assert run.final == pytest.approx([x, 0, u, 0], abs=1e-7)
        assert sorted((e.contact, e.after) for e in run.events) == [("between", 1), ("first", 1)]
        assert [e.t for e in run.events] == pytest.approx([1.5, 1.5], abs=1e-8)
        run = sf.simulate(two_masses([T, -T], ratio, order), 1e-11 if route != "integrators" else 1e-9, route).checked()
        assert run.final == pytest.approx([x, -x, u, -u], abs=1e-7)
        assert sorted((e.contact, e.after) for e in run.events) == [("between", 1), ("first", 1), ("second", -1)]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("order", ORDERS)
def test_forces_of_dependent_contacts_balance_and_stay_within_their_bounds(order):
    force = {n: sf.friction_force(n) for n in ("first", "second", "between")}
    wanted = {n: sf.Max(sp.Abs(e)) for n, e in force.items()}
    wanted |= {"on one": sf.Integral(force["first"] + force["between"])}
    wanted |= {"on other": sf.Integral(force["second"] - force["between"])}
    run = sf.simulate(two_masses([T, T / 4], 0.5, order, outputs=wanted).until(1.4), 1e-12, "taylor").checked()
    assert [run["on one"], run["on other"]] == pytest.approx([-0.98, -0.245], abs=1e-12)
    assert run["first"] <= 1 + 1e-12
    assert run["second"] <= 1 + 1e-12
    assert run["between"] <= 0.5 + 1e-12
    assert run.stats["events"] == 0


@pytest.mark.one_in(6)
@pytest.mark.parametrize("route", ["exact", "taylor", "integrators"])
@pytest.mark.parametrize("factors", [(1, -2, 3), (-2, 1, 0.5), (3, -0.5, -1)])
def test_parallel_contacts_share_in_proportion_to_their_bounds_whatever_their_directions(factors, route):
    """Contact i, of slip f_i u and bound b_i, carries b_i sign(f_i) of the sum of b_k |f_k|; it yields when all do."""
    bounds = np.array([0.3, 0.5, 0.2])
    names = ("one", "two", "three")
    total = float(bounds @ np.abs(factors))
    for way in (-1, 1):
        scene = sf.Scene(
            sf.System([X], [U], [[1]], [way * T]),
            [
                sf.Contact(n, f * U, b, sf.laws.coulomb(1.0, 0.5))
                for n, f, b in zip(names, factors, bounds.tolist(), strict=True)
            ],
            {},
            {X: 0.0, U: 0.0},
            total + 0.5,
            {n: sf.At(sf.friction_force(n), 0.9 * total) for n in names} | {"events": sf.Events()},
        )
        run = sf.simulate(scene, 1e-9 if route == "integrators" else 1e-11, route).checked()
        held = -way * 0.9 * bounds * np.sign(factors)
        assert [run[n] for n in names] == pytest.approx(held.tolist(), rel=1e-9)
        assert {(e.contact, e.after) for e in run.events} == {
            (n, way * np.sign(f)) for n, f in zip(names, factors, strict=True)
        }
        assert [e.t for e in run.events] == pytest.approx([total] * 3, rel=1e-8)


def test_derivatives_pass_the_exchange_of_contacts():
    """The ground reaches its bound at t = 1, the neighbour at 1.5 its own; only then the motion depends on both."""
    a, b = sp.symbols("a b", positive=True)
    run = sf.simulate(
        two_masses([T, 0], 1.0, bounds=(a, 1.0, b), values={a: 1.0, b: 0.5}), 1e-12, "taylor", sensitivities=("a", "b")
    )
    for name in "ab":  # the pull minus both: 1.5 less a place of 1.5^2 / 2 and a speed of 1.5
        assert run.sensitivities[name] == pytest.approx([-1.125, 0, -1.5, 0], abs=1e-9)


def test_slips_that_agree_only_by_the_numbers_of_a_run_hold_together():
    r, v, w = sp.symbols("r v_1 v_2", positive=True)
    law = sf.laws.coulomb(0.5, 0.3)
    values = {r: 1.0, v: 0.1, w: 0.1}
    system, start = sf.System([X], [U], [[1]], [-X]), {X: 0.2, U: 0.1}
    pair = [sf.Contact("a", r * U - v, 0.6, law), sf.Contact("b", U - w, 0.4, law)]
    one = [sf.Contact("a", r * U - v, 1.0, law)]
    two, single = (
        sf.simulate(sf.Scene(system, c, {k: e for k, e in values.items() if c is pair or k != w}, start, 20), 1e-11)
        for c in (pair, one)
    )
    assert two.checked().final == pytest.approx(single.checked().final, abs=1e-8)
    assert len(two.events) == 2 * len(single.events)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("apart", [3e-9, 1e-6])
def test_a_contact_that_nearly_follows_from_another_leaves_its_load_to_a_third(apart):
    """Alone, two nearly equal slips hold across with forces of the load over their difference."""
    law = sf.laws.coulomb(0.5)  # with a drop the one that slips by no more than the difference loses friction

    def final(e):
        contacts = [
            sf.Contact("a", U - V, 1, law),
            sf.Contact("b", (1 + e) * U - V, 1, law),
            sf.Contact("c", V, 1.5, law),
        ]
        system = sf.System([X, Y], [U, V], [[1, 0], [0, 1]], [2 * sp.sin(T) - X, sp.cos(2 * T) - Y])
        return sf.simulate(sf.Scene(system, contacts, {}, {X: 0.1, Y: 0, U: 0, V: 0}, 8), 1e-11).checked().final

    assert final(apart) == pytest.approx(final(0), abs=20 * apart)


class Family:
    """Two to four velocities and up to three contacts more, with whole-numbered rows drawn at random.

    Some contacts are carried by a moving frame, some loads vary.
    """

    def __init__(self, seed):
        rng = np.random.default_rng([77, seed])
        n = int(rng.integers(2, 5))
        n_c = n + int(rng.integers(1, 4))
        J = rng.integers(-2, 3, (n_c, n))
        J[~J.any(axis=1)] = 1
        self.q, self.u = (sp.symbols(f"{letter}1:{n + 1}", real=True) for letter in "qu")
        root = rng.normal(size=(n, n))
        K, self.M = 0.3 * root @ root.T + 0.5 * np.eye(n), np.diag(rng.uniform(0.5, 2, n))
        frame = [e * sp.sin(w * T) for e, w in rng.uniform((-0.3, 1), (0.3, 3), (n, 2))] if seed % 3 == 0 else [0] * n
        self.belts = [sum((int(J[i, j]) * frame[j] for j in range(n)), sp.Integer(0)) for i in range(n_c)]
        self.loads = (
            [1 + e * sp.sin(w * T) for e, w in rng.uniform((0, 1), (0.8, 4), (n_c, 2))] if seed % 2 else [1] * n_c
        )
        self.static = rng.uniform(0.1, 0.6, n_c)
        self.kinetic = self.static * np.where(rng.random(n_c) < 0.3, 1, rng.uniform(0.5, 1, n_c))
        pulls = rng.uniform((0.5, 0.6, 0), (2.5, 2.5, 6), (n, 3))
        self.force = [
            a * sp.sin(w * T + b) - sum(K[j, k] * self.q[k] for k in range(n)) - self.u[j] / 20
            for j, (a, w, b) in enumerate(pulls)
        ]
        self.start = dict(zip((*self.q, *self.u), rng.uniform(-0.5, 0.5, 2 * n) * (rng.random() < 0.6), strict=True))
        self.J, self.n, self.n_c = J, n, n_c

    def run(self, order, tolerance=1e-11, route="taylor"):
        slips = self.J @ np.array(self.u, dtype=object)
        contacts = [
            sf.Contact(
                f"c{i}", slips[i] - self.belts[i], self.loads[i], sf.laws.coulomb(self.static[i], self.kinetic[i])
            )
            for i in order
        ]
        system = sf.System(self.q, self.u, sp.Matrix(self.M), self.force)
        return sf.simulate(sf.Scene(system, contacts, {}, self.start, 5.0), tolerance, route).checked()

    def spare(self, t, y, mode):
        """Return which part of all bounds is not needed to hold the contacts that stick, and how well forces hold."""
        value = lambda e: np.array(sp.lambdify([T, *self.q, *self.u], e)(t, *y), dtype=float)  # noqa: E731
        stick, J, load = mode == 0, self.J.astype(float), value(self.loads)
        force = value(self.force) - J[~stick].T @ (mode * load * self.kinetic)[~stick]
        A = J[stick] @ np.linalg.inv(self.M) @ J[stick].T
        wanted = value([sp.diff(e, T) for e in self.belts])[stick] - J[stick] @ np.linalg.inv(self.M) @ force
        left, size, right = np.linalg.svd(A)
        rank = int(np.sum(size > 1e-11 * size[0]))
        bounds, one = (load * self.static)[stick], np.eye(int(np.sum(stick)))
        found = optimize.linprog(
            np.append(0 * bounds, -1),
            np.block([[one, bounds[:, None]], [-one, bounds[:, None]]]),
            np.tile(bounds, 2),
            np.column_stack([right[:rank], np.zeros(rank)]),
            (left.T @ wanted)[:rank] / size[:rank],
            [(None, None)] * len(bounds) + [(None, 1)],
        )
        return -found.fun, np.max(np.abs((left.T @ wanted)[rank:]), initial=0.0)


@pytest.mark.long(beside="test_random_dependent_contacts_agree_with_the_independent_route")
@pytest.mark.parametrize("seed", longer(range(8), (1, 2, 5, 6)))
def test_random_dependent_contacts_slip_only_where_they_must(seed):
    family = Family(seed)
    orders = [np.arange(family.n_c), np.random.default_rng(seed).permutation(family.n_c)]
    run, other = (family.run(order) for order in orders)
    assert run.final == pytest.approx(other.final, abs=1e-9)
    logs = [sorted((e.contact, e.before, e.after) for e in r.events) for r in (run, other)]
    assert logs[0] == logs[1]
    assert run.energy_residual() < 1e-10
    belts = sp.lambdify(T, family.belts)
    held = 0
    for k in range(run.t.size - 1):
        if run.t[k + 1] - run.t[k] < 1e-9:
            continue
        mode, middle = run.mode[:, k], 0.5 * (run.t[k] + run.t[k + 1])
        slip = family.J @ run(middle)[family.n :] - np.array(belts(middle), dtype=float)
        assert np.max(np.abs(slip[mode == 0]), initial=0) < 1e-9
        assert np.min((mode * slip)[mode != 0], initial=0) > -1e-9
        if np.any(mode == 0):
            held += 1
            spare, apart = family.spare(middle, run(middle), mode)
            assert spare > -1e-7
            assert apart < 1e-9
    assert held > 0
    for t in {e.t for e in run.events if e.t > 0}:
        at_once = [e for e in run.events if abs(e.t - t) < 1e-9]
        mode = run.mode[:, np.searchsorted(run.t, t - 1e-7) - 1]
        slip = family.J @ run(t)[family.n :] - np.array(belts(t), dtype=float)
        if all(e.before == 0 for e in at_once) and np.min(np.abs(slip[mode != 0]), initial=1) > 1e-6:
            assert family.spare(t, run(t), mode)[0] == pytest.approx(0, abs=1e-6)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", [0, 3, 4])
def test_random_dependent_contacts_agree_with_the_independent_route(seed):
    family = Family(seed)
    order = np.arange(family.n_c)
    assert family.run(order, 1e-9, "integrators").final == pytest.approx(family.run(order).final, abs=1e-7)
