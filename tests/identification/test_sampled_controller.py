"""Records of a plant under a digital controller: friction, gains and dead time from position and command."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
K, D, T, tau, mu_s, mu_k, v_s = sp.symbols("K D T tau mu_s mu_k v_s", positive=True)
TRUE = {"K": 20.0, "D": 4.0, "T": 0.05, "tau": 0.02, "mu_s": 0.5, "mu_k": 0.3, "v_s": 0.1}
TIMES = np.linspace(0.02, 8.0, 400)  # many of them instants at which a command acts


def plant(**values):
    command = sf.Held("command", K * (sp.sin(sf.TIME) - x) - D * u, every=T, delay=tau)
    guide = sf.Contact("guide", u, 1, sf.laws.stribeck(mu_s, mu_k, v_s))
    system = sf.System([x], [u], [[1]], [command.symbol])
    given = {sp.Symbol(n, positive=True): v for n, v in {**TRUE, **values}.items()}
    return sf.Scene(system, [guide], given, {x: 0.0, u: 0.0}, 8.0, held=[command])


@pytest.fixture(scope="module")
def motion():
    return sf.simulate(plant(), 1e-12).checked()(TIMES)


def noisy(motion, seed):
    rng = np.random.default_rng(seed)
    spread = {"x": 1e-3, "command": 2e-2}
    return {
        n: (TIMES, motion[i] + s * rng.standard_normal(TIMES.size))
        for (n, s), i in zip(spread.items(), (0, 2), strict=True)
    }


@pytest.mark.one_in(3)
@pytest.mark.parametrize("names", [("mu_s", "mu_k", "v_s"), ("K", "D", "mu_k"), ("mu_k", "tau")])
def test_unknowns_come_back_within_their_errors(motion, names):
    bounds = {n: (0.5 * TRUE[n], 1.9 * TRUE[n]) for n in names}
    fit = sf.identify(plant(), noisy(motion, len(names)), bounds, starts=2)
    off = np.array([(fit.values[n] - TRUE[n]) / fit.standard_errors[n] for n in names])
    assert np.max(np.abs(off)) < 3.5
    assert all(fit.standard_errors[n] < 0.1 * TRUE[n] for n in names)
    assert fit.unidentifiable == ()


@pytest.mark.long(beside="test_derivatives_of_records_by_gains_and_dead_time")
def test_exact_records_give_exact_values_from_another_start(motion):
    records = {"x": (TIMES, motion[0]), "command": (TIMES, motion[2])}
    start = plant(K=14.0, mu_k=0.42)
    fit = sf.identify(start, records, {"K": (8, 40), "mu_k": (0.2, 0.6)}, starts=2)
    assert fit.values["K"] == pytest.approx(TRUE["K"], rel=1e-8)
    assert fit.values["mu_k"] == pytest.approx(TRUE["mu_k"], rel=1e-8)


def test_the_position_alone_tells_the_friction_without_knowing_the_command(motion):
    fit = sf.identify(plant(), {"x": noisy(motion, 7)["x"]}, {"mu_k": (0.1, 0.6), "mu_s": (0.2, 0.9)}, starts=2)
    assert abs(fit.values["mu_k"] - TRUE["mu_k"]) < 3.5 * fit.standard_errors["mu_k"]


def test_derivatives_of_records_by_gains_and_dead_time():
    times = TIMES[::10] + 0.004  # beside the instants, at which a record jumps with their time
    wanted = plant().wanting({"x": sf.Samples(x, times), "c": sf.Samples(sp.Symbol("command", real=True), times)})
    run = sf.simulate(wanted, 1e-12, sensitivities=("K", "tau", "T"))
    program = sf.prepare(wanted, 1e-12)
    for name, h in (("K", 1e-4), ("tau", 1e-6), ("T", 1e-7)):
        for output in ("x", "c"):
            ends = [program.run({name: TRUE[name] + s * h})[output] for s in (-1, 1)]
            slope = (ends[1] - ends[0]) / (2 * h)
            found = run.output_sensitivities[output][name]
            assert np.max(np.abs(found - slope)) < 1e-4 * max(1.0, np.max(np.abs(slope)))


def test_pieces_are_for_scenes_without_clocks(motion):
    with pytest.raises(sf.SceneError, match="segments is for scenes without held variables"):
        sf.identify(plant(), noisy(motion, 1), {"mu_k": (0.1, 0.6)}, segments=4)
