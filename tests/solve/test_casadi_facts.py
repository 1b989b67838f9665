"""What the routes rely on in CasADi, as found in 3.8; a failure means that a newer version behaves differently."""

import contextlib
import io
import math
import pickle

import casadi as ca
import numpy as np
import pytest

ONE_STEP = ("erk", "rosenbrock")
MULTISTEP = ("cvodes", "idas")
_X, _T, _P = ca.SX.sym("x", 2), ca.SX.sym("t"), ca.SX.sym("p")


def with_events(plugin, rate, zero, after, horizon=1.0, **options):
    """Integrate x with events; `after` maps the index of the event to the state after it."""
    index = ca.SX.sym("index")
    arguments = [index, _T, _X, ca.SX.sym("z", 0), _P, ca.SX.sym("u", 0)]
    transition = ca.Function("transition", arguments, [after(index), ca.SX(0, 1)], ca.event_in(), ca.event_out())
    dae = {"x": _X, "t": _T, "p": _P, "ode": rate, "zero": zero}
    options = {"abstol": 1e-10, "reltol": 1e-10, "transition": transition, **options}
    with contextlib.redirect_stderr(io.StringIO()):
        return ca.integrator("event", plugin, dae, 0, horizon, options)


def counting(plugin, speed, zero, horizon=1.0):
    """Return how many events a motion with the given speed meets, from x = `start`."""
    function = with_events(plugin, ca.vertcat(speed, 0), zero, lambda _: ca.vertcat(_X[0], _X[1] + 1), horizon)
    return lambda start: float(function(x0=[start, 0])["xf"][1])


@pytest.mark.parametrize("plugin", [*ONE_STEP, *MULTISTEP])
def test_only_falling_guards_fire(plugin):
    assert counting(plugin, -1, _X[0] - 0.5)(1.0) == 1
    assert counting(plugin, +1, _X[0] - 0.5)(0.0) == 0


@pytest.mark.parametrize("plugin", [*ONE_STEP, *MULTISTEP])
def test_a_guard_that_falls_from_zero_never_fires(plugin):
    assert counting(plugin, -1, _X[0])(0.0) == 0


def test_a_guard_that_first_rises_from_zero_fires_in_the_one_step_methods_only():
    rise_and_fall = 1 - 2 * _T
    for plugin in ONE_STEP:
        assert counting(plugin, rise_and_fall, _X[0], horizon=2.0)(0.0) == 1
    for plugin in MULTISTEP:
        assert counting(plugin, rise_and_fall, _X[0], horizon=2.0)(0.0) == 0


@pytest.mark.parametrize("plugin", ONE_STEP)
def test_of_two_guards_that_fall_at_once_one_is_handled_and_the_other_lost(plugin):
    both = ca.vertcat(_X[0] - 0.5, 2 * _X[0] - 1)
    function = with_events(plugin, ca.vertcat(-1, 0), both, lambda i: ca.vertcat(_X[0], _X[1] + 1 + 10 * i))
    assert float(function(x0=[1, 0])["xf"][1]) in (1.0, 11.0)


@pytest.mark.parametrize("plugin", ONE_STEP)
def test_a_guard_that_dips_and_returns_within_a_step_is_missed_without_a_bound_on_the_step(plugin):
    dip = (_X[0] - 0.5) ** 2 - 1e-6
    assert counting(plugin, -1, dip)(1.0) == 0
    bounded = with_events(
        plugin, ca.vertcat(-1, 0), dip, lambda _: ca.vertcat(_X[0], _X[1] + 1), max_step_size=1e-3, max_num_steps=10**5
    )
    assert float(bounded(x0=[1, 0])["xf"][1]) == 1


@pytest.mark.parametrize("plugin", ONE_STEP)
def test_integration_restarts_from_the_state_after_the_event(plugin):
    bounce = with_events(plugin, ca.vertcat(_X[1], -1), _X[0], lambda _: ca.vertcat(_X[0], -_X[1]), horizon=6.0)
    x, u = np.array(bounce(x0=[0.5, 0.0])["xf"]).ravel()  # falls for 1, then arcs of 2: at t = 6 it bounces at 1, 3, 5
    assert x == pytest.approx(0.5, abs=1e-8)
    assert u == pytest.approx(0.0, abs=1e-8)


