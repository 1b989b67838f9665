"""Branches of limit cycles: corners, folds, tori and their curves, against closed forms, known numbers and simulation."""

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import symfric as sf
from tests.orbits.test_cycle import non_stop, shaken

ONSET = 0.39579028879783  # of sticking, Thomsen's belt
BELT = sf.scenes.mass_on_belt(v_b=0.2)


@pytest.fixture(scope="module")
def belt():
    return sf.continue_cycle(BELT, "v_b", (0.01, 0.6))


def kinds(branch):
    return [s.kind for s in branch.special]


def test_the_whole_branch_of_the_belt(belt):
    assert belt.ends == ("span", "hopf")
    assert kinds(belt) == ["stick-onset", "hopf"]
    assert belt.reasons[1] == f"the Hopf point at v_b = {belt.special[1].value:.6g}"
    assert belt.special[0].value == pytest.approx(ONSET, abs=1e-12)
    assert belt.special[1].value == pytest.approx(sf.theory.belt.onset_speed(BELT), rel=1e-12)
    assert belt.values[0] == 0.01
    assert np.all(np.diff(belt.values) > -1e-12)
    assert all(o.stable for o in belt.orbits)
    sticks = np.array([o.stick_fraction > 0 for o in belt.orbits])
    assert np.array_equal(sticks, belt.values < ONSET)
    assert 100 < len(belt.orbits) < 400


def test_orbits_of_a_branch_are_those_found_alone(belt):
    for k in (0, 40, len(belt.orbits) - 30):
        alone = sf.limit_cycle(BELT.where({"v_b": belt.values[k]}), guess=belt.orbits[k])
        assert alone.period == pytest.approx(belt.orbits[k].period, rel=1e-10)
        assert np.allclose(alone.half_range, belt.orbits[k].half_range, rtol=1e-9)
        assert belt.orbits[k].scene.values[BELT.parameter("v_b")] == belt.values[k]


def test_the_branch_from_the_hopf_point(belt):
    hopf = sf.hopf(BELT, "v_b", (0.3, 0.6))
    branch = sf.continue_cycle(BELT, "v_b", (0.01, 0.6), start=hopf)
    assert branch.ends == ("hopf", "span")
    assert kinds(branch) == ["hopf", "stick-onset"]
    assert branch.reasons[0] == f"the Hopf point at v_b = {hopf.value:.6g}"
    assert branch.special[1].value == pytest.approx(ONSET, abs=1e-12)
    first = branch.orbits[0]
    growth = hopf.value - branch.values[0]  # r^2 = -sigma/a near the point, sigma from the eigenvalues
    step = 1e-6
    rates = [np.max(sf.stability(BELT.where({"v_b": hopf.value + d})).eigenvalues.real) for d in (-step, step)]
    slope = (rates[1] - rates[0]) / (2 * step)
    assert first.half_range[0] ** 2 == pytest.approx(slope * growth / hopf.first_lyapunov, rel=0.01)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("beta", [0.05, 0.1])
def test_exponential_law_has_an_unstable_cycle(beta):
    scene = sf.scenes.mass_on_belt(sf.laws.exponential(0.4, 1.0), v_b=1.0, beta=beta)
    hopf = sf.hopf(scene, "v_b", (0.05, 6.0))
    assert hopf.kind == "subcritical"
    assert hopf.value == pytest.approx(-np.log(2 * beta / 0.4), rel=1e-12)
    branch = sf.continue_cycle(scene, "v_b", (0.05, 6.0), start=hopf)
    assert kinds(branch) == ["hopf", "stick-onset", "fold"]
    fold = branch.special[2].value
    assert fold == branch.special[1].value > hopf.value
    corner = int(np.argmax(branch.values))
    assert not any(o.stable for o in branch.orbits[: corner - 1])
    assert all(o.stable and o.stick_fraction > 0 for o in branch.orbits[corner + 1 :])
    middle = 0.5 * (hopf.value + fold)
    between = int(np.argmin(np.abs(branch.values[:corner] - middle)))
    unstable = branch.orbits[between]
    outer = sf.limit_cycle(scene.where({"v_b": branch.values[between]}).starting({"x": 3.0}))
    assert outer.half_range[0] > unstable.half_range[0]
    centre = np.array(sf.equilibrium(unstable.base.where(unstable.values)).x)
    final = sf.prepare(unstable.scene.until(3000.0).wanting({"end": sf.End()}), 1e-11)
    for share, settles in ((0.99, True), (1.01, False)):  # bistability: just inside and just outside the unstable cycle
        start = centre + share * (unstable.start - centre)
        end = final.run(initial=dict(zip(unstable.names, start, strict=True))).final
        assert (np.linalg.norm(end - centre) < 1e-3 * np.linalg.norm(unstable.half_range)) == settles


