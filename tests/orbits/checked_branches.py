"""What a branch of masses with dry friction claims, against an event-driven simulation of SciPy's and settled motions."""

from typing import NamedTuple

import numpy as np

import symfric as sf
from tests.orbits.sliders import Sliders

NEUTRAL = 1e-3  # distance of a multiplier from the unit circle up to which stability is not judged
FACTS = ("fold", "flip", "neimark-sacker", "branch-point")


class Case(NamedTuple):
    """A family member, the parameter that is followed, its span, and values at which a cycle is sought."""

    own: Sliders
    name: str
    span: tuple
    starts: tuple


def law(r):
    mu_k = float(r.uniform(0.1, 0.4))
    return mu_k + float(r.uniform(0.05, 0.4)), mu_k, float(r.uniform(0.1, 0.6))


def one_mass(seed):
    r = np.random.default_rng([1, seed])
    own = Sliders(
        (1.0,), (float(r.uniform(0.5, 2)),), (float(r.uniform(0.01, 0.2)),), (float(r.uniform(0.3, 2)),), law(r)
    )
    return Case(own.at("v_b", 0.3), "v_b", (0.02, 1.2), (0.2, 0.1, 0.4, 0.6))


def two_masses(seed):
    r = np.random.default_rng([2, seed])
    pairs = [tuple(map(float, r.uniform(*ends, 2))) for ends in ((0.5, 2), (0.5, 2), (0.01, 0.15), (0.5, 1.5))]
    own = Sliders(*pairs, law(r), 0.3, float(r.uniform(0.2, 2)))
    return Case(own, "v_b", (0.02, 1.0), (0.2, 0.4, 0.1, 0.6))


def twins(seed):
    """Two identical masses: in phase they never stretch the spring between them."""
    r = np.random.default_rng([3, seed])
    twice = [2 * (float(r.uniform(*ends)),) for ends in ((1, 1.0001), (0.5, 2), (0.01, 0.15), (0.5, 1.5))]
    own = Sliders(*twice, law(r), 0.3, float(r.uniform(0.02, 1)))
    return Case(own, "v_b", (0.02, 1.0), (0.2, 0.4, 0.1, 0.6))


def forced(seed):
    r = np.random.default_rng([4, seed])
    own = Sliders((1.0,), (1.0,), (float(r.uniform(0.01, 0.2)),), (float(r.uniform(0.1, 0.8)),), law(r))
    holds, w = own.N[0] * own.law[0], float(r.uniform(0.3, 1.6))
    own = own.at("w", w).at("A", 2.0 * holds)
    if seed % 2:
        return Case(own, "w", (0.3, 1.8), (w,))
    return Case(own, "A", (0.9 * holds, 4.0 * holds), (2.0 * holds,))


def branch_of(case):
    """Return the branch from the first value at which the motion settles to a cycle; None if it does at none."""
    n = len(case.own.m)
    for value in case.starts:
        scene = case.own.at(case.name, value).scene(400.0, [0.1] * n + [0.0] * n if twin(case) else None)
        try:
            orbit = sf.limit_cycle(scene)
        except sf.NotFound:
            continue
        return sf.continue_cycle(scene, case.name, case.span, start=orbit)
    return None


def twin(case):
    own = case.own
    return len(own.m) == 2 and all(len(set(e)) == 1 for e in (own.m, own.k, own.c, own.N))


def own_multipliers(case, orbit):
    """Return the multipliers of an orbit by central differences of a simulation of SciPy's, the nearest to 1 first."""
    value = orbit.values.get(case.name, getattr(case.own, case.name))
    own, n, columns = case.own.at(case.name, value), orbit.start.size, []
    size = np.maximum(orbit.half_range, 1e-3)
    for k in range(n):
        step = 1e-5 * size * np.eye(n)[k]
        ends = [own.run(orbit.start + way * step, orbit.period, 1e-12)[0] for way in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2e-5 * size))
    found = np.linalg.eigvals((np.array(columns)).T)
    return found[np.argsort(np.abs(found - 1.0))]


def nontrivial(case, orbit):
    """Return the same without the one of the direction of motion."""
    return own_multipliers(case, orbit)[int(case.own.A == 0) :]


def off_fold(case, found):
    """Return how far multipliers are from those of a fold; two that are 1 are known by their sum and product only."""
    if case.own.A:
        return abs(found[0] - 1)
    return max(abs(found[0] + found[1] - 2), abs((found[0] - 1) * (found[1] - 1)))


def misclosed(case, orbit):
    """Return by how much an orbit does not close, relative to its ranges, and whether its sticks are others."""
    end, count = case.own.at(case.name, orbit.values[case.name]).run(orbit.start, orbit.period)
    sticks = [sum(e.contact == c and e.after == 0 for e in orbit.events) for c in "ab"[: len(count)]]
    # the simulation leaves a standstill with a speed of 1e-12, and has that absolute tolerance: a tenth of what is allowed
    size = np.maximum(orbit.half_range, 1e-5)
    return float(np.max(np.abs(end - orbit.start) / size)), count != sticks


