"""Uncertainty of a fit in which an unknown is at, near or far from its bound."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
MU_S, MU_K, C, K = sp.symbols("mu_s mu_k c k", positive=True)
T = np.linspace(0.2, 40.0, 150)
NOISE = 0.02
BOUNDS = {"mu_k": (0.1, 0.4), "c": (0.0, 0.3), "k": (0.8, 2.0)}
LAWS = {
    "coulomb": sf.laws.coulomb(MU_S, MU_K),
    "stribeck": sf.laws.stribeck(MU_S, MU_K, 0.2),
    "lugre": sf.laws.lugre(MU_S, MU_K, 0.2, 100.0, 1.0),
}
PLACES = {"at": 0.0, "near": 0.02, "far": 0.15}


def rig(law, c, v=0.15):
    belt = sf.Contact("belt", U - v, 1, LAWS[law])
    numbers = {MU_S: 0.42, MU_K: 0.3, C: c, K: 1.3}
    return sf.Scene(sf.System([X], [U], [[1]], [-K * X - C * U]), [belt], numbers, {X: 0.0, U: 0.0}, 40.0)


def fits(law, place, seeds):
    """Yield fits to noisy records of a law with damping at some place from its bound."""
    scene = rig(law, PLACES[place])
    clean = sf.simulate(scene, 1e-10)(T)[0]
    for seed in seeds:
        generator = np.random.default_rng([list(LAWS).index(law), list(PLACES).index(place), seed])
        y = clean + NOISE * generator.standard_normal(T.size)
        yield sf.identify(scene, {"x": (T, y)}, BOUNDS, starts=1)


def holds(fit, name, true):
    low, high = fit.interval(name)
    return low <= true <= high


@pytest.mark.long
def test_intervals_hold_the_truth_at_near_and_far_from_a_bound():
    """225 records of three laws: the share of 95 % intervals that hold the truth, for every place and every unknown."""
    held = {(place, name): [] for place in PLACES for name in BOUNDS}
    bound = dict.fromkeys(PLACES, 0)
    for law in LAWS:
        for place, c in PLACES.items():
            for fit in fits(law, place, range(25)):
                bound[place] += bool(fit.active)
                for name, true in (("mu_k", 0.3), ("c", c), ("k", 1.3)):
                    held[place, name].append(holds(fit, name, true))
            print(law, place, {n: sum(held[place, n]) for n in BOUNDS}, len(held[place, "c"]), bound, flush=True)
    shares = {key: float(np.mean(hits)) for key, hits in held.items()}
    print({k: round(v, 3) for k, v in shares.items()}, bound)
    assert bound["at"] > 20 > bound["far"]
    assert 0.92 <= np.mean(list(held.values())) <= 0.98
    for share in shares.values():  # of 75 records each
        assert share >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / 75)
