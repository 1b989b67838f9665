"""What a scene wants: extremes, integrals, stop time and events against dense evaluation and closed forms."""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
FORCE, SLIP = sf.friction_force("belt"), sf.slip("belt")
BELT = sf.scenes.mass_on_belt(v_b=0.2)
EXCITED = sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=50.0, horizon=20.0)
V_B = BELT.parameter("v_b")


def mass(force=-X, *, x=1.0, u=0.0, horizon=20.0, contacts=(), **more):
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[force])
    return sf.Scene(system=system, contacts=contacts, initial={X: x, U: u}, horizon=horizon, **more)


def dense(run, n=40):
    """Times within every step, ends included, and the states there."""
    t = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b in zip(run.t[:-1], run.t[1:], strict=True)])
    t = np.append(t, run.t_final)
    return t, run(t)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("scene", [BELT, EXCITED], ids=["stick-slip", "excited"])
def test_extremes_agree_with_the_trajectory(scene):
    expressions = {
        "x": X,
        "u": U,
        "energy": X**2 / 2 + U**2 / 2,
        "slip": U - V_B,
        "product": X * U,
        "wave": sp.cos(9 * X),
    }
    wanted = {"path": sf.Trajectory()}
    for name, e in expressions.items():
        wanted |= {f"max {name}": sf.Max(e), f"min {name}": sf.Min(e), f"half {name}": sf.HalfRange(e)}
    run = sf.simulate(scene.wanting(wanted), 1e-11).checked()
    _, (x, u) = dense(run)
    for name, e in expressions.items():
        samples = sp.lambdify((X, U, V_B), e)(x, u, 0.2)
        high, low = run[f"max {name}"], run[f"min {name}"]
        assert high >= samples.max() - 1e-12
        assert low <= samples.min() + 1e-12
        assert high == pytest.approx(samples.max(), abs=2e-3 * (high - low))
        assert low == pytest.approx(samples.min(), abs=2e-3 * (high - low))
        assert run[f"half {name}"] == pytest.approx((high - low) / 2, abs=1e-15)


def test_extremes_of_the_limit_cycle_are_the_reference_numbers():
    end = sf.simulate(BELT.until(1000.0).wanting({"end": sf.End()}), 1e-13).final
    wanted = {"high": sf.Max(X), "low": sf.Min(X), "half": sf.HalfRange(X)}
    run = sf.simulate(BELT.until(14.0).starting(dict(zip("xu", end, strict=True))).wanting(wanted), 1e-13)
    assert run["high"] == pytest.approx(0.56646946672378879, abs=1e-12)
    assert run["low"] == pytest.approx(-0.00594797136776122, abs=1e-12)
    assert run["half"] == pytest.approx(0.28620871904577500, abs=1e-12)


def test_extremes_at_the_ends_of_a_run_count():
    run = sf.simulate(mass(0, x=1.0, u=-0.5, horizon=3.0).wanting({"high": sf.Max(X), "low": sf.Min(X)}), 1e-9)
    assert run.outputs == pytest.approx({"high": 1.0, "low": -0.5})


def test_extremes_of_a_harmonic_motion():
    wanted = {"high": sf.Max(X), "low": sf.Min(X * U), "constant": sf.Max(3 + 0 * X), "clock": sf.Max(sf.TIME * X)}
    run = sf.simulate(mass(horizon=20.0).wanting(wanted), 1e-13)
    assert run["high"] == pytest.approx(1, abs=1e-12)
    assert run["low"] == pytest.approx(-0.5, abs=1e-12)
    assert run["constant"] == 3
    t = np.linspace(0, 20, 200001)
    assert run["clock"] == pytest.approx(np.max(t * np.cos(t)), abs=1e-7)


def test_integrals_have_their_closed_forms():
    T = 20.0
    wanted = {
        "x": sf.Integral(X),
        "square": sf.Integral(X**2),
        "one": sf.Integral(sp.Integer(1)),
        "ramp": sf.Integral(sf.TIME * U),
        "long": sf.Integral(sp.sqrt(1 + X**2)),
    }
    run = sf.simulate(mass(horizon=T).wanting(wanted), 1e-13)
    assert run["x"] == pytest.approx(math.sin(T), abs=1e-12)
    assert run["square"] == pytest.approx(T / 2 + math.sin(2 * T) / 4, abs=1e-11)
    assert run["one"] == pytest.approx(T, abs=1e-13)
    assert run["ramp"] == pytest.approx(T * math.cos(T) - math.sin(T), abs=1e-11)
    t = np.linspace(0, T, 4001)
    f = np.sqrt(1 + np.cos(t) ** 2)
    assert run["long"] == pytest.approx(np.sum((f[1:] + f[:-1]) / 2) * T / 4000, rel=1e-6)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_work_of_friction_is_the_energy_that_is_lost(tolerance):
    floor = sf.friction_force("floor") * sf.slip("floor")
    run = sf.simulate(
        sf.scenes.coulomb_oscillator(0.03).wanting({"work": sf.Integral(floor), "end": sf.End()}), tolerance
    )
    assert run["work"] == pytest.approx((0.02**2 - 1) / 2, abs=10 * tolerance)


def test_balance_of_work_on_the_belt():
    wanted = {"friction": sf.Integral(FORCE * U), "damper": sf.Integral(U**2 / 10), "end": sf.End()}
    run = sf.simulate(BELT.wanting(wanted), 1e-12)
    x, u = run["end"]
    assert run["friction"] - run["damper"] == pytest.approx((x**2 + u**2) / 2, abs=1e-11)


