"""Models of isolators with nonlinear dampers and friction that depends on the speed, and the density for a table."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.theory import scaling

MOTION = sf.motions.sine_burst(3.0, 1.5, cycles=6)
PEAKS = ("peak_acceleration", "peak_velocity", "peak_displacement")
LAW = sf.laws.stribeck(1.0, 0.6, 0.1)
CELLS = (np.linspace(-0.2, 0.2, 9), np.array([0.02, 0.03, 0.02, 0.01, 0.02, 0.03, 0.02, 0.01]))


def returned(by, gravity="scaled", **prototype):
    """Ratios of the peaks of a model, converted to full scale, to those of the prototype."""
    given = {"C": 1e5, "m": 3e5, "motion": MOTION, "profile": 0.02, **prototype}
    model = sf.simulate(scaling.isolator_model(by, **given, gravity=gravity), 1e-11).checked()
    whole = sf.simulate(sf.scenes.rolling_isolator(**given), 1e-11).checked()
    kinds = (by.acceleration, by.velocity, by.length)
    return np.array([scaling.returned_ratio(model[p], whole[p], kind) for p, kind in zip(PEAKS, kinds, strict=True)])


@pytest.mark.one_in(24)
@pytest.mark.parametrize(
    "by", [scaling.factors(7), scaling.factors(10, mass=0.008163), scaling.factors(4, D=0.5)], ids=str
)
@pytest.mark.parametrize(
    "prototype",
    [
        {"alpha": 0.3},
        {"alpha": 0.7, "law": LAW},
        {"alpha": 1.5, "profile": (0.01, 0.05)},
        {"alpha": 2.0, "law": LAW, "profile": CELLS},
        {"alpha": 3.0},
        {"law": LAW},
        {"law": sf.laws.piecewise_linear(1.0, [0, 0.1, 0.3], [1.0, 0.7, 0.8])},
    ],
    ids=str,
)
def test_a_scaled_model_returns_the_prototype(by, prototype):
    np.testing.assert_allclose(returned(by, **prototype), 1.0, rtol=1e-7)


@pytest.mark.long(beside="test_a_scaled_model_returns_the_prototype")
def test_each_new_factor_is_needed():
    by = scaling.factors(7, D=2.8)
    assert by.damper(1) == pytest.approx(by.damping)
    assert by.damper(0.5) == pytest.approx(2.8**0.25 / 49)
    assert np.max(np.abs(returned(by, gravity="table") - 1)) > 0.05
    same = {"C": 1e5 * by.damping / by.damper(0.5), "alpha": 0.5}  # the factor of the linear damper
    whole = sf.simulate(sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=MOTION, profile=0.02, alpha=0.5))
    model = sf.simulate(scaling.isolator_model(by, m=3e5, motion=MOTION, profile=0.02, **same))
    assert abs(model["peak_displacement"] / whole["peak_displacement"] / by.length - 1) > 0.02
    slow = sf.laws.stribeck(1.0, 0.6, 0.1 / by.velocity)  # the speeds of the law not scaled
    whole = sf.simulate(sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=MOTION, profile=0.02, law=LAW))
    model = sf.simulate(scaling.isolator_model(by, C=1e5, m=3e5, motion=MOTION, profile=0.02, law=slow))
    assert abs(model["peak_displacement"] / whole["peak_displacement"] / by.length - 1) > 0.01


@pytest.mark.one_in(4)
@pytest.mark.parametrize("alpha", [0.5, 1.5, 2.0, 3.0])
def test_the_damper_against_another_integrator(alpha):
    C, m, mu, g, w0 = 1e5, 3e5, 0.02, 9.81, 1e-3
    scene = sf.scenes.rolling_isolator(C=C, m=m, motion=MOTION, profile=mu, alpha=alpha, rest_speed=w0)
    run = sf.simulate(scene, 1e-11).checked()
    t = np.arange(MOTION.samples.size) * MOTION.dt

    def damper(w):
        return C * w * (abs(w) ** (alpha - 1) if alpha % 2 == 1 else (w**2 + w0**2) ** ((alpha - 1) / 2))

    def field(s, y):
        friction = mu * m * g * np.tanh(y[1] / 1e-7)
        return y[1], -(damper(y[1]) + friction) / m - np.interp(s, t, MOTION.samples)

    found = solve_ivp(field, (0, t[-1]), [0, 0], "LSODA", rtol=1e-8, atol=1e-11, max_step=MOTION.dt, dense_output=False)
    assert run["peak_displacement"] == pytest.approx(np.max(np.abs(found.y[0])), rel=1e-4)
    assert run["peak_velocity"] == pytest.approx(np.max(np.abs(found.y[1])), rel=1e-4)


def test_the_speed_of_rest_does_not_matter():
    found = [
        sf.simulate(sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=MOTION, profile=0.02, alpha=0.3, rest_speed=low))
        for low in (1e-5, 1e-6)
    ]
    assert found[0]["peak_displacement"] == pytest.approx(found[1]["peak_displacement"], rel=1e-4)


@pytest.mark.long(beside="test_the_damper_against_another_integrator")
def test_an_isolator_with_a_nonlinear_damper_is_designed():
    scene = sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=MOTION, profile=0.02, alpha=0.5)
    found = sf.design.isolator(scene, [MOTION], {"C": (2e4, 3e5)}, limits={"displacement": 0.038})
    runs = [sf.simulate(scene.where({"C": C})) for C in (*np.geomspace(2e4, 3e5, 12), found.values["C"])]
    allowed = [r["peak_acceleration"] for r in runs if r["peak_displacement"] <= 0.038 * (1 + 1e-9)]
    assert found.objective == pytest.approx(min(allowed), rel=1e-6)
    assert runs[-1]["peak_displacement"] <= 0.038 * (1 + 1e-6)


def test_density_for_a_table():
    model = scaling.for_table(3e5, 0.008163 * 3e5)
    assert model.L == pytest.approx(0.008163**-0.5) == model.D
    assert model.L == pytest.approx(11.068, abs=1e-3)
    by = scaling.factors(model.L, D=model.D)
    assert by.acceleration == pytest.approx(1)
    assert by.mass * 3e5 == pytest.approx(model.mass) == 0.008163 * 3e5
    assert model.extra_mass == pytest.approx(model.mass - 3e5 / model.L**3)
    assert returned(by, gravity="table", alpha=0.7, law=LAW) == pytest.approx(1, rel=1e-7)  # on a real table
    small, large = scaling.for_table(3e5, 2449, L=20), scaling.for_table(3e5, 2449, L=7)
    assert (small.D, small.friction_distortion) == (20, 1)
    assert large.mass == pytest.approx(2449)
    assert large.friction_distortion == pytest.approx(scaling.factors(7, mass=2449 / 3e5).friction_distortion)
    assert scaling.for_table(100, 1e4) == (1, 1, 100, 0, 1)  # the table carries the prototype
    true = 0.02 / large.friction_distortion  # friction that makes up for gravity
    by = scaling.factors(7, D=large.D)
    table = sf.simulate(scaling.isolator_model(by, C=1e5, m=3e5, motion=MOTION, profile=true, gravity="table"))
    whole = sf.simulate(sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=MOTION, profile=0.02))
    assert table["peak_displacement"] / by.length == pytest.approx(whole["peak_displacement"], rel=1e-6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sf.scenes.rolling_isolator(C=1, m=1, motion=MOTION, profile=0.1, alpha=0), "alpha is 0"),
        (
            lambda: sf.scenes.rolling_isolator(C=1, m=1, motion=MOTION, profile=0.1, alpha=0.5, rest_speed=0),
            "rest_speed",
        ),
        (lambda: scaling.for_table(0, 1), "mass is 0"),
        (lambda: scaling.for_table(1, 1, L=0.5), "not larger than its prototype"),
        (
            lambda: scaling.isolator_model(scaling.factors(2), C=1, m=1, motion=MOTION, profile=0.1, gravity="moon"),
            "gravity is 'moon'",
        ),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(sf.SceneError, match=message):
        call()
