"""Motions with bristle laws against closed forms, a second solver, 30 digits, and the set-valued law they tend to."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric_evidence.bench.larger import bristles
from symfric_evidence.bench.many_digits import many_digits
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
V, A, W = sp.symbols("v_b a Omega", positive=True)
T = sf.TIME
LUGRE = sf.laws.lugre(0.4, 0.25, 0.1, 1000.0, 10.0)
HEAVY = 1e14  # a mass that friction does not move: the slip is imposed by the floor


def belt(law, **changes):
    given = {"initial": {X: 0.0, U: 0.0}, "horizon": 50.0, "values": {V: 0.2}} | changes
    system = sf.System([X], [U], [[1]], [-X - U / 10])
    return sf.Scene(system, [sf.Contact("belt", U - V, 1, law)], outputs={"end": sf.End()}, **given)


def imposed(law, speed, horizon, outputs, start=0.0):
    """A contact whose slip velocity is a function of time."""
    contact = sf.Contact("floor", U + speed, 1, law)
    initial = {X: 0.0, U: 0.0, "floor.z": start}
    return sf.Scene(sf.System([X], [U], [[HEAVY]], [0]), [contact], {}, initial, horizon, outputs)


MU = sf.friction_force("floor")


def test_p9_is_the_same_scene_written_by_hand():
    made, written = (sf.simulate(s, 1e-11).final for s in (belt(LUGRE), bristles()))
    assert made == pytest.approx(written, abs=1e-11)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "law",
    [
        sf.laws.dahl(0.3, 200.0),
        sf.laws.dahl(0.3, 200.0, 2),
        sf.laws.lugre(0.4, 0.3, 0.1, 200.0, 5.0, 0.1),
        sf.laws.elasto_plastic(0.4, 0.3, 0.1, 200.0, 5.0, 0.1, z_ba=1e-3),
    ],
    ids=["dahl", "dahl 2", "lugre", "elasto-plastic"],
)
def test_against_other_solvers(law):
    scene = belt(law, horizon=12.0)
    found = sf.simulate(scene, 1e-11)
    assert found.status == sf.Status.OK
    assert sf.simulate(scene, 1e-9, route="integrators").final == pytest.approx(found.final, abs=1e-7)
    memory, w = law.memory, sp.Symbol("w", real=True)
    z = memory.symbols[0]
    of = {sp.Symbol("slip velocity w", real=True): w, sp.Symbol("direction of slip d", real=True): sp.sign(w)}
    rate, mu = (sp.lambdify((z, w), e.xreplace({**of, sf.SPEED: sp.Abs(w)})) for e in (memory.rates[0], memory.force))

    def field(t, y):
        return [y[1], -y[0] - y[1] / 10 - mu(y[2], y[1] - 0.2), rate(y[2], y[1] - 0.2)]

    plain = solve_ivp(field, (0, 12), np.zeros(3), method="DOP853", rtol=1e-11, atol=1e-13, max_step=0.02)
    assert found.final == pytest.approx(plain.y[:, -1], abs=2e-8)


@pytest.mark.parametrize("horizon", longer([0.5, 2.0], [2.0]))
def test_against_many_digits(horizon):
    scene = belt(sf.laws.lugre(0.4, 0.3, 0.1, 50.0, 5.0), horizon=horizon)
    found, reference = sf.simulate(scene, 1e-13), many_digits(scene, 24)
    assert found.final == pytest.approx([float(v) for v in reference.final], abs=1e-12)


def test_dahl_after_a_reversal_of_steady_sliding():
    law, far = sf.laws.dahl(1.0, 10.0), 5.0
    speed = sp.Piecewise((1, T < far), (2 * far + 1 - 2 * T, T < far + 1), (-1, True))  # turns at far + 1/2
    turned = far + 0.5 + np.sqrt(0.1)  # a distance .1 before
    run = sf.simulate(imposed(law, speed, far + 1, {"mu": sf.At(-MU, turned)}), 1e-12)
    assert -run["mu"] == pytest.approx(sf.theory.presliding.dahl_reversal(1.0, 10.0, 0.1), abs=1e-9)
    assert -run["mu"] == pytest.approx(1 - 2 * np.exp(-1.0), abs=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("exponent", [1, 2, 1.5])
def test_dahl_from_rest_has_its_stiffness_and_its_limit(exponent):
    law = sf.laws.dahl(0.5, 10.0, exponent)
    run = sf.simulate(imposed(law, 1, 1.0, {"mu": sf.Samples(-MU, [1e-6, 0.02])}), 1e-12)
    assert run["mu"][0] == pytest.approx(1e-6 * float(law.stiffness), rel=1e-4)
    n, y = exponent, 10.0 * 0.02 / 0.5
    exact = 1 - np.exp(-y) if n == 1 else 1 - (1 + (n - 1) * y) ** (-1 / (n - 1))
    assert run["mu"][1] == pytest.approx(0.5 * exact, rel=1e-9)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("speed", [1e-4, 1e-3, 0.01, -0.02])
def test_steady_sliding_is_that_of_the_law(speed):
    law = sf.laws.lugre(1.5, 1.0, 0.001, 1e3, 3.0, 0.4)
    far = 0.05 / abs(speed)
    run = sf.simulate(imposed(law, speed, far, {"mu": sf.At(-MU)}), 1e-11)
    assert run["mu"] == pytest.approx(law(speed), rel=1e-9)


@pytest.mark.parametrize("amplitude", 10.0 ** np.arange(-14, 3, 2))
def test_closed_forms_keep_their_digits(amplitude):
    with mpmath.workdps(60):
        mu_c, sigma, X = mpmath.mpf(0.3), mpmath.mpf(10), mpmath.mpf(amplitude)
        y = sigma * X / mu_c
        loop = float(4 * mu_c**2 / sigma * (y - mpmath.tanh(y)))
        high = min(X, mpmath.mpf(0.29))
        drift = float(mu_c / sigma * mpmath.log((mu_c**2 - high**2 / 4) / (mu_c**2 - high**2)))
    assert sf.theory.presliding.dahl_loop(0.3, 10, amplitude) == pytest.approx(loop, rel=1e-14)
    found = sf.theory.presliding.lugre_drift(10, float(high) / 2, float(high), 0.3)
    assert found == pytest.approx(drift, rel=1e-13)
    with pytest.raises(sf.SceneError, match="must not be negative"):
        sf.theory.presliding.dahl_reversal(0.3, 10, -amplitude)


def test_energy_of_a_dahl_loop_and_its_balance():
    mu_c, sigma, amplitude = 0.4, 30.0, 0.02
    speed, period = amplitude * sp.cos(T), 2 * sp.pi.evalf()
    law, heat = sf.laws.dahl(mu_c, sigma), sf.Integral(sf.dissipated_power("floor"))
    many = {"heat": heat, "stored": sf.At(sf.stored_energy("floor"))}
    few, more = (sf.simulate(imposed(law, speed, n * float(period), many), 1e-12) for n in (8, 9))
    loop = sf.theory.presliding.dahl_loop(mu_c, sigma, amplitude)
    assert more["heat"] - few["heat"] == pytest.approx(loop, rel=1e-9)
    assert more["stored"] == pytest.approx(few["stored"], rel=1e-6)


def test_energies_add_up_to_the_work_of_friction():
    work = -sf.friction_force("belt") * sf.slip("belt")
    names = {"work": work, "heat": sf.dissipated_power("belt")}
    scene = belt(LUGRE).wanting(
        {n: sf.Integral(e) for n, e in names.items()} | {"stored": sf.At(sf.stored_energy("belt"))}
    )
    run = sf.simulate(scene, 1e-11)
    assert run["heat"] + run["stored"] == pytest.approx(run["work"], rel=1e-11)
    assert abs(sf.simulate(scene.wanting({"path": sf.Trajectory()})).energy_residual()) < 1e-9


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("sigma2", "passive"), [(0.0, False), (11.0, True)])
def test_lugre_is_passive_under_its_condition(sigma2, passive):
    """Bristles stretched to the static limit, then pulled on at high speed, give energy back if it is violated."""
    law = sf.laws.lugre(1.5, 1.0, 0.01, 100.0, 20.0, sigma2)
    assert (law.memory.passive >= 0) == passive
    run = sf.simulate(imposed(law, 100.0, 1e-6, {"p": sf.Min(sf.dissipated_power("floor"))}, start=0.0149), 1e-9)
    assert (run["p"] >= 0) == passive


@pytest.mark.one_in(2)
@pytest.mark.parametrize("law", ["lugre", "elasto_plastic"])
def test_drift_under_a_cyclic_load_below_the_limit(law):
    """A light body under a load that goes slowly between .2 and .8 of the limit."""
    law = (
        sf.laws.lugre(1.0, 1.0, 1.0, 100.0)
        if law == "lugre"
        else sf.laws.elasto_plastic(1.0, 1.0, 1.0, 100.0, z_ba=0.0085)
    )
    mass, period = 1e-6, 100.0
    load = (5 - 3 * sp.cos(2 * sp.pi * T / period)) / 10
    contact = sf.Contact("floor", U, 1, law)
    system = sf.System([X], [U], [[mass]], [load - U * 0.002])  # dashpot: no ringing of the light body
    start = {X: 0.0, U: 0.0, "floor.z": 0.002}
    scene = sf.Scene(system, [contact], {}, start, 3 * period, {"x": sf.Samples(X, [period, 2 * period, 3 * period])})
    steps = np.diff(sf.simulate(scene)["x"])
    drift = sf.theory.presliding.lugre_drift(100.0, 0.2, 0.8)
    expected = drift if law.source.startswith("Canudas") else 0.0
    assert steps == pytest.approx([expected] * 2, abs=2e-4 * drift)


def oscillator(law, start=1.0, horizon=12.0):
    contact = sf.Contact("floor", U, 1, law)
    return sf.Scene(sf.System([X], [U], [[1]], [-X]), [contact], {}, {X: start, U: 0.0}, horizon, {"end": sf.End()})


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "law", [lambda s: sf.laws.dahl(0.03, s), lambda s: sf.laws.lugre(0.03, 0.03, 1.0, s)], ids=["dahl", "lugre"]
)
def test_stiff_bristles_tend_to_the_set_valued_law_like_the_inverse_root_of_the_stiffness(law):
    """After a reversal, friction needs a distance mu_c/sigma to turn, which takes a time like its root."""
    exact = sf.simulate(oscillator(sf.laws.coulomb(0.03))).final[:2]
    runs = [sf.simulate(oscillator(law(s)), 1e-11).final[:2] for s in (20.0, 40.0, 80.0, 160.0)]
    errors = [float(np.max(np.abs(r - exact))) for r in runs]
    ratios = [a / b for a, b in zip(errors, errors[1:], strict=False)]
    assert ratios == pytest.approx([2**0.5] * 3, rel=0.01)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("law", [LUGRE, sf.laws.elasto_plastic(0.4, 0.25, 0.1, 1000.0, 10.0, z_ba=1e-4)])
def test_sensitivities_through_reversals(law):
    scene = belt(law, horizon=20.0)
    run = sf.simulate(scene, 1e-12, sensitivities=["v_b", "belt.z"])
    for name, step in (("v_b", 1e-5), ("belt.z", 1e-7)):
        at = (lambda d: scene.where({"v_b": 0.2 + d})) if name == "v_b" else (lambda d: scene.starting({"belt.z": d}))
        ends = [sf.simulate(at(d), 1e-13).final for d in (step, -step)]
        assert run.sensitivities[name] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-5, abs=1e-6)


def test_many_cases_at_once_are_single_runs():
    program = sf.prepare(belt(LUGRE))
    speeds = np.linspace(0.1, 0.3, 7)
    batch = program.map(values={"v_b": speeds}, initial={"belt.z": 1e-5})
    for k in (0, 3, 6):
        assert np.array_equal(batch.final[:, k], program.run({"v_b": speeds[k]}, {"belt.z": 1e-5}).final)


def test_equilibrium_stability_hopf_and_cycle():
    scene = belt(LUGRE)
    rest = sf.equilibrium(scene.where({"v_b": 0.3}))
    assert rest.x[0] == pytest.approx(LUGRE(0.3), rel=1e-12)
    assert rest.x[2] == pytest.approx(-LUGRE(0.3) / 1000, rel=1e-12)
    onset, by_hand = sf.hopf(scene, "v_b", (0.05, 0.4)), sf.hopf(bristles(), "v_b", (0.05, 0.4))
    assert onset.value == pytest.approx(by_hand.value, rel=1e-10)
    assert (onset.kind, onset.omega) == (by_hand.kind, pytest.approx(by_hand.omega, rel=1e-10))
    for away, stable in ((1.01, True), (0.99, False)):
        assert sf.stability(scene.where({"v_b": onset.value * away})).stable is stable
    cycle = sf.limit_cycle(scene.where({"v_b": 0.1}))
    long = sf.simulate(scene.where({"v_b": 0.1}).wanting({"path": sf.Trajectory()}).until(200.0))
    late = long.x[0][long.t > 150]
    assert cycle.stable
    assert cycle.x_max[0] == pytest.approx(np.max(late), rel=1e-4)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("load", ["constant", "over time", "over place"])
def test_elasto_plastic_bristles_arrive_at_steady_sliding_without_chatter(load):
    """Far above the Stribeck speed the deflection and its steady value agree to the last digits, for good."""
    N, a = sp.symbols("N a", positive=True)
    normal = N * (1 + a * {"constant": 0, "over time": sp.sin(2 * T), "over place": sp.sin(X)}[load])
    values = {V: 0.8, N: 2.0} | ({} if load == "constant" else {a: 0.2})
    outputs = {"end": sf.End(), "z": sf.At(sp.Symbol("belt.z", real=True))}
    law = sf.laws.elasto_plastic(0.4, 0.3, 0.1, 100.0, z_ba=0.0018)
    contact = sf.Contact("belt", U - V, normal, law)
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X - U / 10]), [contact], values, {X: 0, U: 0}, 10.0, outputs)
    program = sf.prepare(scene, 1e-11)
    for speed in (0.8, 0.9, 1.1):
        for x in (-0.4, 0.1, 0.6):
            run = program.run({V: speed}, {X: x, U: 0.3}).checked()
            w = abs(run.final[1] - speed)
            assert abs(run["z"]) == pytest.approx((0.3 + 0.1 * np.exp(-((w / 0.1) ** 2))) / 100, rel=1e-9)
