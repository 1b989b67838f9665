"""Features that begin later in a step than its coefficients can tell: pulses in time, position, speed, load and slip."""

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp
from scipy.special import erf

import symfric as sf
from symfric.codegen.instructions import read
from symfric.solve.loop.stepping.enclosure import unseen
from tests.longer import longer

Q, U = sp.symbols("q u", real=True)
T, V = sf.TIME, sf.SPEED
SHAPES = {
    "Gauss": lambda a: sp.exp(-(a**2)),
    "sech": lambda a: 1 / sp.cosh(a),
    "quartic": lambda a: 1 / (1 + a**4),
    "two tanh": lambda a: (sp.tanh(a + 1) - sp.tanh(a - 1)) / 2,
    "two erf": lambda a: (sp.erf(a + 1) - sp.erf(a - 1)) / 2,
    "bounded exponential": lambda a: sp.exp(1 - sp.sqrt(1 + a**2)),
    "nested exponential": lambda a: sp.exp(-a - sp.exp(-a)),
    "high power": lambda a: 1 / (1 + a**2) ** 3,
}
# narrower than 0.005 the nested exponential overflows at the start
WIDTHS = longer([0.3, 0.15, 0.08, 0.03, 0.01, 0.005], [0.3, 0.15, 0.08, 0.03, 0.005])


def numeric(expr, *symbols):
    return sp.lambdify(symbols, expr, [{"erf": erf}, "numpy"])


def reference(rate, start, width, horizon=6.0, narrow=((0.0, 6.0),)):
    """Integrate with steps far shorter than the feature where it can matter."""
    y, t = np.array(start), 0.0
    with np.errstate(over="ignore"):
        for low, high in narrow:
            for end, step in ((max(low, 0.0), 0.2), (min(high, horizon), width / 3)):
                if end > t:
                    y = solve_ivp(rate, (t, end), y, rtol=1e-11, atol=1e-12, method="DOP853", max_step=step).y[:, -1]
                    t = end
        if t < horizon:
            y = solve_ivp(rate, (t, horizon), y, rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
    return y


def agrees(scene, truth, tolerances=(1e-6, 1e-8, 1e-9, 1e-10)):
    for tolerance in tolerances:
        run = sf.simulate(scene.wanting({"end": sf.End()}), tolerance)
        assert run.status == sf.Status.OK
        assert np.max(np.abs(run.final - truth)) < 100 * tolerance + 1e-9


@pytest.mark.one_in(8)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("shape", SHAPES)
def test_a_force_that_is_a_pulse_in_time(shape, width):
    pulse = SHAPES[shape]((T - 3) / width) / width
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q - U / 10 + pulse]), [], {}, {Q: 0.5, U: 0.3}, 6.0)
    f = numeric(pulse, T)
    span = ((3 - 60 * width, 3 + 60 * width),)
    agrees(scene, reference(lambda t, y: [y[1], -y[0] - 0.1 * y[1] + f(t)], [0.5, 0.3], width, narrow=span))


@pytest.mark.one_in(8)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("shape", SHAPES)
def test_a_force_that_is_a_pulse_in_position(shape, width):
    pulse = SHAPES[shape]((Q - sp.Rational(31, 100)) / width) / 5
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q - U / 10 + pulse]), [], {}, {Q: 0.5, U: 0.3}, 6.0)
    f = numeric(pulse, Q)
    agrees(scene, reference(lambda t, y: [y[1], -y[0] - 0.1 * y[1] + f(y[0])], [0.5, 0.3], width))


@pytest.mark.one_in(8)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("shape", SHAPES)
def test_a_law_with_a_narrow_feature(shape, width):
    law = sf.laws.custom(sp.Rational(3, 10) + SHAPES[shape]((V - sp.Rational(7, 10)) / width) / 20, 0.6)
    contact = sf.Contact("belt", slip=U - sp.Rational(12, 10), normal=1, law=law)
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q]), [contact], {}, {Q: 0.9, U: 0.0}, 6.0)
    f = numeric(law.kinetic, V)
    agrees(scene, reference(lambda t, y: [y[1], -y[0] + f(1.2 - y[1])], [0.9, 0.0], width))


