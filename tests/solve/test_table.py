"""Series as tables of operations against the same series written out."""

import ctypes

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.codegen.functions import compile_functions
from symfric.codegen.instructions import read
from symfric.lower.automaton import lower
from symfric.solve.taylor import expansion, recurrences
from symfric.solve.taylor.expansion import expand
from symfric.solve.taylor.long_sums import long_sums
from symfric.solve.taylor.table import OperationTable, length
from tests.solve.test_jets import OPERATIONS, ORDER, POINT, field_of
from tests.threads.together import difference, together

x, u, y, w, a, g = sp.symbols("x u y w a g", real=True)
HUNDREDS = sp.Add(*(sp.sin(k * x + k**2) / (10 + k) for k in range(1, 201)))


def one_mass(force, law, **more):
    """Return a mass on a belt, pulled by what depends on the parameter a."""
    contact = sf.Contact("belt", u - sp.Rational(1, 5), 1, law)
    given = {"initial": {x: 1.0, u: 0.5}, "horizon": 12.0, "values": {a: 0.9}} | more
    return sf.Scene(sf.System(q=[x], u=[u], mass=[[1]], force=[a * force]), [contact], **given)


def two_masses():
    force = [y - 2 * a * x + sp.sin(y * x), x - 2 * y]
    system = sf.System(q=[x, y], u=[u, w], mass=[[1, 0], [0, 2]], force=force)
    contacts = [
        sf.Contact("belt", u - sp.Rational(1, 5), 1, sf.laws.stribeck(0.4, 0.2, 0.1)),
        sf.Contact("floor", w, 1, sf.laws.coulomb(0.1)),
    ]
    start = {x: 0.5, u: 0.0, y: -0.4, w: 0.0}
    return sf.Scene(system, contacts, initial=start, horizon=12.0, values={a: 0.9})


WIND = sf.Signal(np.sin(np.linspace(0, 30, 25)), 0.5)
SCENES = {
    "sticking": lambda: one_mass(-x + sp.sin(3 * x + 1), sf.laws.stribeck(0.3, 0.2, 0.1)),
    "kinks": lambda: one_mass(-x - 2 * sp.Max(x - 0.4, 0) ** sp.Rational(3, 2) - sp.Abs(x), sf.laws.coulomb(0.3)),
    "time": lambda: one_mass(-x + sp.sin(2 * sf.TIME + 1) / (1 + x**2), sf.laws.coulomb(0.3, 0.2)),
    "several contacts": two_masses,
    "exponentials": lambda: one_mass(-sp.sinh(x) + sp.exp(-((sf.TIME - 3) ** 2)), sf.laws.coulomb(0.3)),
    "sampled": lambda: one_mass(-x + g * sp.cos(x), sf.laws.coulomb(0.3), inputs={g: WIND}),
    "rates that are no functions": lambda: one_mass(-sp.Integer(1), sf.laws.coulomb(0.3)),
}


@pytest.fixture
def tables(monkeypatch, tmp_path):
    """Make all series tables, and count them."""
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path))
    made = []
    function = OperationTable.function
    monkeypatch.setattr(OperationTable, "function", lambda self, *given: made.append(self) or function(self, *given))

    def switch():
        monkeypatch.setattr(expansion, "LONG", 0)
        monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path / "tables"))  # in the other are series without tables
        return made

    return switch


def test_every_recurrence_is_tested():
    """All but x**2.5, which is a general power before CasADi sees that its exponent is constant."""
    fields = [field_of(g)[0] for g in OPERATIONS.values()]
    assert set(recurrences._RULES) <= {f.instruction_id(k) for f in fields for k in range(f.n_instructions())}


@pytest.mark.one_in(20)
@pytest.mark.parametrize("name", OPERATIONS)
def test_coefficients(name, tables):
    field, _ = field_of(OPERATIONS[name] + 0.1 * ca.sin(OPERATIONS[name]) * OPERATIONS[name])
    plain = expand(field, ORDER)
    tables()
    table = expand(field, ORDER)
    state, count = np.array([*POINT[0], POINT[1]]), table.prelude.nnz_out(0)
    fixed = np.array(table.prelude(POINT[2], [POINT[3]])).ravel()
    for which, order in (("series", ORDER), ("probe", expansion.PROBED)):
        code = compile_functions([getattr(table, which)])
        right = np.array(getattr(plain, which)(state, plain.prelude(POINT[2], [POINT[3]]))).ravel()
        aux = np.concatenate([fixed, np.full(table.room, np.nan)])
        for _ in range(2):  # what the first call leaves changes nothing
            found = np.full(4 * (order + 1), np.nan)
            call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(code.addresses[which])
            call(state.ctypes.data, aux.ctypes.data, found.ctypes.data)
            assert found == pytest.approx(right, rel=1e-12, abs=1e-14)
        assert np.array_equal(aux[:count], fixed)


def test_coefficients_of_a_long_sum(tables):
    """Signs, terms that are constant multiples, lines in time, and the mode as a factor."""
    y, t, p, m = (ca.SX.sym(name, n) for name, n in (("y", 2), ("t", 1), ("p", 2), ("m", 1)))
    whole = p[0] * y[0] - ca.sin(y[1]) + m * ca.cos(y[0]) - p[1] * ca.exp(-t) + m * t - m * y[1] + y[0] * y[1]
    rate = ca.vertcat(y[1], -y[0] + 0.1 * whole)
    field = ca.Function("field", [y, t, p, m], [rate, ca.densify(whole), ca.SX(0, 1)])
    plain, state = expand(field, ORDER).series, np.array([*POINT[0], POINT[1]])
    right = np.array(plain(state, expand(field, ORDER).prelude(POINT[2], [POINT[3]]))).ravel()
    made = tables()
    table = expand(field, ORDER)
    fixed = np.array(table.prelude(POINT[2], [POINT[3]])).ravel()
    aux, found = np.concatenate([fixed, np.full(table.room, np.nan)]), np.full(right.size, np.nan)
    code = compile_functions([table.series])
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(code.addresses["series"])
    call(state.ctypes.data, aux.ctypes.data, found.ctypes.data)
    assert made
    assert found == pytest.approx(right, rel=1e-12, abs=1e-14)


