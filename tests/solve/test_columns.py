"""Series of derivatives in vectors: the bits of the code for one column, and the series of the whole equations."""

import ctypes

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.codegen.columns import WithColumns
from symfric.codegen.functions import compile_functions
from symfric.codegen.instructions import read
from symfric.codegen.llvm_ir import Written
from symfric.lower.automaton import lower
from symfric.lower.variational_equations import varied
from symfric.solve.taylor import expansion
from symfric.solve.taylor.affine_forms import gathered
from symfric.solve.taylor.expansion import expand
from symfric.solve.taylor.table import length

_X, _U, _Y, _W = sp.symbols("x u y w", real=True)


def _two_masses():
    law = sf.laws.stribeck(sp.Symbol("mu_s", positive=True), 0.25, 0.3)
    k, v = sp.symbols("k v_b", positive=True)
    return sf.Scene(
        system=sf.System(
            q=[_X, _Y], u=[_U, _W], mass=[[1, 0], [0, 2]], force=[-k * _X + (_Y - _X) ** 3, -sp.sin(_Y) * _W]
        ),
        contacts=[sf.Contact("belt", slip=_U - v, normal=1 + _X**2 / 9, law=law)],
        values={k: 1.0, v: 0.2, "mu_s": 0.4},
        initial={_X: 0.1, _U: 0.0, _Y: 0.3, _W: 0.0},
        horizon=1.0,
    )


_SCENES = {
    "belt": lambda: sf.scenes.mass_on_belt(v_b=0.2, a=0.1, Omega=3.0),
    "bristles": lambda: sf.scenes.mass_on_belt(sf.laws.lugre(0.4, 0.25, 0.1, 1e3, 10.0), v_b=0.2),
    "two masses": _two_masses,
}


def _called(code, function, sizes, inputs):
    """Return the outputs of compiled code."""
    outs = [np.full(size, np.nan) for size in sizes]
    arrays = [np.array(e, dtype=float) for e in inputs] + outs
    call = ctypes.CFUNCTYPE(None, *(len(arrays) * [ctypes.c_void_p]))(code.addresses[function.name()])
    call(*(a.ctypes.data for a in arrays))
    return [out.tolist() for out in outs]


def _scalar(function, inputs):
    """Return the outputs of a function that is compiled for numbers."""
    sizes = [function.nnz_out(k) for k in range(function.n_out())]
    return _called(compile_functions([function]), function, sizes, inputs)


@pytest.mark.one_in(15)
@pytest.mark.parametrize("scene", _SCENES)
@pytest.mark.parametrize("columns", [1, 2, 3, 5, 9])
@pytest.mark.parametrize("first", ["values", "states"])
def test_vectors_have_the_bits_of_one_column_after_the_other(scene, columns, first):
    scene = _SCENES[scene]()
    values, states = [s.name for s in scene.values], [s.name for s in scene.system.states]
    names = [*values, *states] if first == "values" else [*states, *values]
    rows = [scene.system.q[0] * scene.system.u[0], sp.sin(scene.system.u[0]) + 3 * scene.system.q[0]]
    automaton = lower(scene, rows)
    variations = varied(automaton, scene, [names[k % len(names)] for k in range(columns)], 2)
    wide, n_x = variations.automaton, len(scene.system.states)
    series, plain = expand(wide.field, 12, "", wide.varied), expand(wide.field, 12)
    rng = np.random.default_rng(columns)
    p, m = rng.uniform(0.5, 1.0, wide.field.nnz_in(2)), np.ones(wide.field.nnz_in(3))
    y = rng.uniform(0.1, 0.6, n_x * (1 + columns) + 1).tolist()
    aux = np.array(series.prelude(p, m), dtype=float).ravel().tolist()
    for whole, f in ((plain.series, series.series), (plain.probe, series.probe)):
        packed = f.drafted()
        (found,) = _called(compile_functions([packed]), packed, [whole.nnz_out(0)], [y, aux])
        assert found == f.of(_scalar, y, aux)
        reference = np.array(whole(y, plain.prelude(p, m)), dtype=float).reshape(wide_rows(wide.field), -1)
        size = np.max(np.abs(reference), axis=1, keepdims=True)
        assert np.max(np.abs(np.reshape(found, reference.shape) - reference) / (size + 1e-300)) < 1e-11


def wide_rows(field):
    """Return the number of rates, guards and observables."""
    return sum(field.nnz_out(k) for k in range(3))


def test_slopes_are_written_out_where_the_equations_of_all_columns_would_be_a_table(monkeypatch):
    scene = _SCENES["bristles"]()
    automaton = lower(scene)
    variations = varied(automaton, scene, [s.name for s in scene.values][:5], 0)
    wide = variations.automaton
    monkeypatch.setattr(expansion, "LONG", length(read(gathered(wide.field))[0], 12) - 1)
    assert expansion.is_long(wide.field, 12)
    assert not expansion.is_long(wide.field, 12, wide.varied)
    assert isinstance(expand(wide.field, 12, "", wide.varied).series, WithColumns)
    monkeypatch.setattr(expansion, "LONG", 100)
    assert expansion.is_long(wide.field, 12, wide.varied)
    assert isinstance(expand(wide.field, 12, "", wide.varied).series, Written)