@pytest.mark.long(beside="test_a_law_with_a_narrow_feature")
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(
    "argument",
    [sp.log((V + 1) / 1.7), sp.sin(V - 0.7), sp.sqrt(V + 0.04) - 0.86, 1 / (1 + V) - 0.588, sp.atan(V) - 0.61],
    ids=str,
)
def test_a_narrow_feature_inside_another_function(argument, width):
    law = sf.laws.custom(0.3 + 0.05 * sp.exp(-((argument / width) ** 2)), 0.6)
    contact = sf.Contact("belt", slip=U - sp.Rational(12, 10), normal=1, law=law)
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q]), [contact], {}, {Q: 0.9, U: 0.0}, 6.0)
    f = numeric(law.kinetic, V)
    agrees(scene, reference(lambda t, y: [y[1], -y[0] + f(1.2 - y[1])], [0.9, 0.0], width))


@pytest.mark.long(beside="test_a_force_that_is_a_pulse_in_time")
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("shape", SHAPES)
def test_a_load_that_is_a_pulse_while_a_contact_slips(shape, width):
    load = 1 + SHAPES[shape]((T - 3) / width) / (10 * width)
    contact = sf.Contact("belt", slip=U + 5, normal=load, law=sf.laws.coulomb(0.3))
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q / 5]), [contact], {}, {Q: 0.5, U: 0.3}, 6.0)
    f = numeric(load, T)
    span = ((3 - 60 * width, 3 + 60 * width),)
    agrees(scene, reference(lambda t, y: [y[1], -y[0] / 5 - 0.3 * f(t)], [0.5, 0.3], width, narrow=span))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("width", [0.2, 0.02, 0.002])
def test_a_load_that_vanishes_for_a_moment_lets_a_contact_go(width):
    """It sticks under a pull of half its bound; the drop of its load releases it where the load is half."""
    load = 1 - sp.exp(-(((T - 3) / width) ** 2))
    contact = sf.Contact("floor", slip=U, normal=load, law=sf.laws.coulomb(0.4))
    scene = sf.Scene(sf.System([Q], [U], [[1]], [sp.Rational(1, 5) + 0 * Q]), [contact], {}, {Q: 0.0, U: 0.0}, 6.0)
    release = 3 - width * np.sqrt(np.log(2))
    for tolerance in (1e-6, 1e-9):
        run = sf.simulate(scene, tolerance)
        assert run.status == sf.Status.OK
        assert run.events[0].t == pytest.approx(release, abs=1e-3 * width * tolerance**0.5 + 1e-9)
        assert (run.events[0].before, run.events[0].after) == (0, 1)
        # at the end it slips on, or has come to rest: u' = .2 - .4 N, u = 0 again where both impulses are equal
        stop = run.events[1].t
        impulse = (
            0.2 * (stop - release)
            - 0.4 * quad(lambda t: 1 - np.exp(-(((t - 3) / width) ** 2)), release, stop, points=[3.0], epsabs=1e-13)[0]
        )
        assert abs(impulse) < 10 * width * tolerance + 1e-12


@pytest.mark.one_in(2)
@pytest.mark.parametrize("width", [0.1, 0.004])
def test_a_belt_that_jerks_takes_the_body_along_or_slips(width):
    """A pulse of the belt's speed that static friction cannot follow; the body keeps the impulse of the friction."""
    jerk = sp.exp(-(((T - 3) / width) ** 2))
    contact = sf.Contact("belt", slip=U - jerk, normal=1, law=sf.laws.coulomb(0.4))
    scene = sf.Scene(sf.System([Q], [U], [[1]], [0 * Q]), [contact], {}, {Q: 0.0, U: 0.0}, 6.0)
    runs = [sf.simulate(scene, tolerance) for tolerance in (1e-6, 1e-8, 1e-10)]
    assert all(run.status == sf.Status.OK and len(run.events) >= 2 for run in runs)
    assert np.max(np.abs(runs[0].final - runs[2].final)) < 1e-5
    assert np.max(np.abs(runs[1].final - runs[2].final)) < 1e-7
    assert runs[2].final[0] > 0.0


