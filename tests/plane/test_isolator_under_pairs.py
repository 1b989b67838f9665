"""A sliding isolator under two components: speed-dependent friction by a second method, and recorded pairs.

The records beside the project hold one component of each station, so a pair is made of two stations of one earthquake
(for Northridge, of a component and the rotated record of another station). What is asked is how wrong it is to compute both
directions alone, each with the whole friction force.
"""

import math
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer
from tests.plane.plane_reference import Planar, Problem, Simulator, regularised

RECORDS = Path(__file__).parents[3] / "shared" / "ground_motions"
G, R, MU = 9.81, 1.5, 0.1
V = sf.SPEED


def smooth_shaking(duration, step, seed):
    """Return two signals, linear between samples, and the function of time that they are."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, duration + step / 2, step)
    waves = rng.uniform(2.0, 9.0, (2, 4)), rng.uniform(0.0, 6.0, (2, 4)), rng.uniform(0.4, 1.2, (2, 4))
    samples = [sum(a * np.sin(w * t + p) for w, p, a in zip(*(e[k] for e in waves), strict=True)) for k in (0, 1)]
    return [sf.Signal(s, step) for s in samples], lambda at: np.array([np.interp(at, t, s) for s in samples])


@pytest.mark.parametrize("horizon", longer([0.6, 1.5], [1.5]))
@pytest.mark.parametrize("seed", [3, pytest.param(8, marks=pytest.mark.long)])
def test_friction_that_rises_with_speed_by_two_other_methods(seed, horizon):
    """The law of sliding bearings, mu_max - (mu_max - mu_min) exp(-v/v_c) (Constantinou and others 1990)."""
    low, v_c = 0.4, 0.08
    signals, shaking = smooth_shaking(horizon, 0.1, seed)
    law = sf.laws.custom(1 - (1 - low) * sp.exp(-V / v_c), mu_s=low)
    scene = sf.scenes.friction_pendulum(R=R, mu=MU, m=1.0, motions=signals, law=law, horizon=horizon)
    run = sf.simulate(scene, tolerance=1e-12).checked()
    bearing = Planar(np.eye(2), G, MU * low, lambda v: MU * (1 - (1 - low) * math.exp(-v / v_c)))
    force = lambda t, q, u: -G / R * q - shaking(t)  # noqa: E731
    problem = Problem(lambda q: np.eye(2), force, (bearing,), np.zeros(4), horizon)
    other = Simulator(problem).run()
    assert run.final == pytest.approx(other.final, abs=1e-7)  # its steps cross the corners between samples
    apart = [np.max(np.abs(regularised(problem, eps, 1e-8) - run.final)) for eps in (1e-2, 1e-3)]
    assert 5 * apart[1] < apart[0] < 0.01


# peak and residual in m of a dish of 2 m: in the plane, both directions alone, then the residuals of both
FIGURES = {
    ("ChiChi1999_CHY028-N", "ChiChi1999_CHY080-N"): {
        0.03: (0.3856, 0.3701, 0.0097, 0.0071),
        0.06: (0.3106, 0.2787, 0.0174, 0.0359),
        0.1: (0.2793, 0.2859, 0.0339, 0.0216),
    },
    ("ChiChi1999_TCU052-N", "ChiChi1999_TCU101-N"): {
        0.03: (0.9112, 0.8974, 0.0082, 0.0148),
        0.06: (0.5807, 0.5857, 0.0103, 0.0094),
        0.1: (0.3827, 0.3828, 0.0831, 0.0839),
    },
    ("CapeMendocino1992_CPM000", "CapeMendocino1992_RIO270"): {
        0.03: (0.3158, 0.3143, 0.0014, 0.0076),
        0.06: (0.2523, 0.2522, 0.0167, 0.0163),
        0.1: (0.2066, 0.2065, 0.0114, 0.0201),
    },
    ("LomaPrieta1989_RSN753_CLS000", "LomaPrieta1989_RSN808_TRI000"): {
        0.03: (0.0853, 0.0851, 0.0034, 0.0148),
        0.06: (0.0995, 0.0996, 0.0187, 0.0155),
        0.1: (0.1008, 0.1008, 0.0226, 0.0226),
    },
    ("Northridge1994_ARL360", "Northridge1994_RSN1044_rotated"): {
        0.03: (0.3487, 0.3414, 0.0053, 0.0068),
        0.06: (0.2762, 0.2712, 0.0092, 0.0041),
        0.1: (0.1950, 0.1919, 0.0085, 0.0188),
    },
}
CASES = [(pair, mu) for pair, row in FIGURES.items() for mu in row]


def figures(files, mu=0.06):
    """Return peak and residual of the vector of displacement, in the plane and of both directions alone."""
    pair = [sf.motions.read_at2(next(RECORDS.glob(f"{name}.*"))) for name in files]
    end = max(m.signal().t_end for m in pair) + 20.0
    still, t = sf.Signal([0.0, 0.0], pair[0].dt), np.arange(0.0, end, 1e-3)
    found = []
    for motions in ((pair[0], pair[1]), (pair[0], still), (still, pair[1])):
        scene = sf.scenes.friction_pendulum(R=2.0, mu=mu, m=1.0, motions=motions, horizon=end)
        wanted = {**scene.outputs, "path": sf.Trajectory()}
        run = sf.simulate(scene.wanting(wanted)).checked()
        found.append((run["peak_displacement"], run["residual_x"], run["residual_y"], run(t)[:2]))
    alone = np.max(np.hypot(found[1][3][0], found[2][3][1]))
    return found[0][0], alone, math.hypot(*found[0][1:3]), math.hypot(found[1][1], found[2][2])


@pytest.mark.skipif(not RECORDS.is_dir(), reason="the folder shared/ground_motions is not beside this clone")
@pytest.mark.one_in(15)
@pytest.mark.parametrize(("pair", "mu"), CASES, ids=[f"{pair[1]}-{mu}" for pair, mu in CASES])
def test_how_wrong_both_directions_alone_are(pair, mu):
    assert figures(pair, mu) == pytest.approx(FIGURES[pair][mu], abs=1e-4)
    assert 0.89 < FIGURES[pair][mu][1] / FIGURES[pair][mu][0] < 1.03
