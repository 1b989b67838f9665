"""Values of every law from noisy records, and what exact derivatives save."""

import time

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import least_squares, minimize

import symfric as sf

X, U = sp.symbols("x u", real=True)
A, B, C, V_B = sp.symbols("a b c v_b", positive=True)
T = np.linspace(0.0, 60.0, 301)[1:]
LAWS = {  # a law, its values, and the speed of the belt
    "coulomb": (sf.laws.coulomb(A, B), {"a": 0.4, "b": 0.25}, 0.2),
    "stribeck": (sf.laws.stribeck(A, B, C), {"a": 0.4, "b": 0.25, "c": 0.1}, 0.2),
    "lorentz": (sf.laws.lorentz(A, B, C), {"a": 0.25, "b": 0.1, "c": 0.4}, 0.2),
    "gauss": (sf.laws.gauss(A, B, C), {"a": 0.25, "b": 0.2, "c": 0.4}, 0.2),
    "square_root": (sf.laws.square_root(A, -B, C), {"a": 0.35, "b": 0.2, "c": 0.4}, 0.2),
    "cubic": (sf.laws.cubic(A, B, C), {"a": 0.4, "b": 0.25, "c": 0.5}, 0.2),
    "exponential": (sf.laws.exponential(A, B), {"a": 0.3, "b": 0.3}, 0.2),
    "dahl": (sf.laws.dahl(A, B), {"a": 0.3, "b": 3.0}, 0.3),
    "lugre": (sf.laws.lugre(A, B, C, 100.0, 1.0), {"a": 0.4, "b": 0.25, "c": 0.1}, 0.2),
    "bouc_wen": (sf.laws.bouc_wen(A, B, C, 1), {"a": 3.0, "b": 8.0, "c": 2.0}, 0.3),
    "elasto_plastic": (
        sf.laws.elasto_plastic(A, B, C, 100.0, 1.0, z_ba=B / 200),
        {"a": 0.4, "b": 0.25, "c": 0.1},
        0.2,
    ),
    "maxwell_slip": (sf.laws.maxwell_slip([A, 1.0], [B, C]), {"a": 3.0, "b": 0.15, "c": 0.2}, 0.3),
    "iwan": (sf.laws.iwan(A, -0.5, B, elements=6), {"a": 1.0, "b": 0.3}, 0.3),
    "rate_and_state": (sf.laws.rate_and_state(A, 0.02, B, C, 0.1), {"a": 0.3, "b": 0.05, "c": 0.05}, 0.2),
}


SHORT = {"rate_and_state": 20.0}  # how long the record of a law is that takes more time to integrate


def rig(law, values, speed):
    belt = sf.Contact("belt", U - V_B, 1, law)
    system = sf.System([X], [U], [[1]], [-X - U / 20])
    return sf.Scene(system, [belt], {**values, "v_b": speed}, {X: 0.0, U: 0.0}, 60.0)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["coulomb", "dahl"])
def test_a_law_gives_back_its_values(name):
    within, _ = coverage(name, 2)
    assert within == 2


@pytest.mark.long(beside="test_a_law_gives_back_its_values")
@pytest.mark.parametrize("name", LAWS)
def test_every_law_gives_back_its_values(name):
    """With noise of 1 %, within three standard errors in 95 of 100 records, and in the intervals as often as they say."""
    within, share = coverage(name, 100)
    assert within >= 95
    assert abs(share - 0.95) < 3 * np.sqrt(0.95 * 0.05 / 100)


def coverage(name, seeds):
    """Return how many fits lie within three standard errors, and how often intervals of 95 % hold the value."""
    law, values, speed = LAWS[name]
    scene = rig(law, values, speed)
    t = T[T <= SHORT.get(name, T[-1])]
    clean = sf.simulate(scene, 1e-10)(t)[0]
    noise = 0.01 * np.std(clean)
    bounds = {n: (0.3 * v, 3 * v) for n, v in values.items()}
    within, held = 0, 0
    for seed in range(seeds):
        y = clean + noise * np.random.default_rng([list(LAWS).index(name), seed]).standard_normal(t.size)
        fit = sf.identify(scene, {"x": (t, y)}, bounds, starts=1)
        off = {n: abs(fit.values[n] - v) / fit.standard_errors[n] for n, v in values.items()}
        within += all(o < 3 for o in off.values())
        held += sum(fit.interval(n)[0] < v < fit.interval(n)[1] for n, v in values.items())
    share = held / (seeds * len(values))
    print(f"{name}: {within} of {seeds} within three standard errors, intervals of 95 % hold {100 * share:.0f} %")
    return within, share


@pytest.mark.long(beside="test_a_law_gives_back_its_values")
def test_what_exact_derivatives_save():
    """The same problem from the same start by exact derivatives, by differences and without derivatives."""
    law, values, speed = LAWS["stribeck"]
    scene = rig(law, values, speed)
    y = sf.simulate(scene, 1e-10)(T)[0] + 0.005 * np.random.default_rng(0).standard_normal(T.size)
    begin = {"a": 0.42, "b": 0.24, "c": 0.11}
    start = scene.where(begin)
    bounds = {n: (0.5 * v, 2 * v) for n, v in values.items()}
    best = sf.identify(start, {"x": (T, y)}, bounds, starts=1)
    names = list(values)
    program = sf.prepare(start.wanting({"x": sf.Samples(X, T)}), 1e-10)
    runs = 0

    def rest(v):
        nonlocal runs
        runs += 1
        return program.run(dict(zip(names, v, strict=True)))["x"] - y

    lines = []
    for word in ("exact derivatives", "differences", "Nelder and Mead"):
        runs, clock = 0, time.process_time()
        if word == "exact derivatives":
            found = sf.identify(start, {"x": (T, y)}, bounds, starts=1)
            reached, runs = found.vector, found.evaluations
        elif word == "differences":
            low, high = np.array(list(bounds.values())).T
            reached = least_squares(
                rest, list(begin.values()), bounds=(low, high), xtol=1e-12, ftol=1e-12, gtol=1e-12
            ).x
        else:
            options = {"xatol": 1e-10, "fatol": 1e-14, "maxfev": 4000, "maxiter": 4000}
            cost = lambda v: 0.5 * np.sum(rest(v) ** 2)  # noqa: E731
            reached = minimize(cost, list(begin.values()), method="Nelder-Mead", options=options).x
        off = np.max(np.abs(reached / best.vector - 1))
        lines.append((word, runs, 1e3 * (time.process_time() - clock), off))
        print(f"{word}: {runs} runs, {lines[-1][2]:.0f} ms of CPU, values off by {off:.1e}")
    assert lines[0][1] < lines[1][1] < lines[2][1]
    assert lines[0][3] < 1e-9