@pytest.mark.one_in(4)
@pytest.mark.parametrize("shape", SHAPES)
def test_outputs_of_a_pulse(shape):
    """What is wanted may hold the feature although the motion does not."""
    pulse = SHAPES[shape]((T - sp.Rational(31, 10)) / sp.Rational(1, 50))
    outputs = {"area": sf.Integral(pulse), "top": sf.Max(pulse)}
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q]), [], {}, {Q: 0.5, U: 0.3}, 6.0, outputs)
    f = numeric(pulse, T)
    with np.errstate(over="ignore"):
        grid = np.linspace(2.9, 3.3, 400_001)
        area = quad(f, 0, 6, points=[3.05, 3.1, 3.15], epsabs=1e-13, limit=500)[0]
    for tolerance in (1e-6, 1e-9):
        run = sf.simulate(scene, tolerance)
        assert run["area"] == pytest.approx(area, abs=20 * tolerance)
        assert run["top"] == pytest.approx(f(grid).max(), abs=1e-8 + 20 * tolerance)


@pytest.mark.long(beside="test_a_force_that_is_a_pulse_in_time")
def test_a_comb_of_pulses_inside_a_sine():
    pulses = sp.exp(-((sp.sin(5 * T) / sp.Rational(1, 100)) ** 2))
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q + 10 * pulses]), [], {}, {Q: 0.5, U: 0.3}, 6.0)
    f = numeric(pulses, T)
    agrees(scene, reference(lambda t, y: [y[1], -y[0] + 10 * f(t)], [0.5, 0.3], 0.002), (1e-6, 1e-9))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("power", [9, 40, 1000])
def test_powers_that_begin_with_coefficients_of_zero(power):
    """sin(t)^1000 has no derivative of less than order 1000 at its zeros."""
    scene = sf.Scene(sf.System([Q], [U], [[1]], [-Q + sp.sin(T) ** power]), [], {}, {Q: 0.0, U: 0.0}, 6.0)
    f = numeric(sp.sin(T) ** power, T)
    agrees(scene, reference(lambda t, y: [y[1], -y[0] + f(t)], [0.0, 0.0], 0.1), (1e-6, 1e-9))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("amplitude", [0.0, 1.0])
@pytest.mark.parametrize("power", [9, 14, 20, 1000])
def test_derivatives_by_the_amplitude_of_such_powers(power, amplitude):
    """Rows of derivatives are not looked at for powers of their own: the motion has the same, whatever its amplitude."""
    force = sp.Symbol("a", real=True)
    system = sf.System([Q], [U], [[1]], [-Q - U / 2 + force * sp.sin(T) ** power])
    run = sf.simulate(sf.Scene(system, [], {force: amplitude}, {Q: 0.0, U: 0.0}, 6.0), 1e-10, sensitivities=[force])
    f = numeric(sp.sin(T) ** power, T)
    by = reference(lambda t, y: [y[1], -y[0] - y[1] / 2 + f(t)], [0.0, 0.0], 0.02)
    assert np.ravel(run.sensitivities[force.name]) == pytest.approx(by, abs=1e-9)


@pytest.mark.parametrize("width", [0.1, 0.01, 0.001])
def test_a_blow_to_a_body_at_rest(width):
    blow = sp.exp(-(((T - 3) / width) ** 2)) / width
    scene = sf.Scene(sf.System([Q], [U], [[1]], [blow]), [], {}, {Q: 0.0, U: 0.0}, 6.0)
    run = sf.simulate(scene, 1e-9)
    assert run.final == pytest.approx([3 * np.sqrt(np.pi), np.sqrt(np.pi)], rel=1e-8)
    assert run.stats["steps"] < 600


@pytest.mark.one_in(2)
@pytest.mark.parametrize("width", [0.1, 0.001, 1e-5])
def test_a_logistic_switch_whose_exponential_overflows(width):
    force = 1 / (1 + sp.exp(-(T - 3) / width))
    scene = sf.Scene(sf.System([Q], [U], [[1]], [force]), [], {}, {Q: 0.0, U: 0.0}, 6.0)
    assert sf.simulate(scene, 1e-10).checked().final[1] == pytest.approx(3.0, abs=1e-8)


def test_bristles_at_saturation_take_normal_steps():
    """The terms of a rate that cancel leave rounding, which no step can make small."""
    x, u, z = sp.symbols("x u z", real=True)
    v = sp.Rational(9, 140) - u
    rate = v - 1e5 * sp.Abs(v) / 2 * z
    system = sf.System([x], [u], [[1]], [-100 * x + 1e5 * z + 300 * rate], [z], [rate])
    counts = []
    for below in (0.0, 1e-16, 5e-16, 1e-12, 1e-9):
        scene = sf.Scene(system, [], {}, {x: 0.0097, u: -0.12, z: 2e-5 - below}, 1.0, {"end": sf.End()})
        run = sf.simulate(scene, 1e-9).checked()
        counts.append(run.stats["steps"])
    assert max(counts) < 2 * min(counts) + 50


