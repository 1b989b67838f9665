"""Code that is compiled fast at first: the same bits as code compiled for speed, which takes its place where it pays."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.codegen import functions
from symfric.solve.loop import compiled_model
from symfric.solve.taylor import expansion, table
from tests.longer import longer

x, y, u, v = sp.symbols("x y u v", real=True)
c = sp.Symbol("c", positive=True)


def two_masses():
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    contacts = [sf.Contact(n, w - sp.Rational(1, 5), load, law) for n, w, load in (("a", u, 1.0), ("b", v, 1.5))]
    force = [y - 2 * sp.sin(x) - c * u * sp.exp(-(x**2)), x - 2 * y / sp.sqrt(1 + y**2) - c * v]
    system = sf.System(q=[x, y], u=[u, v], mass=sp.eye(2), force=force)
    return sf.Scene(system, contacts, values={c: 0.05}, initial={x: 0, y: 0, u: 0.1, v: 0}, horizon=40)


def in_the_plane():
    block = sf.Contact("table", slip=[u, v], normal=1.0, law=sf.laws.coulomb(0.3))
    system = sf.System(q=[x, y], u=[u, v], mass=sp.eye(2), force=[-x - c * u, -2 * y + x / 5])
    return sf.Scene(system, [block], values={c: 0.05}, initial={x: 2, y: 1, u: 0, v: 1}, horizon=20)


def striking():
    floor = sf.Contact("floor", slip=v, normal=sf.Unilateral(x, 0.7), law=sf.laws.coulomb(0.2))
    system = sf.System(q=[x, y], u=[u, v], mass=sp.eye(2), force=[-1 - c * u, -y])
    return sf.Scene(system, [floor], values={c: 0.05}, initial={x: 1, y: 0, u: 0, v: 1}, horizon=3)


SCENES = {scene.__name__: scene for scene in (two_masses, in_the_plane, striking)}


@pytest.fixture(autouse=True)
def drafting(monkeypatch, tmp_path):
    """Nothing is in the cache, and all code is compiled fast at first."""
    monkeypatch.setattr(functions, "_MANY", 0)
    load = functions.load
    monkeypatch.setattr(functions, "load", lambda key: None)
    yield load
    monkeypatch.undo()


def bits(run):
    return run.status, run.final.tobytes(), [(e.t, e.contact, e.kind) for e in run.events], run.stats["steps"]


@pytest.mark.parametrize("name", longer(SCENES, ["two_masses", "in_the_plane"]))
def test_both_codes_end_at_the_same_bits(name):
    program = sf.prepare(SCENES[name](), 1e-10, route="taylor")
    first, model = program.run(), program._model
    assert first.status == sf.Status.OK
    before = model.first.code.copy()
    model.worked(10**9)
    assert model.draft is None
    assert np.all((model.first.code != before) == (before != 0))
    assert bits(program.run()) == bits(first)


def test_so_do_derivatives():
    program = sf.prepare(striking(), 1e-10, route="taylor", sensitivities=[c])
    first = program.run()
    program._model.worked(10**9)
    second = program.run()
    for name, row in first.sensitivities.items():
        assert row.tobytes() == second.sensitivities[name].tobytes()


def test_it_is_exchanged_after_many_steps_of_runs(monkeypatch):
    program = sf.prepare(striking(), 1e-10, route="taylor")
    steps = program.run().stats["steps"]
    monkeypatch.setattr(compiled_model, "_ENOUGH", 3 * steps)
    assert program._model.draft
    runs = [program.run() for _ in range(3)]
    assert program._model.draft is None
    assert len({bits(run)[1] for run in [*runs, program.run()]}) == 1


@pytest.mark.one_in(2)
@pytest.mark.parametrize("threads", [1, 2])
def test_and_in_the_middle_of_a_map(monkeypatch, threads):
    program = sf.prepare(striking().wanting({"far": sf.Max(x)}), 1e-10, route="taylor")
    values = np.linspace(0.01, 0.1, 200)
    monkeypatch.setattr(compiled_model, "_ENOUGH", 100 * program.run().stats["steps"])
    found = program.map({c: values}, threads=threads)
    assert program._model.draft is None
    for k in (0, 60, 110, 199):
        assert program.run({c: values[k]}).final.tobytes() == np.ascontiguousarray(found.final[:, k]).tobytes()


def test_a_later_scene_takes_the_faster_code(monkeypatch, drafting, tmp_path):
    monkeypatch.setattr(functions, "load", drafting)
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path / "cache"))
    first = sf.prepare(striking(), 1e-10, route="taylor")
    assert sf.prepare(striking(), 1e-10, route="taylor")._model.draft
    first._model.worked(10**9)
    assert sf.prepare(striking(), 1e-10, route="taylor")._model.draft is None


def test_few_instructions_are_compiled_for_speed(monkeypatch):
    monkeypatch.setattr(functions, "_MANY", 3000)
    assert sf.prepare(striking(), 1e-10, route="taylor")._model.draft is None


@pytest.fixture
def own_rules(monkeypatch):
    """Rules under names of this test, since others may have compiled the same before; what is compiled stays."""
    monkeypatch.setattr(table, "_written_by", lambda: "this test")
    for made in (table._rules_of, table._copying):
        made.cache_clear()
    yield
    for made in (table._rules_of, table._copying):
        made.cache_clear()


@pytest.mark.long(beside="test_rules_that_are_compiled_fast_end_at_the_same_bits")
@pytest.mark.usefixtures("own_rules")
def test_the_rules_of_a_table_are_compiled_once(monkeypatch):
    """Whatever the scene and, within a few orders, the tolerance."""
    monkeypatch.setattr(expansion, "LONG", 0)
    before = len(functions._provided)
    made, compiled = [], functions._compiled

    def count(key, given, opt):
        made.append(len(given))
        return compiled(key, given, opt)

    monkeypatch.setattr(functions, "_compiled", count)
    sf.simulate(two_masses(), 1e-9, route="taylor")
    kinds = len(functions._provided) - before
    assert kinds > 5
    assert len(made) == kinds + 1
    sf.simulate(in_the_plane().until(1.0), 1e-9, route="taylor")
    assert len(made) < 2 * kinds
    kinds = len(made)
    sf.simulate(two_masses(), 3e-10, route="taylor")
    assert len(made) == kinds + 1


ENGINES = []  # of rules: code that is linked to them must find them as long as the process lives


@pytest.mark.one_in(3)
@pytest.mark.usefixtures("own_rules")
@pytest.mark.parametrize("name", SCENES)
def test_rules_that_are_compiled_fast_end_at_the_same_bits(name, monkeypatch):
    monkeypatch.setattr(expansion, "LONG", 0)
    found = []
    for level in (2, 0):
        ENGINES.append({})
        monkeypatch.setattr(functions, "_SHARED", level)
        monkeypatch.setattr(functions, "_provided", ENGINES[-1])
        found.append(bits(sf.simulate(SCENES[name](), 1e-10, route="taylor")))
    assert len(ENGINES[-1]) == len(ENGINES[-2]) > 5
    assert found[0] == found[1]
