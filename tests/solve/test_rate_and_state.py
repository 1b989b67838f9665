"""Rate-and-state friction: velocity steps and the onset of instability in closed form, and ten earthquake cycles."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
V, K = sp.symbols("v_b k", positive=True)
A, B, D, V0, MU0 = 0.01, 0.015, 1e-5, 1e-6, 0.6
LAWS = {name: sf.laws.rate_and_state(MU0, A, B, D, V0, name) for name in ("aging", "slip")}
N, CRITICAL = 5e6, 5e6 * (B - A) / D


def fault(law="aging", stiffness=0.3, horizon=1000.0, **outputs):
    """A slider between a plate that moves at V0 and rock: a block of 1000 kg on 1 m^2, disturbed from steady sliding."""
    k = stiffness * CRITICAL
    system = sf.System([X], [U], [[1000.0]], [k * (V0 * sf.TIME - X)])
    start = {X: -MU0 * N / k, U: 1.05 * V0}
    return sf.Scene(system, [sf.Contact("fault", U, N, LAWS[law])], {}, start, horizon, outputs or {"end": sf.End()})


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("jump", [10.0, 0.1])
def test_a_step_of_velocity_in_closed_form(law, jump):
    """Slip at V0 for long, then at another speed, which a heavy body keeps."""
    speed, times = jump * V0, np.linspace(0.5, 20.0, 8) / jump
    contact = sf.Contact("fault", U, 1, LAWS[law])
    mu = {"mu": sf.Samples(-sf.friction_force("fault"), times)}
    scene = sf.Scene(sf.System([X], [U], [[1e20]], [0]), [contact], {}, {X: 0.0, U: speed}, times[-1], mu)
    slipped = speed * times / D
    age = 1 + (jump - 1) * np.exp(-slipped) if law == "aging" else np.exp(np.log(jump) * np.exp(-slipped))
    exact = MU0 + A * np.log(jump) + B * np.log(age / jump)
    run = sf.simulate(scene)
    assert run.route == "integrators"
    assert run["mu"] == pytest.approx(exact, rel=1e-7)
    assert LAWS[law](speed) == pytest.approx(MU0 + (A - B) * np.log(jump), rel=1e-12)


def test_the_logarithm_is_the_smooth_form_while_it_slips():
    contact = lambda law: sf.Contact("fault", U - V, N, law)  # noqa: E731
    system = sf.System([X], [U], [[1000.0]], [-2 * CRITICAL * X])
    plain = sf.laws.rate_and_state(MU0, A, B, D, V0, smooth=False)
    start = {X: -MU0 * N / (2 * CRITICAL), U: 0.1 * V0}
    ends = [
        sf.simulate(sf.Scene(system, [contact(law)], {V: -V0}, start, 5.0, {"end": sf.End()})).final
        for law in (LAWS["aging"], plain)
    ]
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)


@pytest.mark.parametrize("law", LAWS)
def test_steady_sliding_loses_stability_at_the_critical_stiffness(law):
    """Rice and Ruina (1983): k = N (b - a)/D (1 + m V^2/(N a D))."""
    mass, speed = 1e6, 1e-4
    system = sf.System([X], [U], [[mass]], [-K * X])
    start = {X: 0.0, U: 0.0, "fault.z": float(np.log(V0 / speed))}
    scene = sf.Scene(system, [sf.Contact("fault", U - V, N, LAWS[law])], {K: CRITICAL, V: speed}, start, 1.0)
    onset = sf.hopf(scene, "k", (0.5 * CRITICAL, 2 * CRITICAL))
    assert onset.value == pytest.approx(CRITICAL * (1 + mass * speed**2 / (N * A * D)), rel=1e-8)
    assert sf.stability(scene.where({"k": 1.05 * onset.value})).stable
    assert not sf.stability(scene.where({"k": 0.95 * onset.value})).stable


def test_the_route_is_chosen_and_explained():
    assert sf.explain(fault()).route == "integrators"
    assert "stiff" in sf.explain(fault()).answers["integrators"]


def test_friction_dissipates_and_energies_balance():
    scene = fault(horizon=1500.0, low=sf.Min(sf.dissipated_power("fault")), path=sf.Trajectory())
    run = sf.simulate(scene, 1e-7).checked()
    assert run["low"] >= 0
    assert abs(run.energy_residual()) < 1e-4


@pytest.mark.long(beside="test_friction_dissipates_and_energies_balance")
@pytest.mark.parametrize("law", LAWS)
def test_ten_earthquake_cycles_without_tuning(law):
    run = sf.simulate(fault(law, horizon=20000.0, path=sf.Trajectory()), 1e-7).checked()
    u = run.x[1]
    begins = run.t[1:][(u[1:] > 1e-2) & (u[:-1] <= 1e-2)]
    assert begins.size >= 10
    times = np.diff(begins)[2:]
    assert np.ptp(times) < 1e-2 * np.mean(times)
    assert u.max() > 1e7 * u.min() > 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"a": 0.0}, "a of rate_and_state is 0"),
        ({"D_c": -1.0}, "D_c of rate_and_state is -1"),
        ({"law": "ageing"}, "law of rate_and_state is 'ageing'; there are aging, slip"),
    ],
)
def test_bad_input_in_one_line(change, words):
    given = {"mu0": MU0, "a": A, "b": B, "D_c": D, "V0": V0} | change
    with pytest.raises(sf.SceneError, match=words):
        sf.laws.rate_and_state(**given)