def leading(orbit, forced):
    found = np.array(orbit.multipliers)
    if not forced:
        found = np.delete(found, int(np.argmin(np.abs(found - 1.0))))
    return float(np.max(np.abs(found))) if found.size else 0.0


def silent_changes(case, branch):
    """Return the values at which the stability changes along a branch without a special point."""
    silent, values = [], branch.values
    for k, (one, other) in enumerate(zip(branch.orbits[:-1], branch.orbits[1:], strict=True)):
        if one.stable == other.stable or min(abs(leading(o, case.own.A > 0) - 1) for o in (one, other)) < 1e-6:
            continue
        near = values[max(k - 2, 0) : k + 4]  # the point of a turn lies beyond the orbits
        wide = np.ptp(near) + 1e-9
        if not any(np.min(near) - wide <= s.value <= np.max(near) + wide for s in branch.special):
            silent.append((float(values[k]), float(values[k + 1])))
    return silent


def wrong_specials(case, branch):
    """Return the smooth special points whose multipliers, by the simulation, are not those of their kind."""
    wrong = []
    corners = {s.value for s in branch.special if s.kind not in FACTS}
    for point in branch.special:
        if point.kind not in FACTS or point.value in corners:
            continue
        found = own_multipliers(case, point.orbit)
        least = {
            "flip": np.min(np.abs(found + 1)),
            "neimark-sacker": np.min(np.abs(np.abs(found[found.imag != 0]) - 1), initial=9),
        }
        if least.get(point.kind, off_fold(case, found)) > 3e-3:
            wrong.append((point.kind, point.value, np.abs(found).tolist()))
    return wrong


def wrong_orbits(case, branch, rng, number=2):
    """Return what is wrong with some orbits of a branch: they do not close, stick otherwise, or have other multipliers."""
    wrong, judged = [], 0
    for k in rng.choice(len(branch.orbits), min(number, len(branch.orbits)), replace=False):
        orbit = branch.orbits[k]
        most = leading(orbit, case.own.A > 0)
        off, others = misclosed(case, orbit)
        if off > 1e-6 * max(1.0, most):
            wrong.append(("closes", orbit.values[case.name], off))
        if others:
            wrong.append(("sticks", orbit.values[case.name], off))
        if abs(most - 1) > NEUTRAL:
            own = nontrivial(case, orbit)
            judged += 1
            if (np.max(np.abs(own), initial=0.0) < 1) != orbit.stable:
                wrong.append(("stable", orbit.values[case.name], most, np.abs(own).tolist()))
    return wrong, judged


def orbits_at(case, branch, value):
    """Return the orbits of a branch at a value, next to each pair that encloses it."""
    found, scene = [], case.own.at(case.name, value).scene()
    for one, other in zip(branch.orbits[:-1], branch.orbits[1:], strict=True):
        a, b = one.values[case.name], other.values[case.name]
        if (a - value) * (b - value) > 0 or a == b:
            continue
        try:
            found.append(sf.limit_cycle(scene, guess=one if abs(a - value) < abs(b - value) else other))
        except sf.NotFound:
            continue
    return found


def settled(case, value, start, periods=150, period=2 * np.pi):
    """Return the half ranges of what the motion settles to, and the last state."""
    horizon = periods * period
    run = sf.simulate(case.own.at(case.name, value).scene(horizon, start))
    t = np.linspace(horizon - 12 * period, horizon, 6000)
    return 0.5 * np.ptp(np.asarray(run(t)), axis=-1), run(t)[:, -1]


def swept(case, branch, rng, number=4):
    """Compare settled motions, each from the last state of the one before, with the stable orbits of a branch.

    Returns the numbers of values at which both agree, at which the motion settles elsewhere, and the wrong ones: where
    no motion from beside an orbit that is said to be stable returns to it.
    """
    low, high = float(np.min(branch.values)), float(np.max(branch.values))
    counts, wrong, state = {"same": 0, "elsewhere": 0, "no stable": 0}, [], None
    for value in low + (high - low) * (np.arange(number) + rng.uniform(0.2, 0.8, number)) / number:
        stable = [o for o in orbits_at(case, branch, value) if o.stable and leading(o, case.own.A > 0) < 0.9]
        if not stable:
            counts["no stable"] += 1
            continue
        period = stable[0].period
        begin = stable[0].start + 1e-3 * stable[0].half_range if state is None else state
        size, state = settled(case, value, begin, 60, period)
        if any(np.allclose(size, o.half_range, rtol=1e-3, atol=1e-6) for o in stable):
            counts["same"] += 1
            continue
        counts["elsewhere"] += 1
        for orbit in stable:
            size, _ = settled(case, value, orbit.start + 1e-5 * orbit.half_range, 60, orbit.period)
            if not np.allclose(size, orbit.half_range, rtol=1e-3, atol=1e-6):
                wrong.append(("left", float(value), leading(orbit, case.own.A > 0)))
    return counts, wrong
