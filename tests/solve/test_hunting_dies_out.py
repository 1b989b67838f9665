"""A stage whose hunting dies out: the integrator comes ever closer to the static limit, down to rounding."""

import pytest

import symfric as sf

GAINS = [  # m, k_p, k_d, k_i, N, law
    (40, 4e4, 1.5e3, 2e5, 400, sf.laws.stribeck(0.14, 0.09, 0.012)),
    (40, 4e4, 3e3, 1e5, 400, sf.laws.stribeck(0.14, 0.09, 0.012)),
    (1, 40, 20, 60, 1, sf.laws.stribeck(0.4, 0.3, 0.5)),
    (1, 40, 20, 60, 1, sf.laws.coulomb(0.4)),
    (5, 1e3, 2e2, 3e3, 50, sf.laws.lorentz(0.1, 0.05, 0.13)),
]


def stage(m, k_p, k_d, k_i, N, law, **wanted):
    scene = sf.scenes.positioning_stage(law, m=m, k_p=k_p, k_d=k_d, k_i=k_i, N=N)
    return scene.until(60.0).wanting(wanted or {"end": sf.End()})


@pytest.mark.one_in(9)
@pytest.mark.parametrize("gains", GAINS, ids=lambda g: f"m={g[0]}, k_d={g[2]:g}, {g[5].source.split(' ')[0]}")
@pytest.mark.parametrize("tolerance", [1e-7, 1e-9, 1e-12])
def test_the_stage_comes_to_rest(gains, tolerance):
    run = sf.simulate(stage(*gains), tolerance)
    assert run.status == 0
    assert run.t_final == 60.0
    assert abs(run.final[0]) < (1e-9 if gains[0] == 40 else 1e-3)
    assert abs(gains[3] * run.final[2]) <= gains[4] * float(gains[5].stick) * (1 + 1e-9)
    assert run.stats["events"] < 1000


@pytest.mark.one_in(2)
@pytest.mark.parametrize("gains", GAINS[:3], ids=lambda g: f"m={g[0]}, k_d={g[2]:g}")
def test_while_it_hunts_another_integrator_agrees(gains):
    scene = stage(*gains).until(2.0)
    run, other = sf.simulate(scene, 1e-11), sf.simulate(scene, 1e-11, route="integrators")
    assert run.stats["events"] == other.stats["events"]
    assert run.final == pytest.approx(other.final, abs=1e-8)
