"""Series that an earlier process has written are read from the disk cache, with the same bits."""

import casadi as ca
import pytest
import sympy as sp

import symfric as sf
from symfric.codegen.kept_functions import kept
from symfric.codegen.llvm_ir import Written
from symfric.solve.lowered import LoweredScene
from symfric.solve.taylor import expansion, kept_series

x, v = sp.symbols("x v", real=True)
FUNCTIONS = "prelude", "series", "probe", "unseen", "terms"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path / "cache"))
    kept_series._kept.cache_clear()
    return tmp_path / "cache"


def pendulums(n):
    q, u = sp.symbols(f"q:{n}", real=True), sp.symbols(f"u:{n}", real=True)
    force = [-sp.sin(a) - sp.exp(-(b**2)) + sp.tanh(q[0]) for a, b in zip(q, u, strict=True)]
    return sf.Scene(sf.System(q=q, u=u, mass=sp.eye(n), force=force), initial=dict.fromkeys((*q, *u), 0.1), horizon=1.0)


def field_of(scene):
    return LoweredScene(scene).automaton.field


def texts(series):
    found = [getattr(series, name) for name in FUNCTIONS]
    return [f and (f.name(), f.serialize()) for f in found], series.order, series.exposed, series.room


def forbidden(*_):
    raise AssertionError("written again")


@pytest.fixture
def another_process(monkeypatch):
    """Forget what is in memory, and refuse to write a series."""

    def begin():
        kept_series._kept.cache_clear()
        monkeypatch.setattr(expansion, "expand", forbidden)

    yield begin
    kept_series._kept.cache_clear()


@pytest.mark.parametrize("scene", [sf.scenes.mass_on_belt(v_b=0.2), pendulums(1)], ids=["belt", "exposed"])
def test_a_second_process_reads_what_the_first_has_written(scene, another_process):
    field = field_of(scene)
    first = kept_series.kept_series(field, 12, "_slip")
    another_process()
    second = kept_series.kept_series(field, 12, "_slip")
    assert texts(second) == texts(first)
    assert isinstance(second.exposed, tuple)
    for other in ((field, 13, "_slip"), (field, 12, "_stick"), (field_of(pendulums(2)), 12, "_slip")):
        with pytest.raises(AssertionError, match="written again"):
            kept_series.kept_series(*other)


def test_the_same_process_keeps_those_of_its_last_scenes():
    field = field_of(pendulums(1))
    assert kept_series.kept_series(field, 6) is kept_series.kept_series(field_of(pendulums(1)), 6)
    assert kept_series.kept_series(field, 6) is not kept_series.kept_series(field, 7)


def test_tables_are_made_anew(monkeypatch, another_process):
    """They call rules that all scenes share, and are made in little time."""
    monkeypatch.setattr(expansion, "LONG", 50)  # instructions from which a series is a table
    field = field_of(pendulums(2))
    first = kept_series.kept_series(field, 8)
    assert isinstance(first.series, Written)
    assert first.room > 0
    kept_series._kept.cache_clear()
    assert texts(kept_series.kept_series(field, 8)) == texts(first)
    another_process()
    with pytest.raises(AssertionError, match="written again"):
        kept_series.kept_series(field, 8)


def test_other_sources_write_anew(monkeypatch, another_process):
    field = field_of(pendulums(1))
    kept_series.kept_series(field, 6)
    monkeypatch.setattr(kept_series, "_written_by", lambda: "other sources")
    another_process()
    with pytest.raises(AssertionError, match="written again"):
        kept_series.kept_series(field, 6)


def test_a_damaged_file_is_written_anew(folder):
    field = field_of(pendulums(1))
    first = kept_series.kept_series(field, 6)
    (file,) = folder.glob("*.o")
    file.write_bytes(file.read_bytes()[:-40])
    kept_series._kept.cache_clear()
    assert texts(kept_series.kept_series(field, 6)) == texts(first)


def test_without_a_folder_everything_is_written(monkeypatch):
    monkeypatch.setenv("SYMFRIC_CACHE_SIZE", "0")
    field = field_of(pendulums(1))
    assert texts(kept_series.kept_series(field, 6)) == texts(kept_series.kept_series(field, 6))


def test_what_is_kept():
    a = ca.SX.sym("a")
    made = {"f": ca.Function("f", [a], [a**2]), "n": 3, "rows": [1, 2], "no": None}
    first, second = (kept("key", lambda: made) for _ in range(2))
    assert first is made
    assert {k: v for k, v in second.items() if k != "f"} == {k: v for k, v in made.items() if k != "f"}
    assert second["f"](3.0) == 9.0


def test_what_calls_others_is_not_kept():
    made = {"text": Written("g", "define", ("h",)), "n": 3}
    assert kept("key", lambda: made) is made
    assert kept("key", lambda: {"n": 4}) == {"n": 4}
