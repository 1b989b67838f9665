"""Scenes from matrices: the numbers of SymPy entries, published motions, and costs that grow linearly."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

st = sf.structures
V = sp.Symbol("v_b", positive=True)
LAWS = {"Stribeck": sf.laws.stribeck(0.4, 0.3, 0.3), "Coulomb": sf.laws.coulomb(0.4, 0.3)}


def matrices(n, full, seed=1):
    rng = np.random.default_rng(seed)
    w = np.sort(rng.uniform(0.5, 3, n))
    A = 0.05 * rng.standard_normal((n, n)) if full else np.zeros((n, n))
    rows = rng.standard_normal((8, n)) / np.sqrt(n)
    return np.eye(n) + A @ A.T, np.diag(w**2), 0.01 * np.diag(w**2), rows, 0.3 * rng.standard_normal(n)


def from_matrices(n, contacts, law, full=True, load=False, **more):
    M, K, C, rows, start = matrices(n, full)
    normal = [st.RowLoad(1 + 0.1 * i, 0.2 * rows[-1]) if load else 1 + 0.1 * i for i in range(contacts)]
    found = [st.RowContact(f"c{i}", rows[i], normal[i], law, speed=V) for i in range(contacts)]
    return st.Structure(M, K, C).scene(found, values={V: 0.2}, initial=start, **{"horizon": 20.0, **more})


def from_expressions(n, contacts, law, full=True, load=False):
    """The same scene with every entry a SymPy expression."""
    M, K, C, rows, _ = matrices(n, full)
    given = from_matrices(n, contacts, law, full, load)
    q, u = given.system.q, given.system.u
    force = list(-(sp.Matrix(K.tolist()) * sp.Matrix(q) + sp.Matrix(C.tolist()) * sp.Matrix(u)))
    along = lambda row, states: sum(float(r) * s for r, s in zip(row, states, strict=True))  # noqa: E731
    loads = [1 + 0.1 * i + (along(0.2 * rows[-1], q) if load else 0) for i in range(contacts)]
    loads = [sp.Max(0, e) if load else e for e in loads]
    pads = [sf.Contact(f"c{i}", along(rows[i], u) - V, loads[i], law) for i in range(contacts)]
    return sf.Scene(sf.System(q, u, M.tolist(), force), pads, {V: 0.2}, given.initial, 20.0)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("n", "contacts", "law", "full", "load"),
    [(4, 2, "Coulomb", True, False), (4, 2, "Stribeck", False, True), (10, 3, "Stribeck", True, False)],
)
@pytest.mark.parametrize("route", ["taylor"])
def test_the_same_numbers_as_with_expressions(n, contacts, law, full, load, route):
    runs = [make(n, contacts, LAWS[law], full, load) for make in (from_matrices, from_expressions)]
    runs = [sf.simulate(scene, 1e-11, route=route) for scene in runs]
    assert runs[0].status == runs[1].status == sf.Status.OK
    assert runs[0].names == runs[1].names
    assert len(runs[0].events) == len(runs[1].events) > 3
    assert runs[0].final == pytest.approx(runs[1].final, abs=1e-9)
    assert runs[0].energy_residual() < 1e-7


@pytest.mark.long(beside="test_the_same_numbers_as_with_expressions")
def test_other_routes_and_derivatives_agree():
    scene = from_matrices(3, 2, LAWS["Coulomb"], full=False, horizon=8.0)
    a, b = (sf.simulate(scene, 1e-10, route=route) for route in ("taylor", "exact"))
    assert a.final == pytest.approx(b.final, abs=1e-8)
    slope = sf.simulate(scene, 1e-11, sensitivities=["v_b"]).sensitivities["v_b"]
    ends = [sf.simulate(scene.where({"v_b": 0.2 + d}), 1e-12).final for d in (-1e-6, 1e-6)]
    assert slope == pytest.approx((ends[1] - ends[0]) / 2e-6, abs=1e-4)
    batch = sf.prepare(scene.wanting({"e": sf.End()})).map({"v_b": np.array([0.2, 0.25])})
    assert batch.final[:, 1] == pytest.approx(sf.simulate(scene.where({"v_b": 0.25})).final, abs=1e-9)


def test_analyses_of_small_scenes_agree_with_expressions():
    a, b = (make(3, 1, LAWS["Stribeck"], False) for make in (from_matrices, from_expressions))
    a, b = (s.where({"v_b": 0.5}) for s in (a, b))
    assert sf.equilibrium(a).x == pytest.approx(sf.equilibrium(b).x, abs=1e-10)
    assert sf.stability(a).eigenvalues == pytest.approx(sf.stability(b).eigenvalues, abs=1e-10)
    assert [str(e.lhs) for e in a.equations()[:3]] == [str(e.lhs) for e in b.equations()[:3]]
    assert sf.theory.symbolic_hurwitz(make_one()) == sf.theory.symbolic_hurwitz(make_one().written_out())


def make_one():
    pad = st.RowContact("pad", {"x1": 1.0}, 1.0, LAWS["Stribeck"], speed=V)
    return st.chain(1, damping=0.1).scene([pad], values={V: 0.5})


def test_mode_coupling_with_lift_off():
    """Motion computed with DOP853 at 1e-12; the contact opens and closes, sticks and slips."""
    s = st.Structure(np.eye(2), [[1.05, 0.2], [0.2, 0.0]], 0.02 * np.eye(2), names=["x", "y"])
    load = st.RowLoad(1.0, {"y": 1.0}, push={"y": -1.0})
    belt = st.RowContact("belt", {"x": 1.0}, load, sf.laws.coulomb(0.4), speed=1.0)
    run = sf.simulate(s.scene([belt], initial={"x": 0.4, "y": 0.1}, horizon=60.0), 1e-12)
    assert run.final[[0, 2, 1, 3]] == pytest.approx([0.649848694, -0.0766800814, 0.742448957, -0.9750037005], abs=1e-8)
    first = [e.t for e in run.events[:2]]
    assert first == pytest.approx([30.18908855862, 31.03140183895], abs=1e-8)
    y = run.names.index("y")
    for t, way in ((27.45966650697, -1), (28.22378868685, 1)):  # where the load becomes zero, and ends being it
        assert run(t)[y] == pytest.approx(-1.0, abs=1e-9)
        assert way * (run(t + 1e-3)[y] + 1.0) > 0 > way * (run(t - 1e-3)[y] + 1.0)
    earlier = run(np.linspace(0.0, 27.459, 20001))[y]
    assert np.min(earlier) > -1.0


def test_its_onset_of_flutter():
    K, F = [[1.05, 0.2], [0.2, 1.0]], [[0, -1.0], [0, 0]]
    for c, exact in ((0.0, 0.203125), (0.02, 0.205175)):
        s = st.Structure(np.eye(2), K, c * np.eye(2), F)
        assert st.flutter(s, (0, 0.4), count=2).critical[0].mu == pytest.approx(exact, rel=1e-10)


@pytest.mark.long(beside="test_rows_over_all_degrees_of_freedom_where_both_numbers_agree")
def test_forces_and_observed_rows_of_a_reduced_structure():
    full = st.chain(40, damping=0.05)
    tip = np.zeros(40)
    tip[30] = 1.0
    pad = st.RowContact("pad", {"x15": 1.0}, 0.3, LAWS["Coulomb"], speed=0.1)
    W = sp.Symbol("W", positive=True)
    ask = {"size": sf.Max(sp.Symbol("tip", real=True))}
    runs = []
    for s in (full, full.reduced(["x15", "x35", tip], modes=30)):
        scene = s.scene(
            [pad], force=[({"x35": 1.0}, sp.cos(W * sf.TIME))], values={W: 0.05}, observe={"tip": tip},
            outputs=ask, horizon=60.0,
        )  # fmt: skip
        runs.append(sf.simulate(scene, 1e-8, route="taylor").checked()["size"])
    assert runs[1] == pytest.approx(runs[0], rel=3e-3)


def test_operations_of_a_step_grow_linearly_with_modes_and_contacts():
    from symfric.lower.automaton import lower

    sizes = {}
    for n, contacts in ((20, 4), (40, 4), (80, 4), (40, 8)):
        field = lower(from_matrices(n, contacts, LAWS["Stribeck"], full=False)).field
        sizes[n, contacts] = field.n_instructions()
    assert sizes[80, 4] - sizes[40, 4] == pytest.approx(2 * (sizes[40, 4] - sizes[20, 4]), rel=0.05)
    assert sizes[40, 8] < 2.5 * sizes[40, 4]


def test_rows_over_all_degrees_of_freedom_where_both_numbers_agree():
    full = st.chain(6)
    tip = np.eye(6)[5]
    assert full.diagonal().row(tip) == pytest.approx(full.diagonal().basis[5])


def test_fingerprints_know_the_matrices():
    from symfric.ensemble.grid import fingerprint

    a, b = from_matrices(4, 1, LAWS["Coulomb"], True), from_matrices(4, 1, LAWS["Coulomb"], False)
    assert fingerprint(a) != fingerprint(b)
    assert fingerprint(a) == fingerprint(from_matrices(4, 1, LAWS["Coulomb"], True))


S = st.chain(4)
PAD = st.RowContact("pad", {"x1": 1.0}, 1.0, LAWS["Coulomb"], speed=0.1)
FAULTS = {
    "row": (lambda: S.scene([st.RowContact("a", [1, 2], 1, LAWS["Coulomb"])]), "the row of contact 'a' has 2 entries"),
    "load": (
        lambda: S.scene([st.RowContact("a", {"x1": 1}, st.RowLoad(1, {"y": 1}), LAWS["Coulomb"])]),
        "no degree of freedom 'y'",
    ),
    "negative": (lambda: S.scene([st.RowContact("a", {"x1": 1}, -1.0, LAWS["Coulomb"])]), "not negative"),
    "law": (lambda: st.RowContact("a", {"x1": 1}, 1.0, 0.3), "use one of sf.laws"),
    "contact": (lambda: S.scene(["pad"]), "no sf.structures.RowContact"),
    "names": (lambda: S.scene([PAD, PAD]), "two contacts are called 'pad'"),
    "start": (lambda: S.scene([PAD], initial={"x9": 1.0}), "x9 in initial is no state"),
    "length": (lambda: S.scene([PAD], initial=[1.0, 2.0]), "initial has 2 entries"),
    "mu": (lambda: S.scene([PAD], mu=0.3), "no friction matrix"),
    "value": (lambda: S.scene([PAD], force={"x1": sp.Symbol("P")}), "no value for P"),
    "force": (lambda: S.scene([PAD], force=[1.0]), "force is no mapping"),
    "horizon": (lambda: S.scene([PAD], horizon=0.0), "horizon is 0.0"),
    "large": (lambda: st.chain(50).scene([PAD]).equations(), "are not written out"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_one_line_names_the_fault(fault):
    make, words = FAULTS[fault]
    with pytest.raises(sf.SceneError, match=words) as raised:
        make()
    assert "\n" not in str(raised.value)