def test_beyond_the_fold_there_is_only_steady_sliding():
    scene = sf.scenes.mass_on_belt(sf.laws.exponential(0.4, 1.0), v_b=0.77, beta=0.1, horizon=400.0)
    with pytest.raises(sf.NotFound, match="settles"):
        sf.limit_cycle(scene.starting({"x": 3.0}))


@pytest.fixture(scope="module")
def fast():
    scene = sf.scenes.mass_on_belt(v_b=0.45, a=0.01, Omega=20.0, horizon=300.0)
    return sf.continue_cycle(scene, "v_b", (0.195, 0.5))


def test_bounds_of_figure_9_on_the_branch(fast):
    lower = next(s for s in fast.special if s.kind in ("stick-onset", "grazing") and s.value > 0.2)
    upper = next(s for s in fast.special if s.kind == "neimark-sacker")
    assert lower.value == pytest.approx(0.20048269538877, abs=1e-12)
    assert upper.value == pytest.approx(0.41754591255332, abs=1e-12)
    inside = (fast.values > lower.value) & (fast.values < upper.value)
    stable = np.array([o.stable for o in fast.orbits])
    assert not np.any(stable[inside])
    assert np.all(stable[fast.values > upper.value])


@pytest.mark.parametrize(("v_b", "grows"), [(0.40, True), (0.43, False)])
def test_multipliers_of_the_forced_orbit_tell_what_disturbances_do(v_b, grows):
    """A second method: follow a small disturbance over many periods."""
    scene = sf.scenes.mass_on_belt(v_b=v_b, a=0.01, Omega=20.0)
    orbit = sf.limit_cycle(scene, guess=([0.26, -0.2], 2 * np.pi / 20))
    assert orbit.stable is not grows
    program = sf.prepare(scene.until(200 * orbit.period).wanting({"end": sf.End()}), 1e-13)
    ends = [program.run(initial={"x": orbit.start[0] + d, "u": orbit.start[1]}).final for d in (0.0, 1e-6)]
    growth = np.log(np.linalg.norm(ends[1] - ends[0]) / 1e-6)
    assert growth == pytest.approx(100 * np.log(abs(np.prod(orbit.multipliers))), abs=0.1)  # half of it for each


@pytest.mark.long(beside="test_bounds_of_figure_9_on_the_branch")
def test_bounds_of_figure_9_as_curves(fast):
    spans = ((10.0, 40.0), (0.02, 0.6))
    lower = next(s for s in fast.special if s.kind == "stick-onset" and s.value > 0.2)
    curve = sf.continue_special(lower, ("Omega", "v_b"), spans)
    assert curve.ends == ("span", "span")
    assert curve.at(20.0) == pytest.approx([0.20048269538877], abs=1e-12)
    assert curve.at(30.0) == pytest.approx([0.30032749601118], abs=1e-12)
    upper = next(s for s in fast.special if s.kind == "neimark-sacker")
    torus = sf.continue_special(upper, ("Omega", "v_b"), spans)
    assert torus.at(20.0) == pytest.approx([0.41754591255332], abs=1e-10)
    assert torus.at(30.0) == pytest.approx([0.38645224271385], abs=1e-10)
    assert torus.at(40.0).size == 0  # quenched: the two curves have met
    assert sorted(torus.ends) == ["grazing", "span"]
    meeting = torus.values[:, -torus.ends.index("grazing")]
    assert curve.at(meeting[0]) == pytest.approx([meeting[1]], rel=2e-3)
    onset = sf.theory.belt.onset_speed(BELT)
    orbit = torus.orbit(int(np.argmin(np.abs(torus.values[0] - 15.0))))  # v_b^2 + <x'^2> = v_b1^2 on every orbit of it
    u = orbit.scene.system.u[0]
    mean = sf.simulate(orbit.scene.wanting({"s": sf.Integral(u**2)}), 1e-12)["s"] / orbit.period
    values = {s.name: v for s, v in orbit.scene.values.items()}
    assert values["v_b"] ** 2 + mean == pytest.approx(onset**2, rel=1e-9)


@pytest.mark.long(beside="test_grazing_of_two_slides")
def test_boundary_of_non_stop_motion():
    branch = sf.continue_cycle(shaken(0.7, 0.2), "f", (0.05, 0.95))
    onset = next(s for s in branch.special if s.kind == "stick-onset")
    curve = sf.continue_special(onset, ("b", "f"), ((0.55, 0.9), (0.02, 0.99)))
    for b in (0.6, 0.7, 0.85):
        (found,) = curve.at(b)
        V, W = 1 / (1 - b**2), np.sin(np.pi / b) / (b * (1 + np.cos(np.pi / b)))

        def rest(f, b=b, V=V):  # at the turn the load just carries the mass on: cos(b t) = a - f there, Den Hartog
            a = non_stop(b, f)
            return a / V - (a - f)

        assert found == pytest.approx(brentq(rest, 0.05, 0.999 * abs(V / W)), rel=1e-9)


