"""Maxwell slip, Iwan and Bouc-Wen: exact events of the sliders, loops in closed form, Masing's rules."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp

import symfric as sf
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
V, K, L, A, W = sp.symbols("v_b k l a Omega", positive=True)
T = sf.TIME
HEAVY = 1e14  # a mass that friction does not move: the slip is imposed by the floor
MU = -sf.friction_force("floor")
HEAT = sf.Integral(sf.dissipated_power("floor"))
PERIOD = 2 * np.pi


def imposed(law, speed, horizon, outputs, start=None):
    contact = sf.Contact("floor", U + speed, 1, law)
    return sf.Scene(
        sf.System([X], [U], [[HEAVY]], [0]), [contact], {}, {X: 0.0, U: 0.0} | (start or {}), horizon, outputs
    )


def belt(law, values=None, horizon=40.0, **outputs):
    system = sf.System([X], [U], [[1]], [-X - U / 10])
    return sf.Scene(
        system,
        [sf.Contact("belt", U - V, 1, law)],
        {V: 0.2} | (values or {}),
        {X: 0.0, U: 0.0},
        horizon,
        outputs or None,
    )


def stops(path, stiffness, limits):
    """Coefficient along a displacement given by its turning points: every element is a projection of its increments."""
    k, most = np.array(stiffness), np.array(limits)
    z, found = np.zeros(k.size), []
    for a, b in zip(path, path[1:], strict=False):
        z = np.clip(z + b - a, -most / k, most / k)
        found.append(float(k @ z))
    return found


def test_elements_follow_a_varied_displacement_exactly():
    stiffness, limits = [100.0, 50.0, 20.0], [0.1, 0.2, 0.15]
    displacement = sp.sin(T) / 100 + sp.sin(sp.sqrt(7) * T) / 150 + sp.sin(5 * T) / 400
    law = sf.laws.maxwell_slip(stiffness, limits)
    times = np.linspace(0.5, 30.0, 60)
    out = {"mu": sf.Samples(MU, times), "heat": HEAT, "stored": sf.At(sf.stored_energy("floor"))}
    out |= {"work": sf.Integral(MU * sf.slip("floor"))}
    run = sf.simulate(imposed(law, displacement.diff(T), 30.0, out), 1e-12).checked()
    place, speed = sp.lambdify(T, displacement), sp.lambdify(T, displacement.diff(T))
    fine = np.linspace(0.0, 30.0, 30001)
    turns = []
    for a, b in zip(fine, fine[1:], strict=False):
        if speed(a) * speed(b) < 0:
            for _ in range(60):
                m = (a + b) / 2
                a, b = (m, b) if speed(a) * speed(m) > 0 else (a, m)
            turns.append(a)
    for t, mu in zip(times, run["mu"], strict=True):
        path = [0.0, *(place(s) for s in turns if s < t), place(t)]
        assert mu == pytest.approx(stops(path, stiffness, limits)[-1], abs=1e-11)
    assert run["heat"] + run["stored"] == pytest.approx(run["work"], rel=1e-10)


def test_states_and_events_of_the_sliders_are_shown():
    law = sf.laws.maxwell_slip([100.0, 50.0], [0.1, 0.2])
    scene = imposed(law, sp.cos(T) / 100, 2.0, {"path": sf.Trajectory()}, {"floor.z2": 0.001})
    run = sf.simulate(scene, 1e-12)
    assert run.names == ("x", "u", "floor.z1", "floor.z2")
    first, second = run.events[:2]
    assert np.sin(first.t) / 100 == pytest.approx(0.001, rel=1e-9)  # first element: .1/100
    assert np.sin(second.t) / 100 + 0.001 == pytest.approx(0.004, rel=1e-9)
    assert [(e.before, e.after) for e in run.events] == [(0, 0), (0, 1), (1, 0)]  # gross slip, and its end
    assert run["floor.z1"].max() == pytest.approx(0.001, rel=1e-12)
    assert "z_{1,floor}" in scene._repr_latex_()


@pytest.mark.one_in(2)
@pytest.mark.parametrize("side", [1, -1])
def test_loop_of_a_jenkins_element_is_that_of_a_contact_behind_a_spring(side):
    k, limit = 40.0, 0.3
    one = sf.Contact("floor", U + side * sp.cos(T) / 20, 1, sf.laws.coulomb(limit), stiffness=k)
    law = sf.laws.maxwell_slip([k], [limit])
    other = sf.Contact("floor", U + side * sp.cos(T) / 20, 1, law)
    outputs = {"mu": sf.Samples(MU, np.linspace(1, 20, 20)), "heat": HEAT, "x": sf.At(X)}
    system = sf.System([X], [U], [[1]], [-X - U / 10])
    runs = [sf.simulate(sf.Scene(system, [c], {}, {X: 0.0, U: 0.0}, 20.0, outputs), 1e-12) for c in (one, other)]
    for name in outputs:
        assert runs[0][name] == pytest.approx(runs[1][name], abs=1e-10)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("side", [1, -1])
def test_a_belt_that_starts_against_small_steps_of_projection(side):
    k, limits = np.array([30.0, 20.0]), np.array([0.15, 0.2])
    scene = belt(sf.laws.maxwell_slip(k, limits), horizon=10.0, end=sf.End()).where({"v_b": 0.2 * side})
    run = sf.simulate(scene, 1e-11).checked()
    h, x, u, z = 1e-3, 0.0, 0.0, np.zeros(2)
    for _ in range(10000):
        half = u + h / 2 * (-x - u / 10 - k @ z)
        middle = np.clip(z + h / 2 * (u - 0.2 * side), -limits / k, limits / k)
        pull = -(x + h / 2 * u) - half / 10 - k @ middle
        x, u, z = x + h * half, u + h * pull, np.clip(z + h * (half - 0.2 * side), -limits / k, limits / k)
    assert run.final == pytest.approx([x, u, *z], abs=1e-5)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("law", ["maxwell", "iwan"])
def test_masings_rules(law):
    """First loading is the backbone; a branch after a reversal is the same curve at twice the size."""
    law = sf.laws.maxwell_slip([30, 20, 10], [0.1, 0.2, 0.3]) if law == "maxwell" else sf.laws.iwan(1.0, -0.5, 0.05, 12)
    memory = law.memory
    stiffness = [float(memory.force.coeff(z)) for z in memory.symbols]
    most = [float(e) for e in memory.limits]

    def backbone(x):
        return sum(k * min(x, e) for k, e in zip(stiffness, most, strict=True))

    reach = 0.6 * max(most)
    times = np.linspace(0.05, 0.95, 10)
    first = sf.simulate(imposed(law, reach, 1.0, {"mu": sf.Samples(MU, times)}), 1e-12)
    assert first["mu"] == pytest.approx([backbone(reach * t) for t in times], rel=1e-10)
    turned = sf.simulate(
        imposed(law, reach * sp.cos(T), 1.5 * np.pi, {"mu": sf.Samples(MU, np.linspace(1.7, 4.6, 15))}), 1e-12
    )
    for t, mu in zip(np.linspace(1.7, 4.6, 15), turned["mu"], strict=True):
        x = reach * np.sin(t)
        assert mu == pytest.approx(backbone(reach) - 2 * backbone((reach - x) / 2), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("n", longer([10, 40], [40]))
@pytest.mark.parametrize("reach", longer([0.7, 0.2], [0.2]))
def test_iwan_has_the_stated_error(n, reach):
    R, chi, phi_max = 1.0, -0.5, 1.0
    law = sf.laws.iwan(R, chi, phi_max, elements=n)
    assert float(law.stiffness) == pytest.approx(R * phi_max ** (chi + 1) / (chi + 1), rel=1e-12)
    assert law(1.0) == pytest.approx(sf.theory.presliding.iwan_backbone(R, chi, phi_max, 2.0), rel=1e-12)
    motion = reach * sp.cos(T)
    heat = [sf.simulate(imposed(law, motion, c * PERIOD, {"heat": HEAT}), 1e-11)["heat"] for c in (1.25, 2.25)]
    exact = sf.theory.presliding.iwan_dissipation(R, chi, reach)
    bound = (chi + 3) * (1 / 3 + (chi + 2) / 2) * phi_max / (n**2 * reach)
    assert abs(heat[1] - heat[0] - exact) <= bound * exact
    assert abs(heat[1] - heat[0] - exact) >= 1e-3 * bound * exact  # the bound is not idle


def test_iwan_closed_forms_against_quadrature():
    R, chi, top = 1.3, -0.4, 0.8
    for x in (0.3, 0.8, 2.0):
        force = quad(lambda p, x=x: R * p**chi * min(p, x), 0, top, points=[min(x, top)], epsabs=1e-12)[0]
        assert sf.theory.presliding.iwan_backbone(R, chi, top, -x) == pytest.approx(-force, rel=1e-8)
    loop = quad(lambda p: 4 * R * p ** (chi + 1) * (0.5 - p), 0, 0.5)[0]
    assert sf.theory.presliding.iwan_dissipation(R, chi, 0.5) == pytest.approx(loop, rel=1e-9)
    assert sf.theory.presliding.iwan_dissipation(1.0, -0.5, 0.7) == pytest.approx(0.43729430720181, rel=1e-13)


@pytest.mark.parametrize("chi", [-1.0, -1.5, -3.0])
def test_densities_of_infinite_stiffness_are_refused(chi):
    """The stiffness at rest is R phi_max^(chi + 1)/(chi + 1), infinite from chi = -1 on."""
    with pytest.raises(sf.SceneError, match="above -1"):
        sf.theory.presliding.iwan_backbone(1.0, chi, 1.0, 0.5)
    with pytest.raises(sf.SceneError, match="above -1"):
        sf.theory.presliding.iwan_dissipation(1.0, chi, 0.5)
    with pytest.raises(sf.SceneError, match="above -1"):
        sf.laws.iwan(1.0, chi, 1.0)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("start", [0.0, 1.0])  # with 0, two sliders return to their limits at one time
def test_sensitivities_through_yielding_and_reversal(start):
    law = sf.laws.maxwell_slip([K, 20.0], [L, 0.2])
    scene = belt(law, {K: 30.0, L: 0.15}, horizon=25.0, end=sf.End(), top=sf.Max(X)).starting({"x": start})
    run = sf.simulate(scene, 1e-12, sensitivities=["v_b", "k", "l", "belt.z1"])
    assert run.stats["events"] >= 8
    for name, step in (("v_b", 1e-6), ("k", 1e-4), ("l", 1e-6)):
        at = scene.numbers()[scene.parameter(name)]
        sides = [sf.simulate(scene.where({name: at + d}), 1e-13) for d in (step, -step)]
        slope = (sides[0].final - sides[1].final) / (2 * step)
        assert run.sensitivities[name] == pytest.approx(slope, rel=1e-5, abs=1e-7)
        top = (sides[0]["top"] - sides[1]["top"]) / (2 * step)
        assert run.output_sensitivities["top"][name] == pytest.approx(top, rel=1e-4, abs=1e-8)


def test_forced_cycle_of_a_joint_and_its_resonance():
    law = sf.laws.maxwell_slip([0.3, 0.2], [0.1, 0.3])
    system = sf.System([X], [U], [[1]], [-X - U / 20 + A * sp.cos(W * T)])
    scene = sf.Scene(system, [sf.Contact("joint", U, 1, law)], {A: 0.3, W: 1.1}, {X: 0.0, U: 0.0}, 200.0)
    cycle = sf.limit_cycle(scene)
    run = sf.simulate(scene.until(600.0).wanting({"x": sf.Samples(X, np.linspace(560, 600, 4000))}))
    assert cycle.stable
    assert cycle.x_max[0] == pytest.approx(np.max(run["x"]), rel=1e-4)


def test_many_cases_at_once_are_single_runs():
    program = sf.prepare(belt(sf.laws.iwan(1.0, -0.5, 0.2, 5), end=sf.End()))
    batch = program.map(values={"v_b": [0.1, 0.2, 0.3]})
    for k, v in enumerate((0.1, 0.2, 0.3)):
        assert np.array_equal(batch.final[:, k], program.run({"v_b": v}).final)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("n", "beta", "gamma"), [(1, 60.0, 40.0), (2, 300.0, 100.0), (1.5, 80.0, 80.0), (3, 50.0, -20.0)]
)
def test_bouc_wen(n, beta, gamma):
    law = sf.laws.bouc_wen(30.0, beta, gamma, n)
    slow = sf.simulate(imposed(law, 1, 2.0, {"mu": sf.Samples(MU, [1e-6, 2.0])}), 1e-12)
    assert slow["mu"][0] == pytest.approx(1e-6 * float(law.stiffness), rel=2e-3)
    assert slow["mu"][1] == pytest.approx(law(1.0), rel=1e-9) == pytest.approx((30 / (beta + gamma)) ** (1 / n))
    scene = belt(law, horizon=10.0, end=sf.End(), low=sf.Min(sf.dissipated_power("belt")))
    run = sf.simulate(scene, 1e-11)

    def field(t, y):
        w, z = y[1] - 0.2, y[2]
        rate = 30 * w - beta * abs(w) * abs(z) ** (n - 1) * z - gamma * w * abs(z) ** n
        return [y[1], -y[0] - y[1] / 10 - z, rate]

    plain = solve_ivp(field, (0, 10), np.zeros(3), method="DOP853", rtol=1e-11, atol=1e-13, max_step=0.01)
    assert run.final == pytest.approx(plain.y[:, -1], abs=1e-7)
    assert run["low"] >= -1e-12
    assert law.memory.passive >= 0


def test_bouc_wen_that_is_not_passive_gives_energy_back():
    law = sf.laws.bouc_wen(30.0, -20.0, 60.0, 1)
    assert law.memory.passive < 0
    scene = imposed(law, sp.cos(T) / 10, 2 * PERIOD, {"low": sf.Min(sf.dissipated_power("floor"))})
    assert sf.simulate(scene)["low"] < 0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sf.laws.maxwell_slip([1.0], [0.1, 0.2]), "1 stiffnesses and 2 limits"),
        (lambda: sf.laws.maxwell_slip([], []), "0 stiffnesses"),
        (
            lambda: sf.laws.maxwell_slip([1.0, -1.0], [0.1, 0.2]),
            r"stiffness\[1\] of maxwell_slip is -1; it must be positive",
        ),
        (lambda: sf.laws.iwan(1.0, -1.5, 1.0), "chi of iwan is -1.5.*above -1"),
        (lambda: sf.laws.iwan(1.0, -0.5, 1.0, elements=0), "elements of iwan is 0"),
        (lambda: sf.laws.bouc_wen(1.0, 1.0, -2.0, 1), "beta . gamma of bouc_wen is -1"),
        (lambda: sf.laws.bouc_wen(1.0, 1.0, 1.0, 0.5), "n of bouc_wen is 0.5"),
        (
            lambda: sf.Contact("c", U, 1, sf.laws.dahl(0.3, 10.0), stiffness=2.0),
            "only Coulomb's law with one coefficient",
        ),
    ],
)
def test_bad_input_in_one_line(make, words):
    with pytest.raises(sf.SceneError, match=words):
        make()
