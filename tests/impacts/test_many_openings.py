"""More contacts at once than combinations can be tried: forces, impacts and runs against complementarity and closed forms."""

from functools import cache

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.impacts.impact_laws import Touching, by_pivots
from tests.impacts.impact_reference import T
from tests.impacts.impact_scenes import MAKERS
from tests.impacts.test_random_scenes import drawn
from tests.longer import longer

G = 9.81
SOON = 1e-3  # horizon of a run that shows the accelerations at its start


@cache
def bodies(n, rubbing):
    """Return the program of n contacts in a random linear system, of which some rub, with its rows; all numbers are values."""
    size = n + rubbing + 1
    q, u = sp.symbols(f"q:{size}", real=True), sp.symbols(f"u:{size}", real=True)
    f, e, mu = (
        sp.symbols(f"f:{size}", real=True),
        sp.symbols(f"e:{n}", nonnegative=True),
        sp.Symbol("mu", positive=True),
    )
    rng = np.random.default_rng(10 * n + rubbing)
    part = rng.normal(size=(size, size)) * 0.3
    mass = np.eye(size) + part @ part.T
    rows = rng.normal(size=(n + rubbing, size))  # normal directions, then those of friction

    def along(row, of):
        return sum((sp.Float(c) * s for c, s in zip(row, of, strict=True)), sp.S.Zero)

    contacts = []
    for k in range(n):
        gap = sf.Unilateral(along(rows[k], q), restitution=e[k])
        slip = along(rows[n + k], u) if k < rubbing else None
        contacts.append(
            sf.Contact(f"c{k}", slip, gap, sf.laws.coulomb(mu)) if k < rubbing else sf.Contact(f"c{k}", None, gap)
        )
    start = dict.fromkeys((*q, *u), 0.0)
    values = dict.fromkeys((*f, *e), 0.0) | ({mu: 0.1} if rubbing else {})
    scene = sf.Scene(sf.System(q, u, sp.Matrix(mass), f), contacts, values, start, SOON, outputs={"end": sf.End()})
    return sf.prepare(scene, 1e-12), mass, rows, [s.name for s in u]


def touching(mass, rows, n, rubbing, mu, e):
    """Return the contacts for the tests' own method, whose rows of friction come first."""
    order = [*range(n, n + rubbing), *range(n)]
    J = rows[order]
    return Touching(J @ np.linalg.solve(mass, J.T), list(range(rubbing)), np.full(n, mu), np.full(n, mu), e), J


SIZES = [(6, 6), (15, 0), (8, 4), (12, 12), (20, 20)]


def complementary(c, z, r, target, mu, tolerance):
    """Whether impulses of contacts satisfy unilateral contact and Coulomb's law, relative to the rates."""
    f, after, scale = len(c.lines), z + c.W @ r, np.max(np.abs(z))
    q, p, w, a = r[:f], r[f:], after[:f], after[f:] - target
    sizes = np.diag(c.W)
    assert np.min(p * sizes[f:]) > -tolerance * scale
    assert np.min(a) > -tolerance * scale
    assert np.max(np.abs(np.minimum(p * sizes[f:], a))) < tolerance * scale
    room = (mu * p[:f] - np.abs(q)) * sizes[:f]
    assert np.all(room > -tolerance * scale)
    slides = np.abs(w) > tolerance * scale
    assert np.all(np.abs(room[slides]) < tolerance * scale)
    assert np.all((q * w)[slides] <= tolerance * scale)


def one_impact(n, rubbing, seed):
    program, mass, rows, names = bodies(n, rubbing)
    rng = np.random.default_rng([n, rubbing, seed])
    mu, e = rng.choice([0.05, 0.3]), rng.uniform(0, 0.4, n) * rng.integers(0, 2)
    before = rng.normal(size=mass.shape[0])
    values = ({"mu": mu} if rubbing else {}) | {f"e{k}": e[k] for k in range(n)}
    c, J = touching(mass, rows, n, rubbing, mu, e)
    z = J @ before
    if np.min(z[rubbing:]) > 0:
        return
    run = program.run(values=values, initial=dict(zip(names, before, strict=True)))
    gained = run.checked().final[mass.shape[0] :] - before
    impulses = np.linalg.lstsq(np.linalg.solve(mass, J.T), gained, rcond=None)[0]
    target = e * np.maximum(-z[rubbing:], 0)
    share = 1.0
    if rubbing < n or np.any(e):
        held = impulses[rubbing:] > 1e-9 * np.max(impulses[rubbing:])
        moving = held & (target > 0)
        if np.any(moving):
            share = float(np.median((z + c.W @ impulses)[rubbing:][moving] / target[moving]))
    assert share <= 1 + 1e-9
    complementary(c, z, impulses, share * target, mu, 1e-8)
    energy = impulses @ (z + 0.5 * c.W @ impulses)
    assert energy < 1e-10 * np.abs(impulses) @ np.abs(z)
    if share == pytest.approx(1):
        other = by_pivots(c, z)
        assert c.W @ other == pytest.approx(c.W @ impulses, abs=1e-8 * np.max(np.abs(z)))