@pytest.mark.one_in(9)
@pytest.mark.parametrize("name", SCENES)
def test_motions(name, tables):
    """States, counts of events and derivatives."""
    scene = SCENES[name]()

    def results():
        run = sf.simulate(scene, 1e-12, route="taylor")
        with_derivatives = sf.simulate(scene, 1e-12, route="taylor", sensitivities=[a, x])
        assert run.status == with_derivatives.status == sf.Status.OK
        return run, with_derivatives

    plain = results()
    made = tables()
    assert not made
    table = results()
    assert made
    for right, found in zip(plain, table, strict=True):
        assert found.final == pytest.approx(right.final, abs=1e-10)
        assert [found.stats[k] for k in ("events", "kinks")] == [right.stats[k] for k in ("events", "kinks")]
    assert table[0].stats["events"] > 0
    for key in ("a", "x"):
        right = plain[1].sensitivities[key]
        assert table[1].sensitivities[key] == pytest.approx(right, abs=1e-8 * (1 + abs(right).max()))


def test_second_derivatives(tables):
    scene = sf.Scene(
        sf.System(q=[x], u=[u], mass=[[1]], force=[-a * sp.sin(x)]),
        initial={x: 1.0, u: 0.0},
        horizon=3.0,
        values={a: 0.9},
    )
    plain, made = sf.prepare(scene, 1e-12, sensitivities=[a, x], order=2).run(), tables()
    table = sf.prepare(scene, 1e-12, sensitivities=[a, x], order=2).run()
    assert made
    for pair, right in plain.second_sensitivities.items():
        assert table.second_sensitivities[pair] == pytest.approx(right, abs=1e-9)


def test_four_threads_share_one_program(tables):
    """The room for coefficients belongs to a run, not to the program."""
    made = tables()
    program = sf.prepare(SCENES["sticking"](), 1e-9, route="taylor")
    assert made
    values = [{a: 0.7 + 0.05 * k} for k in range(4)]
    right = [program.run(v) for v in values]
    for _ in range(20):
        found = together(lambda k: [program.run(values[k]) for _ in range(10)])
        for k, runs in enumerate(found):
            assert not any(difference(run, right[k]) for run in runs)


def test_a_force_of_hundreds_of_terms_is_a_table(monkeypatch):
    """And a short one is not; the length says how many instructions are saved."""
    fields = {}
    for name, force in (("long", HUNDREDS), ("short", sp.sin(x))):
        automaton = lower(one_mass(force - x, sf.laws.coulomb(0.3)), [], frozenset())
        fields[name] = automaton.field
    assert expansion.is_long(fields["long"], 17)
    assert not expansion.is_long(fields["short"], 17)


def test_a_long_sum_is_taken_apart_into_terms_that_add_up_to_it():
    """Through signs, brackets and multiples; a part that is used elsewhere is computed once, and is one term."""
    y, t, p, m = ca.SX.sym("y", 2), ca.SX.sym("t"), ca.SX.sym("p", 3), ca.SX.sym("m")
    part = y[0] + ca.sin(y[0]) - ca.cos(t) + p[0] * y[1] - ca.exp(y[1])
    whole = p[1] * y[0] - (p[2] * ca.tan(y[1]) - ca.sin(t)) - ca.exp(-t) + y[0] * y[1] + part
    nodes, outputs = read(ca.Function("field", [y, t, p, m], [ca.vertcat(whole, ca.tanh(part))]))
    given, values = ([0.7, -0.4], [0.3], [1.3, 0.2, -2.0], [1.0]), []
    for node in nodes:
        known = given[node.place[0]][node.place[1]] if node.place else node.number
        of = [ca.SX(values[a]) for a in node.args]
        values.append(float({1: ca.SX.unary, 2: ca.SX.binary}[len(of)](node.op, *of)) if of else known)
    sums = long_sums(nodes, set(outputs[0]))
    assert sorted(len(terms) for terms in sums.values()) == [5, 6]
    assert len(sums[outputs[0][0]]) == 6
    for i, terms in sums.items():
        added = sum(e.sign * values[e.atom] * (1 if e.factor is None else values[e.factor]) for e in terms)
        assert added == pytest.approx(values[i], rel=1e-14)


def test_the_length_is_that_of_the_series_written_out():
    for force in (sp.sin(3 * x) + sp.sin(x), x**2 * u, sp.sin(3 * sf.TIME) * x):
        field = lower(one_mass(force - x, sf.laws.coulomb(0.3)), [], frozenset()).field
        right = expand(field, 17).series.n_instructions()
        assert 0.3 < length(read(field)[0], 17) / right < 2


@pytest.mark.long(beside="test_a_force_of_hundreds_of_terms_is_a_table")
def test_hundreds_of_harmonics_of_time_are_no_states():
    """The route `exact` would have two states for each."""
    force = sp.Add(*(sp.sin(k * sf.TIME / 7) / k for k in range(1, 301))) - x
    scene = one_mass(force, sf.laws.coulomb(0.3), horizon=1.0)
    explained = sf.explain(scene)
    assert explained.route == "taylor"
    assert "more than 40 functions of time" in str(explained)
    assert sf.simulate(scene).status == sf.Status.OK