def test_steps_that_stand_still_end_the_run_with_a_status():
    """A relaxation 1e16 times as fast as the run."""
    system = sf.System([Q], [U], [[1]], [-1e16 * U + sp.exp(-Q)])
    run = sf.simulate(sf.Scene(system, [], {}, {Q: 0.0, U: 1.0}, 1.0, {"end": sf.End()}), 1e-9)
    assert run.status == sf.Status.STEP_COLLAPSE
    assert run.advice


FUNCTIONS = {
    "exp": (ca.exp, -3, 3), "log": (ca.log, 0.1, 4), "sqrt": (ca.sqrt, 0.01, 4), "sin": (ca.sin, -9, 9),
    "cos": (ca.cos, -9, 9), "tan": (ca.tan, -1.4, 1.4), "asin": (ca.asin, -0.99, 0.99),
    "acos": (ca.acos, -0.99, 0.99), "atan": (ca.atan, -30, 30), "sinh": (ca.sinh, -4, 4), "cosh": (ca.cosh, -4, 4),
    "tanh": (ca.tanh, -6, 6), "asinh": (ca.asinh, -30, 30), "acosh": (ca.acosh, 1.01, 9),
    "atanh": (ca.atanh, -0.99, 0.99), "erf": (ca.erf, -4, 4), "inverse": (lambda a: 1 / a, 0.1, 5),
    "power": (lambda a: a**1.7, 0.01, 5), "negative power": (lambda a: a**-0.4, 0.1, 5), "square": (lambda a: a * a, -3, 3),
    "log1p": (ca.log1p, -0.999, 3), "expm1": (ca.expm1, -3, 3), "angle": (lambda a: ca.atan2(a, 1 + a * a), -5, 5),
}  # fmt: skip


@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_is_unseen_is_no_less_than_what_a_tame_function_leaves(name):
    """A function that is not tame over an interval may hide all of its range there; a tame one hides nothing."""
    function, least, most = FUNCTIONS[name]
    y, t, p, m = ca.SX.sym("y"), ca.SX.sym("t"), ca.SX(0, 1), ca.SX(0, 1)
    field = ca.Function("field", [y, t, p, m], [function(y), ca.SX(0, 1), ca.SX(0, 1)])
    nodes, outputs = read(field)
    box, out, terms = unseen(nodes, [outputs[0][0]], 1, 18, lambda i: ca.SX(nodes[i].number))
    bound = ca.Function("bound", [box], [ca.vertcat(out, terms)])
    values = ca.Function("f", [y], [function(y)])
    rng = np.random.default_rng(7)
    hides, tame = 0, 0
    for _ in range(300):
        low, high = np.sort(rng.uniform(least, most, 2))
        if rng.random() < 0.5:
            high = low + 1e-3 * (high - low)
        found, size = np.array(bound([0.5 * (low + high), 0.0, 0.5 * (high - low), 0.0, 0.0, 0.0])).ravel()
        samples = np.array(values(np.linspace(low, high, 201)[None, :])).ravel()
        assert size >= np.max(np.abs(samples)) * (1 - 1e-12)
        if found > 0:
            hides += 1
            assert found >= np.ptp(samples) * (1 - 1e-9)
        else:
            tame += 1
    assert tame > 100
    assert hides > 0 or name == "square"


CANCELLING = {
    "itself": lambda d: d, "square": lambda d: d * d, "root": lambda d: ca.sqrt(d * d + 1e-20), "product": lambda d: 3 * d * (d + 2),
    "quotient": lambda d: d / (1 + d), "inverse": lambda d: 1 / d, "direction": lambda d: d / ca.sqrt(d * d + 1e-20),
}  # fmt: skip