def one_start(n, rubbing, seed):
    """Compare the motion just after a start at rest with the accelerations of the tests' own method."""
    program, mass, rows, _ = bodies(n, rubbing)
    rng = np.random.default_rng([n, rubbing, seed, 1])
    mu, force = rng.choice([0.05, 0.3]), rng.normal(size=mass.shape[0])
    values = ({"mu": mu} if rubbing else {}) | {f"f{k}": force[k] for k in range(mass.shape[0])}
    run = program.run(values=values)
    c, J = touching(mass, rows, n, rubbing, mu, np.zeros(n))
    free = np.linalg.solve(mass, force)
    right = free + np.linalg.solve(mass, J.T @ by_pivots(c, J @ free))
    assert run.checked().final[mass.shape[0] :] / SOON == pytest.approx(right, abs=1e-8 * np.max(np.abs(free)))


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("n", "rubbing"), SIZES)
@pytest.mark.parametrize("number", longer([2, 20], [20]))
def test_impacts_of_many_contacts_are_complementary(number, n, rubbing):
    for seed in range(number):
        one_impact(n, rubbing, seed)


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("n", "rubbing"), SIZES)
@pytest.mark.parametrize("number", longer([2, 20], [20]))
def test_forces_of_many_contacts_are_those_of_another_method(number, n, rubbing):
    for seed in range(number):
        one_start(n, rubbing, seed)


def copied(structure, values, start, k):
    """Return the scene of k copies of a structure beside each other, at the same start."""
    b, clock = structure.bodies, {T: sf.TIME}
    contacts, force, q, u = [], [], [], []
    for i in range(k):
        names = clock | {s: sp.Symbol(f"{s.name}_{i}", real=True) for s in (*b.q, *b.u)}
        q += [names[s] for s in b.q]
        u += [names[s] for s in b.u]
        force += [f.xreplace(names) for f in b.force]
        for c in b.touches:
            gap = sf.Unilateral(c.gap.xreplace(names), restitution=c.e)
            contacts.append(sf.Contact(f"{c.name} {i}", c.slip.xreplace(names), gap, sf.laws.coulomb(c.mu)))
    numbers = {p: values[p.name] for p in b.parameters}
    n = len(b.q)
    first = dict(zip((*q, *u), (*(start[:n] * k), *(start[n:] * k)), strict=True))
    mass = sp.diag(*[b.mass] * k).tolist()
    return sf.Scene(
        sf.System(q, u, mass, force), contacts, numbers, first, structure.horizon, outputs={"end": sf.End()}
    )


COPIES = [("rod_above_floor", 4), ("disk_in_corner", 4), ("block_on_shaken_floor", 4), ("disks_that_push", 3)]


@pytest.mark.long(beside="test_a_rod_on_many_feet_tips_about_the_last")
@pytest.mark.parametrize(("name", "k"), COPIES)
def test_copies_beside_each_other_move_as_one(name, k):
    structure = next(make for make in MAKERS if make.__name__ == name)()
    values, start = drawn(structure, 0)
    n = len(structure.bodies.q)
    alone = sf.prepare(structure.scene(values, start), tolerance=1e-12)
    together = sf.prepare(copied(structure, values, start, k), tolerance=1e-12)
    names = [s.name for s in (*structure.bodies.q, *structure.bodies.u)]
    for seed in range(8):
        values, start = drawn(structure, seed)
        right = alone.run(values=values, initial=dict(zip(names, start, strict=True))).checked().final
        initial = {f"{s}_{i}": e for s, e in zip(names, start, strict=True) for i in range(k)}
        found = together.run(values=values, initial=initial).checked().final.reshape(2, k, n)
        off = np.max(np.abs(found - right.reshape(2, 1, n)) / (1 + np.abs(right.reshape(2, 1, n))))
        assert off < 1e-6, seed


def lifted_by_a_rope(n):
    """Return blocks on a table, joined by springs along and across; the last one is pulled away and up."""
    x, y, u, v = (sp.symbols(f"{s}:{n}", real=True) for s in "xyuv")
    k, fx, fy = 400.0, [sp.S.Zero] * n, [sp.Float(-G)] * n
    for i in range(n - 1):
        for f, q in ((fx, x), (fy, y)):
            f[i] += k * (q[i + 1] - q[i])
            f[i + 1] -= k * (q[i + 1] - q[i])
    fx[-1] += k * (0.3 * sf.TIME - x[-1])
    fy[-1] += k * (0.15 * sf.TIME - y[-1])
    law = sf.laws.coulomb(0.3)
    contacts = [sf.Contact(f"c{i}", u[i], sf.Unilateral(y[i]), law) for i in range(n)]
    start = dict.fromkeys((*x, *y, *u, *v), 0.0)
    return sf.Scene(sf.System([*x, *y], [*u, *v], sp.eye(2 * n), [*fx, *fy]), contacts, {}, start, 0.6)


