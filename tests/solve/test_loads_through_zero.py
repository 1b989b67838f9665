"""Normal loads that vanish on the way, at once or gently, while the contact slips or sticks, with or without a pull."""

import numpy as np
import pytest
import sympy as sp
from scipy import integrate

import symfric as sf
from tests.longer import longer

X, U, Y, W = sp.symbols("x u y w", real=True)
T = sf.TIME
LAW = sf.laws.coulomb(0.3)
P = sp.Symbol("P")
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12)
FORMS = {
    "max": lambda z: sp.Max(z, 0),
    "times a parameter of any sign": lambda z: P * sp.Max(0, z),
    "branches": lambda z: sp.Piecewise((z, z > 0), (0, True)),
    "magnitude": lambda z: (sp.Abs(z) + z) / 2,
    "gently": lambda z: sp.Max(z, 0) ** 2,
}


def one_mass(load, *, force=-X, law=LAW, belt=0, start=(0.0, 0.0), horizon=8.0, values=None):
    initial = dict(zip((X, U), start, strict=True))
    values = values or ({P: 1.0} if P in load.free_symbols else {})
    contact = sf.Contact("c", U - belt, load, law)
    return sf.Scene(sf.System([X], [U], [[1]], [force]), [contact], values, initial, horizon)


@pytest.mark.one_in(30)
@pytest.mark.parametrize("start", [(-1.0, 0.0), (-0.8, 0.0), (-0.7, 0.0), (-0.5, 0.0), (-0.5, 0.3)])
@pytest.mark.parametrize("form", FORMS)
def test_a_load_that_ends_at_a_place(form, start):
    scene = one_mass(FORMS[form](X + sp.Rational(1, 2)), belt=sp.Rational(1, 10), start=start)
    fine = sf.simulate(scene, 1e-13, "taylor").checked()
    for tolerance in TOLERANCES:
        assert sf.simulate(scene, tolerance).checked().final == pytest.approx(fine.final, abs=50 * tolerance)
    assert sf.simulate(scene, 1e-9, "integrators").checked().final == pytest.approx(fine.final, abs=1e-7)


@pytest.mark.one_in(24)
@pytest.mark.parametrize("case", range(4))
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("seed", longer(range(4), (1, 2, 3)))
def test_a_load_that_comes_and_goes_with_time(form, seed, case):
    rng = np.random.default_rng([11, seed])
    wave = sp.sin(float(rng.uniform(0.5, 2)) * T + float(rng.uniform(0, 6))) + float(rng.uniform(-0.5, 0.5))
    drop = sf.laws.coulomb(0.5, 0.3)
    force, belt = ((0 * X, 0), (0 * X, 0.1), (-X, 0.1), (-X + sp.sin(T) / 2, 0))[case]
    scene = one_mass(FORMS[form](wave), force=force, belt=belt, law=drop, start=rng.uniform(-1, 1, (4, 2))[case])
    runs = [sf.simulate(scene, tolerance).checked() for tolerance in (1e-6, 1e-9, 1e-12)]
    assert runs[0].final == pytest.approx(runs[2].final, abs=1e-4)
    assert runs[1].final == pytest.approx(runs[2].final, abs=1e-7)


@pytest.mark.parametrize("tolerance", longer((1e-6, 1e-9, 1e-12), (1e-6, 1e-12)))
def test_loads_that_begin_at_a_step_in_time_are_those_that_bend(tolerance):
    """The instant of the step is known to rounding; a load that rises from zero there is not negative just before it."""
    rate, phase, shift = sp.symbols("rate phase shift")
    loads = [FORMS[form](sp.sin(rate * T + phase) + shift) for form in ("branches", "max")]
    given, drop = {rate: 1.0, phase: 0.0, shift: 0.0}, sf.laws.coulomb(0.5, 0.3)
    scenes = [one_mass(load, force=0 * X, law=drop, values=given) for load in loads]
    step, bend = (sf.prepare(scene, tolerance, "taylor") for scene in scenes)
    rng = np.random.default_rng(12)
    for _ in range(60):
        values = {"rate": rng.uniform(0.5, 2), "phase": rng.uniform(0, 6), "shift": rng.uniform(-0.5, 0.5)}
        start = {"x": rng.uniform(-1, 1), "u": rng.uniform(-1, 1)}
        runs = [program.run(values, start).checked() for program in (step, bend)]
        assert runs[0].final == pytest.approx(runs[1].final, abs=30 * tolerance + 1e-11)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("route", [None, "taylor", "integrators"])
@pytest.mark.parametrize("push", [0.0, 1.0])
def test_a_block_that_bounces_on_a_spring(push, route):
    """It flies and lands; sideways it slides to rest by the impulse of the spring, and nothing moves it after that."""
    spring = sp.Max(-1000 * Y, 0)
    system = sf.System([X, Y], [U, W], sp.eye(2), [0, spring - 9.81])
    start = {X: 0.0, Y: 1.0, U: push, W: 0.0}
    scene = sf.Scene(system, [sf.Contact("floor", U, spring, sf.laws.coulomb(0.3))], {}, start, 5.0)

    def rate(t, y):  # while it slides
        load = max(-1000 * y[1], 0)
        return [y[2], y[3], -0.3 * load if push else 0.0, load - 9.81]

    rests = lambda t, y: y[2]  # noqa: E731
    rests.terminal = push > 0
    slides = integrate.solve_ivp(rate, (0, 5), [0, 1, push, 0], events=rests, rtol=1e-11, atol=1e-12, max_step=0.01)
    for tolerance in (1e-8,) if route == "integrators" else TOLERANCES:
        run = sf.simulate(scene, tolerance, route).checked()
        assert run.final[0] == pytest.approx(slides.y[0, -1], abs=1e-8 + 10 * tolerance)
        assert run.final[2] == pytest.approx(0, abs=1e-12)
        energy = 0.5 * run.final[3] ** 2 + 9.81 * run.final[1] + 500 * min(run.final[1], 0) ** 2
        assert energy == pytest.approx(9.81, rel=1e-7 + 100 * tolerance)
        if route != "integrators":
            assert [(e.before, e.after) for e in run.events] == [(1, 0)] * (push > 0)  # and sticks from then on


@pytest.mark.long(beside="test_a_load_that_ends_at_a_place")
def test_a_load_that_touches_zero_and_returns():
    for load in (1 + sp.sin(T), 1 - sp.cos(T), sp.sin(T) ** 2, (X - sp.Rational(1, 2)) ** 2):
        scene = one_mass(load, law=sf.laws.coulomb(0.4), start=(1.0, 0.2))
        fine = sf.simulate(scene, 1e-13).checked()
        for tolerance in (1e-6, 1e-9, 1e-11):
            assert sf.simulate(scene, tolerance).checked().final == pytest.approx(fine.final, abs=100 * tolerance)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("others", [1.0, 1e6])
def test_a_load_that_becomes_negative_is_lost_whatever_the_others_are(others):
    contacts = [sf.Contact("far", W - 1, others, sf.laws.coulomb(0.3)), sf.Contact("c", U, 1 - T, sf.laws.coulomb(0.3))]
    heavy = sf.Contact("heavy", W - 2, others * (1 + sp.sin(T) / 2), sf.laws.coulomb(0.3))
    system = sf.System([X, Y], [U, W], [[1, 0], [0, others]], [0, 0])
    scene = sf.Scene(system, [*contacts, heavy], {}, {X: 0, Y: 0, U: 3, W: 0}, 5.0)
    run = sf.simulate(scene, 1e-6)
    assert run.status == sf.Status.LOST_CONTACT
    assert run.t_final == pytest.approx(1, abs=1e-4)
