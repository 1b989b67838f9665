"""Lyapunov exponents against closed forms, known values, and the divergence of two motions."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
B = sp.Symbol("b", positive=True)
BETA = 0.05


def oscillator(force, values=None, contacts=(), horizon=2000.0):
    return sf.Scene(
        sf.System(q=[X], u=[U], mass=[[1]], force=[force]), contacts, values or {}, {X: 1.0, U: 0.0}, horizon
    )


def chaotic_belt(w=2.35):
    """A mass that a force of 0.4 sin wt shakes while the belt drags it along: it sticks and slips without a period."""
    return sf.scenes.mass_on_belt(sf.laws.cubic(0.4, 0.1, 0.5), v_b=0.2, a=0.4 / w**2, Omega=w)


def test_damped_oscillator_has_minus_beta():
    scene = oscillator(-X - 2 * BETA * U)
    found = sf.lyapunov(scene, piece=2 * np.pi / np.sqrt(1 - BETA**2))
    assert np.allclose(found.exponents, -BETA, rtol=0, atol=1e-10)
    assert found.spread < 1e-9
    found = sf.lyapunov(scene)  # with pieces that are no whole turns the ellipse shows, and fades with 1/t
    assert found.exponent == pytest.approx(-BETA, abs=5e-5)
    assert abs(found.exponent + BETA) < 3 * found.spread
    assert np.sum(found.exponents) == pytest.approx(-2 * BETA, rel=1e-11)
    assert np.allclose(found.history[-1], found.exponent)
    assert not found.chaotic


def test_autonomous_cycles_have_zero_and_the_multipliers():
    belt = sf.scenes.mass_on_belt(v_b=0.42)  # slips all the time
    orbit = sf.limit_cycle(belt)
    found = sf.lyapunov(belt, transient=500.0, piece=orbit.period, horizon=100 * orbit.period)
    rates = np.log(np.abs(orbit.multipliers)) / orbit.period
    assert np.allclose(found.exponents, rates, rtol=0, atol=1e-7)
    assert not found.chaotic
    sticking = sf.lyapunov(belt.where({"v_b": 0.2}), horizon=1000.0)
    assert abs(sticking.exponent) < 1e-3
    assert sticking.exponents[1] == -np.inf
    assert not sticking.chaotic


def van_der_pol(strength):
    return oscillator(-X + strength * (1 - X**2) * U)


CYCLES = {
    "van der Pol": van_der_pol(1.0),
    "relaxation": van_der_pol(6.0),
    "belt that slips": sf.scenes.mass_on_belt(v_b=0.42),
    "belt beside its onset": sf.scenes.mass_on_belt(v_b=0.44),
    "belt that sticks": sf.scenes.mass_on_belt(v_b=0.2),
    "belt with a static peak": sf.scenes.mass_on_belt(sf.laws.coulomb(0.4, 0.3), v_b=0.1),
}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("number", longer([5, 20], [20]))
@pytest.mark.parametrize("name", CYCLES)
def test_no_horizon_makes_chaos_of_a_cycle(name, number):
    """Horizons at random: for some a piece is nearly a whole number of periods, or the window half a swing."""
    rng = np.random.default_rng(7)
    for horizon in rng.uniform(60.0, 1500.0, number):
        found = sf.lyapunov(CYCLES[name], horizon)
        assert not found.chaotic
        assert abs(found.exponent) < 3 * found.spread or horizon < 200


def test_pieces_of_a_whole_period_make_no_chaos_either():
    """All ends see one phase: the growth along the cycle over the window is bounded all the same."""
    scene = van_der_pol(1.0)
    period = sf.limit_cycle(scene).period
    for off in (1e-6, 1e-4, 1e-3, 4e-3):
        assert not sf.lyapunov(scene, 400 * period, piece=period * (1 + off), transient=50.3).chaotic


def test_a_forced_torus_is_no_chaos():
    """Van der Pol's oscillator, weakly forced away from its frequency: two periods, exponent 0."""
    scene = oscillator(-X + 0.3 * (1 - X**2) * U + 0.3 * sp.cos(1.31 * sf.TIME))
    for periods in (60, 100, 157, 230):
        found = sf.lyapunov(scene, periods * 2 * np.pi / 1.31)
        assert not found.chaotic
        assert abs(found.exponent) < 3 * found.spread


