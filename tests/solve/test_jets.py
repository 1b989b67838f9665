"""Taylor recurrences against repeated symbolic differentiation, and machine code against CasADi's interpreter."""

import ctypes

import casadi as ca
import numpy as np
import pytest

from symfric.codegen import llvm_ir, target
from symfric.codegen.functions import compile_functions
from symfric.codegen.instructions import read
from symfric.errors import SceneError
from symfric.solve.loop.stepping.series import reach
from symfric.solve.taylor import expansion
from symfric.solve.taylor.expansion import expand

ORDER = 7
y, t, p, m = ca.SX.sym("y", 2), ca.SX.sym("t"), ca.SX.sym("p", 2), ca.SX.sym("m", 1)
x, u = y[0], y[1]
OPERATIONS = {
    "floor": ca.floor(7 * t + x) * u,
    "exp": ca.exp(x),
    "log": ca.log(x),
    "sin": ca.sin(x * u),
    "cos": ca.cos(x + t),
    "tan": ca.tan(0.3 * x),
    "asin": ca.asin(0.3 * x),
    "acos": ca.acos(0.2 * x),
    "atan": ca.atan(x * u),
    "sinh": ca.sinh(x),
    "cosh": ca.cosh(0.3 * x),
    "tanh": ca.tanh(x),
    "asinh": ca.asinh(x),
    "acosh": ca.acosh(1.5 + x),
    "atanh": ca.atanh(0.2 * x),
    "quotient": u / (1 + x * x),
    "reciprocal": 1 / x,
    "square root": ca.sqrt(x),
    "power": x ** p[0],
    "constant power": (x + 1) ** 2.5,
    "erf": ca.erf(x),
    "atan2": ca.atan2(x, u + 2),
    "log1p": ca.log1p(x),
    "expm1": ca.expm1(0.2 * x),
    "select": ca.if_else(m > 0, x * u, x),
    "quotient by a parameter": x / p[0],
    "squares": x * x * u * u,
    "twice": 2 * x,
    "time": ca.sin(3 * t) * x,
    "line in time": 2 * t - p[0],
    "products of lines in time": t * (2 * t - p[0]) * x + t / p[0],
}
POINT = ([0.7, 0.4], 0.3, [1.3, 0.2], 1)


def field_of(g):
    rate = ca.vertcat(u * p[0], -x + 0.1 * g)
    return ca.Function("field", [y, t, p, m], [rate, ca.densify(ca.vertcat(g, ca.SX(1))), ca.SX(0, 1)]), rate


def lie_series(g, rate):
    row, factorial = [], 1.0
    for k in range(ORDER + 1):
        row.append(float(ca.Function("g", [y, t, p, m], [g])(*POINT)) / factorial)
        g = ca.jtimes(g, y, rate) + ca.jacobian(g, t)
        factorial *= k + 1
    return np.array(row)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", OPERATIONS)
def test_recurrence_matches_differentiation(name):
    field, rate = field_of(OPERATIONS[name])
    series = expand(field, ORDER)
    aux = series.prelude(POINT[2], [POINT[3]])
    rows = np.array(series.series([*POINT[0], POINT[1]], aux)).reshape(-1, ORDER + 1)
    expected = lie_series(OPERATIONS[name], rate)
    assert rows[2] == pytest.approx(expected, rel=1e-11, abs=1e-13)
    assert rows[0, 1:] == pytest.approx(1.3 * rows[1, :-1] / np.arange(1, ORDER + 1), rel=1e-14, abs=1e-15)
    assert rows[3].tolist() == [1.0] + [0.0] * ORDER


@pytest.mark.one_in(4)
@pytest.mark.parametrize("most", [1, 2, 3])
def test_coefficients_taken_out_of_the_chain_change_nothing(most, monkeypatch):
    field = field_of(sum(OPERATIONS.values(), ca.SX(0)))[0]
    rows = []
    for taken_out in (0, most):
        monkeypatch.setattr(expansion, "_taken_out", lambda n_x, moving, most=taken_out: most)
        series = expand(field, ORDER)
        aux = series.prelude(POINT[2], [POINT[3]])
        rows.append(np.array(series.series([*POINT[0], POINT[1]], aux)).ravel())
    assert rows[1] == pytest.approx(rows[0], rel=1e-11, abs=1e-13)


@pytest.mark.parametrize("most", [1, 2])
def test_coefficients_taken_out_of_the_chain_shorten_it(most, monkeypatch):
    """The longest chain of operations, each of which waits for the one before, sets the time of a call."""
    lengths = []
    for taken_out in (0, most):
        monkeypatch.setattr(expansion, "_taken_out", lambda n_x, moving, most=taken_out: most)
        chain = []
        for node in read(expand(field_of(ca.sin(x * u) / (1 + ca.exp(x)))[0], 16).series)[0]:
            chain.append(1 + max((chain[a] for a in node.args), default=0))
        lengths.append(max(chain))
    assert lengths[1] < 0.9 * lengths[0]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("part", [None, 500, 37, 1])
def test_machine_code_matches_interpreter(part, tmp_path, monkeypatch):
    """Whole and cut into parts: the same."""
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path))
    if part:
        monkeypatch.setattr(llvm_ir, "WHOLE", 0)
        monkeypatch.setattr(llvm_ir, "PART", part)
    everything = sum(OPERATIONS.values(), ca.SX(0))
    series = expand(field_of(everything)[0], ORDER)
    for from_disk in (False, True):
        code = compile_functions([series.prelude, series.series])
        assert code.cached is from_disk
        aux = np.array(series.prelude(POINT[2], [POINT[3]])).ravel()
        state, out = np.array([*POINT[0], POINT[1]]), np.zeros(series.series.nnz_out(0))
        call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(code.addresses["series"])
        call(state.ctypes.data, aux.ctypes.data, out.ctypes.data)
        assert out == pytest.approx(np.array(series.series(state, aux)).ravel(), rel=1e-9, abs=1e-11)


def test_damaged_cache_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path))
    series = expand(field_of(x * u)[0], 3)
    compile_functions([series.series])
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes()[:-40] + b"x" * 40)
    assert compile_functions([series.series]).cached is False


def test_llvm_is_told_of_every_function_that_code_may_call():
    assert set(llvm_ir.CALLS.values()) <= set(target._MATHEMATICS)


def test_unknown_operation_is_refused_by_name():
    with pytest.raises(SceneError, match="OP_FABS"):
        expand(field_of(ca.fabs(x))[0], 3)


@pytest.mark.parametrize("order", [3, 4, 7, 8])
def test_what_a_step_reaches(order):
    rng = np.random.default_rng(order)
    c, h = rng.normal(size=(3, order + 1)), 0.7
    found = np.array(reach(2, 1, order)(h, c.ravel())).ravel()
    powers = h ** np.arange(1, order + 1)
    assert found[:2] == pytest.approx(c[:2, 1:] @ powers, abs=1e-14)
    assert found[2] == pytest.approx(np.abs(c[2, 1:]) @ powers, abs=1e-14)
