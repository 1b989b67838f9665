"""The route `exact` for structures: against series, against exponentials of matrices, its costs, and what it refuses."""

import numpy as np
import pytest
import sympy as sp
from exponentials import Exponentials

import symfric as sf
from symfric.lower.structure_modes import structure_matrices

st = sf.structures
COULOMB = sf.laws.coulomb(0.4, 0.3)


def numbers(n, contacts, seed, damping="modal"):
    """Random matrices with non-classical damping and friction of a load that moves, rows and a start."""
    g = np.random.default_rng(seed)
    w = np.sort(g.uniform(0.4, 3, n))
    A, B = 0.05 * g.standard_normal((2, n, n))
    M, K, C = np.eye(n), np.diag(w**2), 0.05 * np.diag(w)
    F = None
    if damping == "any":
        M, C, F = M + A @ A.T, C + B @ B.T, 0.3 * g.standard_normal((n, n)) / n
    rows = g.standard_normal((contacts + 2, n)) / np.sqrt(n)
    return M, C, K, F, rows, 0.5 * g.standard_normal(n)


def scene_of(n, contacts, seed, damping="modal", law=COULOMB, **more):
    M, C, K, F, rows, start = numbers(n, contacts, seed, damping)
    loads, speeds = 0.5 + 0.1 * np.arange(contacts), 0.1 * (np.arange(contacts) % 3)
    pads = [st.RowContact(f"c{i}", rows[i], loads[i], law, speed=speeds[i]) for i in range(contacts)]
    force = [(rows[-1], sp.Float(0.2)), (rows[-2], 0.8 * sp.cos(1.1 * sf.TIME))]
    more = {"horizon": 20.0, "force": force, "initial": start, "mu": None if F is None else 0.2, **more}
    return st.Structure(M, K, C, F).scene(pads, **more)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("n", "contacts", "damping"), [(3, 1, "any"), (8, 3, "any"), (30, 5, "modal"), (30, 2, "any")])
def test_against_exponentials_with_every_mode_tried(n, contacts, damping):
    M, C, K, F, rows, start = numbers(n, contacts, 3, damping)
    K = K if F is None else K + 0.2 * F
    loads, speeds = 0.5 + 0.1 * np.arange(contacts), 0.1 * (np.arange(contacts) % 3)
    second = Exponentials(M, C, K, rows[:contacts], loads, 0.4, 0.3, speeds, 0.2 * rows[-1], 0.8 * rows[-2], 1.1)
    final, events = second.run(start, 20.0)
    run = sf.simulate(scene_of(n, contacts, 3, damping), route="exact").checked()
    assert [(e.contact, e.before, e.after) for e in run.events] == [(f"c{i}", a, b) for _, i, a, b in events]
    assert len(events) >= 5
    assert {b for _, _, _, b in events} == {-1, 0, 1} or contacts < 3
    assert [e.t for e in run.events] == pytest.approx([t for t, *_ in events], abs=1e-10)
    assert run.final == pytest.approx(final, abs=1e-10)


def variety(seed):
    """A scene with contacts of every kind: loads that move and vanish, springs, straight lines, parallel and idle ones."""
    g = np.random.default_rng(seed)
    M, C, K, F, rows, start = numbers(9, 5, seed, "any" if seed % 2 else "modal")
    lines = sf.laws.piecewise_linear(0.5, [0.0, 0.3, 1.0], [0.4, 0.25, 0.3], 0.05)
    moving = st.RowLoad(1.5, 0.2 * rows[4]), st.RowLoad(0.2, 0.8 * rows[4])
    m, W = sp.Symbol("m", positive=True), sp.Symbol("W", positive=True)
    pads = [
        st.RowContact("lines", rows[0], 0.7, lines, speed=0.2),
        st.RowContact("moving", rows[1], moving[seed % 2], COULOMB, speed=0.1),
        st.RowContact("spring", rows[2], 0.3, sf.laws.coulomb(0.5), stiffness=2.0),
        st.RowContact("parallel", -0.7 * rows[0], 0.4, COULOMB, speed=-0.14),
        st.RowContact("loose", rows[3], 0.0, COULOMB),
    ]
    outputs = {
        "end": sf.End(),
        "events": sf.Events(),
        "force": sf.Max(sf.friction_force("lines") + sf.friction_force("spring")),
        "work": sf.Integral(sp.Symbol("q3", real=True)),
    }
    push = sp.Symbol("push", real=True)
    force = [(rows[5], sp.cos(W * sf.TIME + 0.3)), (rows[6], 0.02 * sf.TIME), (rows[6], push)]
    values = {m: 0.2, W: 1.3} if F is not None else {W: 1.3}
    structure = st.Structure(M, K, C, F)
    mu = None if F is None else m
    return structure.scene(
        pads, force, values, start, outputs, 30.0, mu=mu, inputs={push: sf.Signal(g.standard_normal(40), 0.8)}
    )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", [0, 1])
def test_against_series_with_contacts_of_every_kind(seed):
    scene = variety(seed)
    exact, series = sf.prepare(scene, route="exact"), sf.prepare(scene, 1e-13, route="taylor")
    changes = [{}, {"W": 0.9}] + ([{"m": 0.3}] if seed else [])
    for values in changes:
        a, b = (p.run(values).checked() for p in (exact, series))
        assert len(a.events) == len(b.events) > 20
        assert [e.t for e in a.events] == pytest.approx([e.t for e in b.events], abs=1e-10)
        assert a.final == pytest.approx(b.final, abs=1e-10)
        assert (a["force"], a["work"]) == pytest.approx((b["force"], b["work"]), abs=1e-10)