@pytest.mark.long(beside="test_a_rod_on_many_feet_tips_about_the_last")
def test_a_chain_on_a_table_lifts_as_a_shorter_one_and_balances():
    """Blocks that nothing has reached yet change nothing: four are tried in all combinations, ten and twenty are not."""
    runs = {n: sf.simulate(lifted_by_a_rope(n), tolerance=1e-12).checked() for n in (4, 10, 20)}
    for n in (10, 20):
        assert runs[n].energy_residual() < 1e-9
    first = [(e.t, e.kind) for e in runs[20].events]
    assert [kind for _, kind in first] == [e.kind for e in runs[10].events]
    assert [t for t, _ in first] == pytest.approx([e.t for e in runs[10].events], abs=1e-9)
    assert [t for t, _ in first[:4]] == pytest.approx([e.t for e in runs[4].events[:4]], abs=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [6, 20])
def test_a_rod_on_many_feet_tips_about_the_last(n):
    """Its feet hold it more than twice: which of them press is not determined, what the rod does is."""
    y, th, v, om = sp.symbols("y th v om", real=True)
    load, at = sp.symbols("load at", real=True)
    places = np.linspace(-1, 1, n)
    contacts = [sf.Contact(f"f{i}", None, sf.Unilateral(y + sp.Float(p) * th)) for i, p in enumerate(places)]
    inertia = sp.Rational(1, 3)
    system = sf.System([y, th], [v, om], sp.diag(1, inertia), [-G - load, -load * at])
    start = dict.fromkeys((y, th, v, om), 0.0)
    program = sf.prepare(sf.Scene(system, contacts, {load: 1.0, at: 0.0}, start, 0.01), tolerance=1e-12)
    for where in (-0.9, 0.0, 0.7, 1.5, -1.9):
        run = program.run({"load": 20.0, "at": where}).checked()
        side = np.sign(where)
        turns = 20.0 * (abs(where) - 1) - G  # about the foot on that side
        rate = -side * max(turns, 0.0) / (1 + 1 / 3)
        assert run.final == pytest.approx(
            [-side * rate * 5e-5, rate * 5e-5, -side * rate * 0.01, rate * 0.01], abs=1e-12
        )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [8, 20])
def test_blocks_in_a_row_are_pushed_together(n):
    """A force at the first one moves all, none, or holds by friction, as the sum of their bounds says."""
    x, y, u, v = (sp.symbols(f"{s}:{n}", real=True) for s in "xyuv")
    push, law = sp.Symbol("push"), sf.laws.coulomb(0.2)
    on_table = [sf.Contact(f"t{i}", u[i], sf.Unilateral(y[i]), law) for i in range(n)]
    between = [sf.Contact(f"b{i}", None, sf.Unilateral(x[i + 1] - x[i])) for i in range(n - 1)]
    force = [push, *[sp.S.Zero] * (n - 1), *[sp.Float(-G)] * n]
    start = dict.fromkeys((*x, *y, *u, *v), 0.0)
    scene = sf.Scene(
        sf.System([*x, *y], [*u, *v], sp.eye(2 * n), force), [*on_table, *between], {push: 1.0}, start, 0.1
    )
    program = sf.prepare(scene, tolerance=1e-12)
    for share in (-0.5, 0.3, 0.99, 1.01, 3.0):
        bound = 0.2 * G * n
        run = program.run({"push": share * bound}).checked()
        if share > 0:
            right = np.full(n, max(share * bound - bound, 0.0) / n)
        else:
            right = np.array([share * bound + 0.2 * G, *[0.0] * (n - 1)])  # the first one alone is pulled away
        assert run.final[2 * n : 3 * n] == pytest.approx(right * 0.1, abs=1e-12)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("n", "status"), [(3, sf.Status.PAINLEVE), (16, sf.Status.MANY_CONTACTS)])
def test_forces_without_a_solution_end_the_run(n, status):
    """Friction presses every contact on its own floor; of many it is only known that none was found."""
    x, y, u, v = (sp.symbols(f"{s}:{n}", real=True) for s in "xyuv")
    mu = sp.Symbol("mu", positive=True)
    contacts = [sf.Contact(f"c{i}", u[i], sf.Unilateral(y[i]), sf.laws.coulomb(mu)) for i in range(n)]
    one, coupled = sp.eye(n), -sp.Rational(3, 5) * sp.eye(n)
    mass = one.row_join(coupled).col_join(coupled.row_join(one))
    start = dict.fromkeys((*x, *y, *v), 0.0) | dict.fromkeys(u, 1.0)
    system = sf.System([*x, *y], [*u, *v], mass, [*[sp.S.Zero] * n, *[sp.Float(-G)] * n])
    program = sf.prepare(sf.Scene(system, contacts, {mu: 2.0}, start, 0.1))
    run = program.run()
    assert run.status == status
    assert "friction" in run.advice
    assert program.run({"mu": 1.0}).status == sf.Status.OK