def test_coulomb_friction_contracts_at_its_jumps_alone():
    """x'' + x = cos bt - f Sgn x' never stops for small f; between reversals areas stay, so without saltation the sum
    of the exponents would be zero. At a reversal the derivatives of the velocity jump as the acceleration does."""
    f, b = 0.2, 0.6
    floor = sf.Contact("floor", slip=U, normal=1, law=sf.laws.coulomb(f))
    force = -X + sp.cos(B * sf.TIME)
    scene = oscillator(force - 0.05 * U, {B: b}, [floor], 300 * 2 * np.pi / b)
    found = sf.lyapunov(scene)
    run = sf.simulate(scene, 1e-12)
    period = 2 * np.pi / b
    last = [e for e in run.events if e.t > run.t_final - 20 * period]
    assert {e.kind for e in last} == {"reverse"}
    assert len(last) == 40
    pull = np.cos(b * np.array([e.t for e in last])) - run([e.t for e in last])[0]
    jumps = np.log(
        np.abs((pull - f * np.array([e.after for e in last])) / (pull - f * np.array([e.before for e in last])))
    )
    assert np.sum(found.exponents) == pytest.approx(np.sum(jumps) / (20 * period) - 0.05, rel=1e-6)
    assert np.sum(jumps) / (20 * period) < -0.05


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("force", "expected"),
    [
        (-(X**3) - U / 20 + sp.Rational(15, 2) * sp.cos(sf.TIME), 0.10),  # Ueda, J. Stat. Phys. 20 (1979) 181-196
        (X - X**3 - U / 4 + sp.Rational(2, 5) * sp.cos(sf.TIME), 0.157),  # two wells: Sprott, Chaos and Time-Series
    ],
)
def test_known_chaos_of_smooth_oscillators(force, expected):
    found = sf.lyapunov(oscillator(force), 1000 * 2 * np.pi)
    assert found.exponent == pytest.approx(expected, abs=3 * found.spread)
    assert found.spread < 0.01
    assert found.chaotic
    assert np.sum(found.exponents) == pytest.approx(float(force.diff(U)), rel=1e-9)  # the damping


def test_chaos_with_stick_and_slip_against_two_motions():
    """Two motions, 1e-7 apart and put back to that in every period, part at the rate that the derivatives say."""
    scene, n, size = chaotic_belt(), 120, 1e-7
    period = 2 * np.pi / 2.35
    start = sf.lyapunov(scene, 10 * period, transient=200 * period).end
    scene = scene.starting(dict(zip("xu", start.tolist(), strict=True)))
    found = sf.lyapunov(scene, n * period, transient=0.0, tolerance=1e-13)
    wanted = {"end": sf.End(), "path": sf.Trajectory()}
    wanted |= {f"{what.__name__} {s}": what(s) for what in (sf.Min, sf.Max) for s in (X, U)}
    program = sf.prepare(scene.until(period).wanting(wanted), 1e-13)
    follow = lambda y: program.run(initial=dict(zip("xu", y, strict=True)))  # noqa: E731
    y, way, growth, stuck, ends = start, np.array([size, 0.0]), [], 0, []
    for _ in range(n):
        here, there = follow(y), follow(y + way)
        gap = there.final - here.final
        growth.append(np.log(np.linalg.norm(gap) / size))
        y, way = here.final, gap * size / np.linalg.norm(gap)
        stuck += np.any(here.mode == 0)
        ends.append([[here.outputs[f"{what} {s}"] for s in (X, U)] for what in ("Min", "Max")])
    assert stuck > n / 3
    # lengths are relative to the ranges of the states there: that of the last distance against that of the first one
    ranges = np.max(ends, axis=0)[1] - np.min(ends, axis=0)[0]
    relative = np.log(np.linalg.norm(way / ranges) / (size / ranges[0]))
    assert found.exponent == pytest.approx((np.sum(growth) + relative) / (n * period), abs=2e-5)
    assert found.exponents[1] == -np.inf
    long = sf.lyapunov(scene, 800 * period, transient=0.0)
    assert long.chaotic
    assert long.exponent == pytest.approx(0.051, abs=3 * long.spread)  # 3000 periods: 0.05095 +- 0.001


def test_results_in_plain_form():
    found = sf.lyapunov(oscillator(-X - 2 * BETA * U), 100.0)
    assert found.to_xarray().history.values.tolist() == found.history.tolist()
    assert found.to_dict()["exponents"] == found.exponents.tolist()
    assert found.times[-1] == pytest.approx(100.0)
    assert found.plot().lines


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda scene: sf.lyapunov(scene, -1.0), "horizon is -1; it must be positive"),
        (lambda scene: sf.lyapunov(scene, piece=0.0), "piece is 0; it must be positive"),
        (lambda scene: sf.lyapunov(scene, transient=-1.0), "transient is -1; it must not be negative"),
        (lambda scene: sf.lyapunov("scene"), "not a scene"),
        (lambda scene: sf.lyapunov(oscillator(-X - sf.TIME)), "has no period"),
    ],
)
def test_wrong_input_is_one_line(ask, message):
    with pytest.raises(sf.SceneError, match=message):
        ask(oscillator(-X - 2 * BETA * U))