@pytest.mark.long(beside="test_what_is_held_by_one_coordinate_does_not_creep")
def test_the_rule_and_what_is_refused():
    n, rows = 6, np.eye(6)[:2] + 0.1
    structure = st.Structure(np.eye(n), np.diag(np.arange(1.0, 7.0)))
    pad = lambda name, law, load=1.0, **more: st.RowContact(name, rows[0], load, law, speed=0.1, **more)  # noqa: E731
    answer = sf.explain(structure.scene([pad("pad", COULOMB)]))
    assert answer.route == "exact"
    assert "by powers of the structure's matrices" in answer.answers["exact"]
    curved = structure.scene([pad("lining", sf.laws.stribeck(0.4, 0.3, 0.2))])
    assert sf.explain(curved).route == "taylor"
    refused = {
        "is not made of straight lines .contact 'lining'.": curved,
        "has memory .contact 'brush'.": structure.scene([pad("brush", sf.laws.dahl(0.3, 10.0))]),
        "the forces or a friction law are not linear": structure.scene(
            [pad("pad", COULOMB)], [(rows[1], -(sp.Symbol("q1", real=True) ** 3))]
        ),
        "the slip of contact 'shaken' depends on time": structure.scene(
            [st.RowContact("shaken", rows[0], 1.0, COULOMB, speed=sp.cos(sf.TIME))]
        ),
        "the load of contact 'pulsed', which is behind a spring": structure.scene(
            [pad("pulsed", sf.laws.coulomb(0.3), 1 + sp.cos(sf.TIME) / 2, stiffness=2.0)]
        ),
        "is no harmonic of time": structure.scene([pad("pad", COULOMB)], [(rows[1], sp.sin(sf.TIME**2))]),
    }
    for words, scene in refused.items():
        with pytest.raises(sf.NoRoute, match=words) as raised:
            sf.prepare(scene, route="exact")
        assert "\n" not in str(raised.value)
        assert sf.simulate(scene.until(2.0)).route == "taylor"


def test_a_load_behind_a_spring_that_moves_takes_whole_matrices():
    M, C, K, _, rows, start = numbers(6, 2, 5)
    pad = st.RowContact("pad", rows[0], st.RowLoad(1.0, 0.2 * rows[1]), sf.laws.coulomb(0.3), stiffness=3.0)
    scene = st.Structure(M, K, C).scene([pad], [(rows[2], sp.cos(sf.TIME))], initial=start, horizon=20.0)
    assert "load of a contact behind a spring" in sf.explain(scene).answers["exact"]
    a, b = sf.simulate(scene, route="exact"), sf.simulate(scene, 1e-13, route="taylor")
    assert len(a.checked().events) == len(b.checked().events) > 10
    assert a.final == pytest.approx(b.final, abs=1e-11)


def test_entries_that_the_mode_changes_do_not_grow_with_the_structure():
    count = {}
    for n, contacts in ((20, 4), (40, 4), (40, 8)):
        found = structure_matrices(scene_of(n, contacts, 1, force=None), [])
        count[n, contacts] = len(found.rows)
        assert found.operators.shape[1] == 2 * n
    assert count[20, 4] == count[40, 4] < count[40, 8]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("contacts", [3, 7])
def test_more_contacts_than_coordinates_and_rows_that_depend_on_others(contacts):
    """All may stick at once, although their forces are not determined then; the motion is."""
    M, C, K, _, _, start = numbers(5, 1, 2)
    rows = np.random.default_rng(contacts).standard_normal((contacts, 5))
    rows[2] = rows[0] + rows[1]
    pads = [st.RowContact(f"c{i}", row, 0.3, sf.laws.coulomb(0.4)) for i, row in enumerate(rows)]
    force = [(rows[0], sp.cos(1.1 * sf.TIME)), (rows[-1], 0.5 * sp.cos(0.7 * sf.TIME))]
    scene = st.Structure(M, K, C).scene(pads, force, initial=start, horizon=20.0)
    a, b = sf.simulate(scene, route="exact"), sf.simulate(scene, 1e-13, route="taylor")
    assert len(a.checked().events) == len(b.checked().events) > 5
    assert a.final == pytest.approx(b.final, abs=1e-10)


def test_what_is_held_by_one_coordinate_does_not_creep():
    pad = st.RowContact("pad", {"x6": 1.0}, 100.0, COULOMB, speed=0.1)
    scene = st.chain(12, damping=0.02).scene([pad], initial={"d_x6": 0.1, "x1": 1.0}, horizon=100.0)
    run = sf.simulate(scene, route="exact").checked()
    k = scene.system.states.index(sp.Symbol("d_x6", real=True))
    assert run.final[k] == 0.1
    assert run.final[5] == pytest.approx(10.0, abs=1e-13)


def test_speeds_and_loads_that_grow_with_time():
    M, C, K, _, rows, start = numbers(6, 2, 4)
    pads = [
        st.RowContact("ramp", rows[0], 0.5, COULOMB, speed=0.1 + 0.02 * sf.TIME),
        st.RowContact("spring", rows[1], 0.3 + 0.02 * sf.TIME, sf.laws.coulomb(0.4), stiffness=2.0),
    ]
    scene = st.Structure(M, K, C).scene(pads, [(rows[2], sp.cos(sf.TIME))], initial=start, horizon=20.0)
    a, b = sf.simulate(scene), sf.simulate(scene, 1e-13, route="taylor")
    assert a.route == "exact"
    assert len(a.checked().events) == len(b.checked().events) > 10
    assert a.final == pytest.approx(b.final, abs=1e-10)
