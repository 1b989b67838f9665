"""Random designs of all kinds, each beside better ones that were sought, full runs, and itself in other units.

``python -m tests.design.random_designs [COUNT]`` prints the table. What is sought here shares no search with the
package: random points around a design, at all distances, judged by runs of ready scenes or by closed forms.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

import symfric as sf

ROUNDING = 1e-6  # of an objective: gain that is none
SAME = 1e-5  # of an objective: change in other units that is none
ENDS = (1e-3, 1e3)
EDGES = {  # kinds that lie on the edge of what is allowed: their parameter, and how much more of it must do
    "damper": ("c", 0.02),
    "settling": ("c", 1e-5),
    "quench": ("a", 0.02),
    "positioning": ("sigma", 1e-3),
}


@dataclass
class Row:
    """What became of the designs of a kind."""

    kind: str
    number: int = 0
    none: int = 0
    statuses: dict = field(default_factory=dict)
    gap: float = 0.0
    better: int = 0
    violated: int = 0
    units: float = 0.0
    changed: int = 0
    words: list = field(default_factory=list)


@dataclass(frozen=True)
class Case:
    """A design, what a neighbour is worth, and the same question in other units.

    Attributes
    ----------
    design : callable
        ``(mass, length, time) -> Design``
    worth : callable
        ``values -> (objective, violation)`` in the units of the source, by runs or closed forms.
    unit : callable
        ``(mass, length, time) -> (unit of the objective)``
    bounds : dict of str to (float, float)
    """

    design: Callable
    worth: Callable
    unit: Callable | None
    bounds: dict
    sense: int = 1
    draws: int = 12


def law_of(draw, speed=1.0, free=True):
    """Return a random law; `speed` is the unit of speed."""
    mu, v = draw.uniform(0.2, 0.6), draw.uniform(0.1, 0.6) * speed
    kinds = [
        lambda: sf.laws.cubic(mu, mu * draw.uniform(0.5, 0.9), v),
        lambda: sf.laws.exponential(mu, v),
        lambda: sf.laws.stribeck(mu, mu * draw.uniform(0.5, 0.9), v),
        lambda: sf.laws.gauss(mu, v),
    ]
    return kinds[draw.integers(len(kinds))]()


def belt_in(units, law, beta=0.0, shaken=False):
    """Return a mass on a belt in units of mass, length and time; `law` takes the unit of speed."""
    M, L, T = units
    x, u = sp.symbols("x u", real=True)
    v_b, c, a, Omega = sp.symbols("v_b c a Omega", positive=True)
    force = -x * M / T**2 - c * u
    values = {v_b: 0.3 * L / T, c: beta * M / T}
    if shaken:
        force += M * a * Omega**2 * sp.sin(Omega * sf.TIME)
        values |= {a: 0.0, Omega: 20.0 / T}
    contact = sf.Contact("belt", slip=u - v_b, normal=M * L / T**2, law=law(L / T))
    return sf.Scene(sf.System([x], [u], [[M]], [force]), [contact], values, {x: 0.0, u: 0.0}, 100.0 * T)


def seeded(draw):
    """Return a law as a function of the unit of speed, the same law in all units."""
    seed = int(draw.integers(1 << 30))
    return lambda speed=1.0: law_of(np.random.default_rng(seed), speed)


def damper_case(draw):
    law, low = seeded(draw), draw.uniform(0.1, 0.4)
    speeds, limit = (low, low + draw.uniform(0.2, 0.8)), float(draw.choice([0.0, 0.0, draw.uniform(0.1, 0.4)]))

    def design(M, L, T):
        ends = tuple(v * L / T for v in speeds)
        return sf.design.damper(belt_in((M, L, T), law), "c", (0.0, 6.0 * M / T), ends, half_range=limit * L)

    def worth(values):
        worst = -1.0
        for v in [*np.linspace(*speeds, 5), values.get("v_b", speeds[0])]:  # and the one that is said to decide
            scene = belt_in((1, 1, 1), law).where({"v_b": v, "c": values["c"]})
            rest = sf.equilibrium(scene).x[0]
            for start in (rest + 8.0, rest + 1e-3):
                end = sf.simulate(scene.starting({"x": start}).until(5000.0).wanting({"e": sf.End()}), 1e-9).final
                late = scene.starting({"x": end[0], "u": end[1]}).until(40.0)
                size = sf.simulate(late.wanting({"s": sf.HalfRange(late.system.q[0])}), 1e-9)["s"]
                worst = max(worst, size / limit - 1 if limit else size - 2e-3)
        return values["c"], worst

    return Case(design, worth, lambda M, L, T: M / T, {"c": (0.0, 6.0)}, draws=3)


def quench_case(draw):
    law, low = seeded(draw), draw.uniform(0.05, 0.2)
    speeds, minimise = (low, low + draw.uniform(0.1, 0.4)), str(draw.choice(["intensity", "force"]))
    damping = draw.uniform(0.0, 0.1)
    theta = (np.arange(4000) + 0.5) * np.pi / 4000

    def design(M, L, T):
        scene = belt_in((M, L, T), law, damping, shaken=True)
        ends = tuple(v * L / T for v in speeds)
        return sf.design.quench(scene, ends, Omega=(15 / T, 60 / T), a=(0.0, 0.1 * L), minimise=minimise)

    def worth(values):
        q, mu = values["a"] * values["Omega"], law()
        slope = sp.lambdify(sf.SPEED, sp.diff(mu.kinetic, sf.SPEED), "numpy")
        rest, least = mu(1e-12), np.inf
        for v in np.linspace(*speeds, 101):
            jump = 2 * rest / np.pi / np.sqrt(q * q - v * v) if v < q else 0.0
            least = min(least, damping + np.mean(slope(np.abs(v - q * np.cos(theta)))) + jump)
        return q if minimise == "intensity" else q * values["Omega"], -least - 1e-6

    unit = (lambda M, L, T: L / T) if minimise == "intensity" else (lambda M, L, T: L / T**2)
    return Case(design, worth, unit, {"a": (0.0, 0.1), "Omega": (15.0, 60.0)})


def absorber_case(draw):
    ratio, criterion = float(10 ** draw.uniform(-2, 1)), str(draw.choice(["hinf", "h2", "decay", "self-excited"]))
    from symfric.theory import absorber as theory

    def worth(values):
        f, z = values["tuning"], values["damping"]
        if criterion == "hinf":
            return theory.peaks(ratio, f, z)[0][1], 0.0
        if criterion == "h2":
            return theory.variance(ratio, f, z), 0.0
        if criterion == "decay":
            return theory.decay_rate(ratio, f, z), 0.0
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = 0.5 * (low + high)
            stable = theory.decay_rate(ratio, f, z, -middle) > 0
            low, high = (middle, high) if stable else (low, middle)
        return low, 0.0

    sense = -1 if criterion in ("decay", "self-excited") else 1
    around = {"tuning": (0.02, 3.0), "damping": (0.001, 3.0)}
    return Case(lambda M, L, T: sf.design.absorber(ratio, criterion), worth, None, around, sense)


def positioning_case(draw):
    mu1, mu2 = draw.uniform(-0.6, 0.1), draw.uniform(-0.2, 0.6)
    epsilon = float(draw.choice([0.0, draw.uniform(0.01, 1.0), draw.uniform(0.01, 1.0)]))
    low = draw.uniform(0.4, 2.0)
    speeds = (low, low * draw.uniform(1.1, 4.0))
    damper = str(draw.choice(["ground", "support"]))

    def scene(sigma, V):
        return sf.scenes.drive_slide(mu1=mu1, mu2=mu2, p_star=1 / V - 1, epsilon=epsilon, sigma=sigma, damper=damper)

    def worth(values):
        share = values["sigma"] if damper == "ground" else 0.0
        one, two, again, worst = mu1 + values["sigma"], mu2 + values["sigma"], -1.0, 0.0
        for V in np.linspace(*speeds, 7):
            run = sf.simulate(scene(values["sigma"], V).where({"epsilon": 0.999 * epsilon}), 1e-10)
            again = max(again, float(any(e.kind == "stick" for e in run.events)))
            lam = 2 * (mu1 + share) * min(V, 1) + 2 * (mu2 + share) * max(V - 1, 0)
            worst = max(worst, sf.theory.drive.positioning_error(one, two, lam, epsilon=epsilon).value)
        return worst, again

    design = lambda M, L, T: sf.design.positioning(scene(0.0, speeds[0]), "sigma", (0, 1.5), speeds)  # noqa: E731
    return Case(design, worth, None, {"sigma": (0.0, 1.5)}, draws=6)


def settling_case(draw):
    delta, stick, settle = draw.uniform(0.03, 0.1), draw.uniform(1.0, 1.5), draw.uniform(5.0, 15.0)

    def scene(M, L, T):
        x, u = sp.symbols("x u", real=True)
        c = sp.Symbol("c", positive=True)
        contact = sf.Contact("ground", u, delta * M * L / T**2, sf.laws.coulomb(stick, 1.0))
        system = sf.System([x], [u], [[M]], [-x * M / T**2 - c * u])
        return sf.Scene(system, [contact], {c: 0.1 * M / T}, {x: L, u: 0.0}, 60.0 * T)

    def worth(values):
        run = sf.simulate(scene(1, 1, 1).where(values).wanting({"rest": sf.StopTime()}), 1e-11)
        return values["c"], run["rest"] / settle - 1 if np.isfinite(run["rest"]) else np.inf

    design = lambda M, L, T: sf.design.damper(scene(M, L, T), "c", (0.0, 1.8 * M / T), settle=settle * T)  # noqa: E731
    return Case(design, worth, lambda M, L, T: M / T, {"c": (0.0, 1.8)}, draws=40)


def contact_damper_case(draw):
    names = list(draw.choice(["f_n", "mu_m", "zeta"], size=draw.integers(1, 4), replace=False))
    whole = {"f_n": (3.0, 12.0), "mu_m": (0.02, 0.3), "zeta": (0.0, 0.1)}
    bounds = {}
    for name in names:
        a, b = sorted(draw.uniform(*whole[name], 2))
        bounds[str(name)] = (float(a), float(b))
    start = {"f_n": 5.0, "mu_m": 0.1, "x0": 0.01}

    def worth(values):
        run = sf.simulate(sf.scenes.contact_damper(**{**start, **values}), 1e-11)
        return run["stop_time"], 0.0 if np.isfinite(run["stop_time"]) else np.inf

    design = lambda M, L, T: sf.design.contact_damper(sf.scenes.contact_damper(**start), bounds)  # noqa: E731
    return Case(design, worth, None, bounds, draws=40)


def isolator_case(draw):
    seeds = draw.integers(0, 100, size=draw.integers(1, 4))
    motions = [sf.motions.synthetic(seed=int(k), pga=float(draw.uniform(0.1, 0.4)), unit="g") for k in seeds]
    minimise, limits = str(draw.choice(["acceleration", "displacement"])), {}
    if draw.random() < 0.7:
        other = "displacement" if minimise == "acceleration" else "acceleration"
        limits = {other: float(draw.uniform(0.08, 0.3) if other == "displacement" else draw.uniform(0.5, 2.0))}
    programs = []

    def scene(M, motion):
        return sf.scenes.rolling_isolator(C=1e5 * M, m=3e5 * M, motion=motion, profile=0.01)

    def design(M, L, T):
        bounds = {"C": (1e3 * M, 1e6 * M), "mu": (0.001, 0.1)}
        return sf.design.isolator(scene(M, motions[0]), motions, bounds, limits=limits, minimise=minimise)

    def worth(values):
        if not programs:
            programs.extend(sf.prepare(scene(1, m), 1e-10) for m in motions)
        runs = [p.run(values) for p in programs]
        worst = {k: max(r[f"peak_{k}"] for r in runs) for k in ("acceleration", "displacement")}
        return worst[minimise], max((worst[k] / v - 1 for k, v in limits.items()), default=-1.0) - 2e-9

    return Case(design, worth, lambda M, L, T: 1.0, {"C": (1e3, 1e6), "mu": (0.001, 0.1)}, draws=60)


def collocation_case(draw):
    spring, friction, law = draw.uniform(0.0, 0.5), draw.uniform(0.1, 0.4), float(draw.uniform(0.3, 3.0))

    def design(M, L, T):
        x, u, w = sp.symbols("x u w", real=True)
        force = M * L / T**2
        contact = sf.Contact("floor", slip=u, normal=friction * force, law=sf.laws.exponential(1, law * L / T))
        system = sf.System([x], [u], [[M]], [w - spring * M / T**2 * x])
        scene = sf.Scene(system, [contact], {w: 0.0}, {x: 0.0, u: 0.0}, 1.0)
        return sf.design.collocation(scene, {"w": (-force, force)}, end={"x": L, "u": 0}, time=(0.1 * T, 10 * T))

    return Case(design, None, lambda M, L, T: T, {})


KINDS = {
    "damper": damper_case,
    "quench": quench_case,
    "absorber": absorber_case,
    "positioning": positioning_case,
    "settling": settling_case,
    "contact_damper": contact_damper_case,
    "isolator": isolator_case,
    "collocation": collocation_case,
}


def examine(kind: str, seed: int, row: Row) -> None:
    """Design, look for better neighbours, check the requirement, and design again in other units."""
    draw = np.random.default_rng([seed, sorted(KINDS).index(kind)])
    case = KINDS[kind](draw)
    row.number += 1
    try:
        found = case.design(1.0, 1.0, 1.0)
    except sf.NotFound as reason:
        row.none += 1
        row.words.append(f"{kind} {seed}: none, {str(reason)[:100]}")
        found = None
    if found is not None:
        row.statuses[found.status] = row.statuses.get(found.status, 0) + 1
        if found.status == "unverified":
            row.words.append(f"{kind} {seed}: {'; '.join(found.doubts)[:160]}")
        if case.worth is not None:
            _neighbours(kind, seed, case, found, draw, row)
    if case.unit is not None:
        units = 10 ** draw.uniform(*np.log10(ENDS), 3)
        _in_units(kind, seed, case, found, units, row)


def _neighbours(kind, seed, case, found, draw, row) -> None:
    best, steps = found.objective, [k for k in found.values if k in case.bounds]
    told = {"v_b": found.scene.numbers()[found.scene.parameter("v_b")]} if kind == "damper" else {}
    if found.status in ("optimal", "best found") and kind not in EDGES:
        _, violation = case.worth(found.values)
        row.violated += violation > 1e-6
        if violation > 1e-6:
            row.words.append(f"{kind} {seed}: violates its requirement by {violation:.3g}")
    if kind in EDGES:  # on the edge of what is allowed: a little more must do
        key, more = EDGES[kind]
        _, violation = case.worth({**found.values, **told, key: found.values[key] * (1 + more)})
        row.violated += violation > 0
        if violation > 0:
            row.words.append(f"{kind} {seed}: violates its requirement by {violation:.3g}")
    for _ in range(case.draws):
        reach = 10 ** draw.uniform(-4, -0.7) if kind not in ("damper", "quench") else 10 ** draw.uniform(-1.5, -0.3)
        values = {**found.values, **told}
        for k in steps:
            low, high = case.bounds[k]
            values[k] = float(np.clip(values[k] + reach * draw.normal() * (high - low), low, high))
        if kind in ("damper", "settling"):
            values["c"] = found.values["c"] * (1 - min(reach, 0.9))
        objective, violation = case.worth(values)
        gain = case.sense * (best - objective) / max(abs(best), 1e-300)
        if violation <= 0 and gain > row.gap:
            row.gap = gain
        if violation <= 0 and gain > ROUNDING * (1e3 if kind == "absorber" and case.sense < 0 else 1):
            row.better += found.status != "best found"
            row.words.append(f"{kind} {seed}: {found.status}, {values} is better by {gain:.3g}")
            break


def _in_units(kind, seed, case, found, units, row) -> None:
    try:
        other = case.design(*units)
    except sf.NotFound:
        other = None
    if (found is None) != (other is None):
        row.changed += 1
        row.words.append(f"{kind} {seed}: found only in one of the units {units}")
    elif found is not None:
        change = abs(other.objective / case.unit(*units) - found.objective) / max(abs(found.objective), 1e-12)
        row.units = max(row.units, change)
        if change > SAME or other.status != found.status:
            row.changed += 1
            row.words.append(f"{kind} {seed}: {change:.3g} and {other.status} for {found.status} in the units {units}")


def table(count: int, first: int = 0) -> list[Row]:
    """Return a row for every kind, of `count` designs in all."""
    rows = {kind: Row(kind) for kind in KINDS}
    for k in range(count):
        kind = list(KINDS)[k % len(KINDS)]
        known = len(rows[kind].words)
        examine(kind, first + k // len(KINDS), rows[kind])
        for line in rows[kind].words[known:]:
            print(line, flush=True)
    return list(rows.values())


def printed(rows: list[Row]) -> str:
    """Return the table as text."""
    lines = [
        f"{'kind':15} {'number':>6} {'none':>4} {'gap':>9} {'better':>6} {'violated':>8} {'units':>9} {'changed':>7}"
    ]
    for r in rows:
        numbers = f"{r.number:6} {r.none:4} {r.gap:9.1e} {r.better:6} {r.violated:8} {r.units:9.1e} {r.changed:7}"
        lines.append(f"{r.kind:15} {numbers}  {r.statuses}")
    return "\n".join([*lines, *(w for r in rows for w in r.words)])


if __name__ == "__main__":
    print(printed(table(int(sys.argv[1]) if len(sys.argv) > 1 else 200)))