@pytest.mark.parametrize("distance", [1e-3, -1e-8])
@pytest.mark.parametrize("name", CANCELLING)
def test_the_rounding_of_a_difference_reaches_what_is_made_of_it(name, distance):
    """What cancels in ``d = y - 1`` is passed on by slopes, neither lost in a root nor multiplied with itself."""
    d = ca.SX.sym("d")
    function = CANCELLING[name](d)
    y, t, p, m = ca.SX.sym("y"), ca.SX.sym("t"), ca.SX(0, 1), ca.SX(0, 1)
    field = ca.Function("field", [y, t, p, m], [ca.substitute(function, d, y - 1), ca.SX(0, 1), ca.SX(0, 1)])
    nodes, outputs = read(field)
    box, _, terms = unseen(nodes, [outputs[0][0]], 1, 18, lambda i: ca.SX(nodes[i].number))
    found = float(ca.Function("terms", [box], [terms])([1 + distance, *[0.0] * 5]))
    value, slope = (float(e) for e in ca.Function("f", [d], [function, ca.gradient(function, d)])(distance))
    right = abs(value) + abs(slope) * (2 + distance - abs(distance))
    # every use of d counts by itself, and every sum of these again
    assert right * (1 - 1e-6) <= found <= 4 * right + (4 / abs(distance) if name == "direction" else 0)


def bound_of_unseen(expression, at, radius, mode, slope=0.0):
    """Return what an expression of y, t and a mode of one number may hide while both stay within a radius.

    Both change by `slope` to each side as straight lines, a part of the radius.
    """
    y, t, p, m = ca.SX.sym("y"), ca.SX.sym("t"), ca.SX(0, 1), ca.SX.sym("m")
    field = ca.Function("field", [y, t, p, m], [expression(y, t, m), ca.SX(0, 1), ca.SX(0, 1)])
    nodes, outputs = read(field)

    def fixed(i):
        return ca.SX(mode if nodes[i].place else nodes[i].number)

    box, out, _ = unseen(nodes, [outputs[0][0]], 1, 18, fixed)
    return float(ca.Function("bound", [box], [out])([*at, radius, radius, slope, slope]))


@pytest.mark.parametrize(
    "expression",
    [
        lambda y, t, m: y * (t + m * y**12),
        lambda y, t, m: (y + m * t**12) ** 3,
        lambda y, t, m: y * t * (1 + y + m * y**12) ** 8,
        lambda y, t, m: y**3 * ((1 + t) ** 12 - m * y**12),
        lambda y, t, m: (
            y * (1 + t) * (2 + y) * (3 + t) * (4 + y) * (5 + t) * (6 + y) * (7 + t) * (8 + y) * (9 + t) + m * y**12
        ),
    ],
)
def test_powers_that_a_mode_switches_off_hide_nothing(expression):
    """Terms and factors that are zero, or hardly change, add nothing to the degree of what they are part of."""
    assert bound_of_unseen(expression, (0.0, 0.0), 0.01, 0.0) == 0.0
    assert bound_of_unseen(expression, (0.0, 0.0), 0.01, 1.0) > 0.0


@pytest.mark.parametrize("size", [1e-6, 1e-4])
def test_integrators_see_pulses_of_some_tolerances(size):
    """A mass that slides freely is pushed for a moment: the impulse, four tolerances and more, arrives whole."""
    width, end = 0.02, 10.0
    pulse = size * sp.exp(-(((T - sp.Rational(31, 10)) / width) ** 2))
    scene = sf.Scene(sf.System([Q], [U], [[1]], [pulse]), [], {}, {Q: 0.0, U: 1.0}, end)
    impulse = size * width * np.sqrt(np.pi)
    run = sf.simulate(scene, 1e-8, sf.Integrators(plugin="erk")).checked()
    assert run.final[1] - 1 == pytest.approx(impulse, rel=0.05)
    assert run.final[0] - end == pytest.approx(impulse * (end - 3.1), rel=0.05)


def test_a_small_speed_of_large_velocities_hides_nothing_where_they_change_alike():
    def of_speed(y, t, m):
        return 1 / ca.sqrt((y - t) ** 2 + (3 * (t - y)) ** 2)

    assert bound_of_unseen(of_speed, (1.0, 1.001), 0.1, 1, slope=0.1) == 0
    assert bound_of_unseen(of_speed, (1.0, 1.001), 0.1, 1, slope=0.09) > 1e3
    assert bound_of_unseen(of_speed, (1.0, 1.001), 0.1, 1) > 1e3