def test_grazing_of_two_slides():
    scene = sf.scenes.two_slides(r=0.5, zeta=2.0, s1=0.2, s2=0.3, fc1=1.0, fs1=7.8, horizon=400.0)
    branch = sf.continue_cycle(scene, "fs1", (6.0, 9.0))
    assert branch.ends == ("grazing", "span")
    (grazing,) = branch.special
    assert grazing.value == pytest.approx(7.742901728076077, abs=1e-9)
    curve = sf.continue_special(grazing, ("s2", "fs1"), ((0.25, 0.4), (2.0, 20.0)))
    assert sorted(curve.ends) == ["grazing", "span"]  # where another part of the slip touches zero as well
    for s2 in (0.28, 0.3, 0.32):
        theory = sf.theory.drive.two_slides_threshold(r=0.5, zeta=2.0, s1=0.2, s2=s2)
        assert curve.at(s2) == pytest.approx([theory], rel=1e-9)


def test_a_branch_does_not_run_along_one_orbit():
    """In kg, m, s and N the velocities are hundreds of times the coordinates, and the accelerations of the velocities."""
    m, k, v, stribeck = 400.0, 2e7, 0.004, sf.laws.stribeck(0.14, 0.09, 0.012)
    x, u = sp.symbols("x u", real=True)
    c = sp.Symbol("c", positive=True)
    scene = sf.Scene(
        system=sf.System(q=[x], u=[u], mass=[[m]], force=[-k * x - c * u]),
        contacts=[sf.Contact("guideway", slip=u - v, normal=4000.0, law=stribeck)],
        values={c: 3e3},
        initial={x: 0.0, u: 0.0},
        horizon=1.0,
    )
    branch = sf.continue_cycle(scene, "c", (1e3, 4e4))
    _, fold, end = branch.special
    assert [s.kind for s in branch.special] == ["stick-onset", "fold", "hopf"]
    assert branch.ends == ("span", "hopf")
    assert end.value == pytest.approx(4000 * 0.05 / 0.012 * np.exp(-v / 0.012), rel=1e-9)
    assert np.max(branch.values) == pytest.approx(fold.value, rel=1e-3)
    assert np.max(branch.values) <= fold.value
    assert np.all(np.diff([o.half_range[0] for o in branch.orbits]) < 0)  # none is met twice
    assert sf.limit_cycle(scene.where({"c": 0.999 * fold.value})).stick_fraction > 0
    with pytest.raises(sf.NotFound, match="settles"):
        sf.limit_cycle(scene.where({"c": 1.00001 * fold.value}))


def test_errors_and_manners(belt):
    with pytest.raises(sf.SceneError, match="did you mean v_b"):
        sf.continue_cycle(BELT, "v_bb", (0.1, 0.3))
    with pytest.raises(sf.SceneError, match="low < high"):
        sf.continue_cycle(BELT, "v_b", (0.3, 0.1))
    with pytest.raises(sf.SceneError, match="outside the span"):
        sf.continue_cycle(BELT, "v_b", (0.3, 0.5))
    with pytest.raises(sf.SceneError, match="Hopf point is one of steady sliding"):
        sf.continue_special(belt.special[1], ("v_b", "beta"), ((0.1, 0.5), (0.01, 0.1)))
    with pytest.raises(sf.SceneError, match="give two"):
        sf.continue_special(belt.special[0], ("v_b", "v_b"), ((0.1, 0.5), (0.01, 0.1)))
    assert repr(belt).startswith("Branch(v_b from 0.01 to 0.44")
    assert belt.to_dict()["special"][0]["kind"] == "stick-onset"
    assert belt.to_xarray()["half_range"].shape == (len(belt.orbits), 2)
    axes = belt.plot()
    assert {"stable", "stick-onset", "hopf"} <= {text.get_text() for text in axes.get_legend().get_texts()}


@pytest.mark.long(beside="test_the_whole_branch_of_the_belt")
def test_no_orbit_lies_outside_the_span():
    """The last orbit before the end of a span was corrected beyond it, for one of these spans."""
    x, u, F = *sp.symbols("x u", real=True), sp.Symbol("F", positive=True)
    force = F * sp.cos(sp.Rational(8, 5) * sf.TIME) - u * sp.Rational(3, 100) - x**3 / 10 - x
    contact = sf.Contact("c", u, 1, sf.laws.coulomb(0.24, 0.22))
    scene = sf.Scene(sf.System([x], [u], sp.Matrix([[1]]), [force]), [contact], {F: 0.5}, {x: 1, u: 0}, 60.0)
    start = sf.limit_cycle(scene)
    for high in np.linspace(0.52, 0.56, 41):
        branch = sf.continue_cycle(scene, F, (0.345, high), start=start)
        assert branch.ends == ("span", "span")
        assert (branch.values[0], branch.values[-1]) == (0.345, high)
        assert np.all(np.diff(branch.values) > 0)