def test_friction_force_and_slip_follow_the_law():
    mu = BELT.contacts[0].law
    wanted = {"highest": sf.Max(FORCE), "lowest": sf.Min(FORCE), "slip": sf.Max(SLIP), "path": sf.Trajectory()}
    run = sf.simulate(BELT.wanting(wanted), 1e-12)
    assert run["slip"] == pytest.approx(0, abs=1e-14)  # the mass never overtakes the belt
    assert run["highest"] == pytest.approx(0.4, abs=1e-12)  # released at the static bound
    _, (x, u) = dense(run)
    slipping = u - 0.2 < -1e-9
    sticking = np.where(slipping, np.inf, x + 0.1 * u)
    assert run["lowest"] == pytest.approx(min(np.min(-mu(u[slipping] - 0.2)), np.min(sticking)), abs=1e-4)


def test_integral_of_the_stick_force():
    # held on the belt from the start: force = x + 2 beta v_b, x = v_b t
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=1.5).starting({"u": 0.2}).wanting({"pull": sf.Integral(FORCE)})
    assert sf.simulate(scene, 1e-12)["pull"] == pytest.approx(0.2 * 1.5**2 / 2 + 0.02 * 1.5, abs=1e-13)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-13])
def test_stop_time(tolerance):
    run = sf.simulate(sf.scenes.coulomb_oscillator(0.03).wanting({"rest": sf.StopTime()}), tolerance)
    assert run["rest"] == pytest.approx(17 * math.pi, rel=10 * tolerance)


def test_stop_time_is_not_a_number_while_something_moves():
    assert math.isnan(sf.simulate(BELT.wanting({"rest": sf.StopTime()}))["rest"])
    early = sf.scenes.coulomb_oscillator(0.03).until(50.0).wanting({"rest": sf.StopTime()})
    assert math.isnan(sf.simulate(early)["rest"])


def test_a_pause_is_no_stop():
    # held until the load has grown to the static bound: rests, moves, rests
    ground = sf.Contact("floor", U, 1, sf.laws.coulomb(0.5))
    signal = sf.Signal([0, 0, 1, 1, 0, 0], 1.0)
    a = sp.Symbol("a", real=True)
    scene = mass(a, x=0.0, horizon=12.0, contacts=[ground], inputs={a: signal}).wanting({"rest": sf.StopTime()})
    run = sf.simulate(scene, 1e-11)
    # force a - 1/2 from t = 1.5 on: velocity peaks at 3.5 with .125 + .5 + .125, then falls
    fall = lambda t: 0.75 - (t - 3.5) ** 2 / 2  # noqa: E731
    stop = 3.5 + 0.5 + (fall(4.0)) / 0.5
    assert run["rest"] == pytest.approx(stop, abs=1e-9)


def test_events_alone_agree_with_those_of_the_trajectory():
    both = [sf.simulate(BELT.wanting({"o": o}), 1e-11) for o in (sf.Events(), sf.Trajectory())]
    assert both[0].events == both[1].events
    assert both[0]["o"] == both[0].events
    assert len(both[0].events) == both[0].stats["events"] == 30
    first = both[0].events[0]
    assert (first.contact, first.before, first.after, first.kind) == ("belt", -1, 0, "stick")
    assert both[0].events[1].kind == "slip"
    kinds = {e.kind for e in sf.simulate(EXCITED.wanting({"e": sf.Events()}), 1e-9).events}
    assert kinds >= {"reverse"}


def test_the_end_is_the_final_state():
    run = sf.simulate(BELT.wanting({"end": sf.End()}), 1e-9)
    assert run["end"].tolist() == run.final.tolist()
    assert run.t_final == 100


def test_outputs_do_not_change_the_motion():
    alone = sf.simulate(BELT.wanting({"end": sf.End()}), 1e-12).final
    wanted = {"p": sf.Trajectory(), "m": sf.Max(sp.sin(X)), "i": sf.Integral(FORCE * SLIP), "r": sf.StopTime()}
    assert sf.simulate(BELT.wanting(wanted), 1e-12).final == pytest.approx(alone, abs=1e-11)


def test_scalars_alone_keep_no_path_and_no_events():
    run = sf.simulate(BELT.wanting({"high": sf.Max(X)}), 1e-9)
    assert run.raw.path is None
    assert run.raw.events is None
    for ask in (lambda: run.x, lambda: run.t, lambda: run.mode, lambda: run(1.0), lambda: run["x"], run.to_xarray):
        with pytest.raises(sf.SceneError, match="Trajectory"):
            ask()
    with pytest.raises(sf.SceneError, match="Events"):
        _ = run.events
    assert run.energy_residual() < 1e-7  # repeats the run with a path


def test_equal_expressions_share_a_row():
    run = sf.simulate(BELT.wanting({"a": sf.Max(X), "b": sf.Max(X), "c": sf.Min(X), "i": sf.Integral(X)}), 1e-9)
    assert run["a"] == run["b"] > run["c"]


@pytest.mark.parametrize("name", ["Max", "Min"])
def test_kinks_of_an_output_are_followed(name):
    output = getattr(sf, name)(sp.Abs(X) - sp.Max(X, U))
    run = sf.simulate(mass(horizon=20.0).wanting({"o": output, "path": sf.Trajectory()}), 1e-12)
    t = np.linspace(0, 20, 400001)
    samples = np.abs(np.cos(t)) - np.maximum(np.cos(t), -np.sin(t))
    assert run["o"] == pytest.approx(samples.max() if name == "Max" else samples.min(), abs=1e-4)