def jumping(plugin):
    """x' = -p x; at x = 1/2 the state jumps by the time of the event."""
    after = lambda _: ca.vertcat(_X[0] + _T, 1)  # noqa: E731
    return with_events(plugin, ca.vertcat(-_P * _X[0], 0), _X[0] - 0.5, after)


def test_sensitivities_include_the_time_of_the_event_in_the_one_step_methods():
    # x(1) = (1/2 + ln 2 / p) e^(ln 2 - p): at p = 1 and its derivative there
    value, slope = 2 * (0.5 + math.log(2)) / math.e, -2 * (0.5 + 2 * math.log(2)) / math.e
    p = ca.MX.sym("p")
    for plugin in ONE_STEP:
        end = jumping(plugin)(x0=[1, 0], p=p)["xf"][0]
        outputs = [end, ca.jtimes(end, p, ca.MX(1)), ca.gradient(end, p), ca.hessian(end, p)[0]]
        found = [float(e) for e in ca.Function("all", [p], outputs)(1.0)]
        assert found[0] == pytest.approx(value, abs=1e-8)
        assert found[1] == pytest.approx(slope, abs=1e-8)
        assert found[2] == pytest.approx(slope, abs=1e-8)
        assert math.isfinite(found[3])


@pytest.mark.parametrize("plugin", MULTISTEP)
def test_the_multistep_methods_jump_at_the_wrong_time_in_silence_and_refuse_second_derivatives(plugin):
    function = jumping(plugin)
    value = 2 * (0.5 + math.log(2)) / math.e
    assert abs(float(function(x0=[1, 0], p=1)["xf"][0]) - value) > 1e-5
    p = ca.MX.sym("p")
    with pytest.raises(RuntimeError, match="Event support not implemented"):
        ca.hessian(function(x0=[1, 0], p=p)["xf"][0], p)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("plugin", MULTISTEP)
def test_reverse_gradients_need_quad_err_con(plugin):
    y, p, t = ca.SX.sym("y"), ca.MX.sym("p"), ca.SX.sym("t")
    dae = {"x": y, "p": _P, "t": t, "ode": _P * ca.sin(30 * t) ** 2}
    errors = {}
    for controlled in (True, False):
        options = {"abstol": 1e-10, "reltol": 1e-10, "quad_err_con": controlled}
        end = ca.integrator("slow", plugin, dae, 0, 1.0, options)(x0=0, p=p)["xf"]
        gradient = float(ca.Function("gradient", [p], [ca.jtimes(end, p, ca.MX(1), True)])(1.0))
        errors[controlled] = abs(gradient - (0.5 - math.sin(60) / 120))
    assert errors[True] < 1e-3 * errors[False]
    assert errors[False] > 1e-4


def generated(plugin, capsys):
    function = ca.integrator("plain", plugin, {"x": _X, "ode": -_X}, 0, 1.0)
    code = ca.CodeGenerator("plain.c")
    capsys.readouterr()
    code.add(function)
    code.dump()
    streams = capsys.readouterr()
    return "cannot be code generated" not in streams.err + streams.out


def test_c_code_exists_for_the_one_step_methods_and_not_for_the_multistep_ones(capsys):
    assert [generated(plugin, capsys) for plugin in ONE_STEP] == [True, True]
    assert [generated(plugin, capsys) for plugin in MULTISTEP] == [False, False]


def test_functions_pickle_and_bare_expressions_do_not():
    function = ca.integrator("plain", "cvodes", {"x": _X, "ode": -_X}, 0, 1.0)
    again = pickle.loads(pickle.dumps(function))
    assert float(again(x0=[1, 1])["xf"][0]) == float(function(x0=[1, 1])["xf"][0])
    with pytest.raises(Exception, match="Cannot pickle MX"):
        pickle.dumps(ca.MX.sym("a"))
