"""What is found above the solvers in other units: orbits, branches, maps, thresholds, predictions and designs."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design import damper, quench
from symfric.orbits.steady_state import vibration
from tests.longer import longer
from tests.units import Dimension, Units

NUMBER, LENGTH, SPEED, TIME, RATE = (0, 0, 0), (0, 1, 0), (0, 1, -1), (0, 0, 1), (0, 0, -1)
FORCE = (1, 1, -2)
X, U = sp.symbols("x u", real=True)
F, W, V, C, MU_S = sp.symbols("F W v_b c mu_s", positive=True)


class Seen(NamedTuple):
    """One thing found: numbers of a dimension, or words that are the same in all units."""

    value: object
    dimension: Dimension | None = None
    rel: float = 1e-9


Question = Callable[[sf.Scene, Units], dict[str, Seen]]
BELT_DIMENSIONS = {"v_b": SPEED, "a": LENGTH, "Omega": RATE, "beta": RATE, "gamma2": (0, 1, -2)}
FLOOR_DIMENSIONS = {"F": FORCE, "W": RATE, "v_b": SPEED, "c": (1, 0, -1)}


def belt(law=None, **changes):
    return sf.scenes.mass_on_belt(law, **{"v_b": 0.2, **changes})


def floor(law, W_value=1.4):
    """x'' + 0.1 x' + x = F cos Wt with friction on the ground."""
    system = sf.System([X], [U], [[1]], [-X - 0.1 * U + F * sp.cos(W * sf.TIME)])
    values = {F: 1.0, W: W_value} | ({MU_S: 0.4} if MU_S in law.free_symbols else {})
    return sf.Scene(system, [sf.Contact("floor", slip=U, normal=1, law=law)], values, {X: 0.5, U: 0.0}, 200.0)


def pair(held=50.0):
    """Two masses, the first on a belt; the second rests on a floor whose friction holds it."""
    x, u = sp.symbols("x1 x2", real=True), sp.symbols("u1 u2", real=True)
    force = [-x[0] - 0.02 * u[0] + 0.3 * (x[1] - x[0]), -x[1] - 0.3 * (x[1] - x[0])]
    contacts = [
        sf.Contact("belt", u[0] - V, 1, sf.laws.stribeck(0.4, 0.25, 0.3)),
        sf.Contact("floor", u[1], held, sf.laws.coulomb(0.3)),
    ]
    return sf.Scene(sf.System(x, u, sp.eye(2), force), contacts, {V: 0.2}, dict.fromkeys((*x, *u), 0.0), 100.0)


def with_bristle(law):
    """A mass on a belt with friction that has a state of its own."""
    system = sf.System([X], [U], [[1]], [-X - 0.05 * U])
    return sf.Scene(system, [sf.Contact("belt", U - V, 1, law)], {V: 0.1}, {X: 0.0, U: 0.0}, 200.0)


def about(orbit, scale, rel=1e-9) -> dict[str, Seen]:
    """What an orbit is; its states over their scale."""
    return {
        "period": Seen(orbit.period, TIME, rel),
        "half range": Seen(orbit.half_range / scale, NUMBER, rel),
        "multipliers": Seen(np.abs(orbit.multipliers), NUMBER, 1e-7),
        "sticks": Seen(orbit.stick_fraction, NUMBER, 1e-8),
        "stable": Seen((orbit.stable, orbit.differentiable, orbit.trivial)),
        "events": Seen(sorted((e.contact, e.before, e.after) for e in orbit.events)),
    }


def cycle(scene, units):
    return about(sf.limit_cycle(scene), units.states(scene))


def branch_over(name, span, rel=1e-9, start=None) -> Question:
    """Return what a branch over a span of a parameter is, the span in the units of the first scene."""

    def question(scene, units):
        dimension = DIMENSIONS.get(name, NUMBER)
        ends = tuple(e * units.of(dimension) for e in span)
        begin = sf.hopf(scene, name, tuple(e * units.of(dimension) for e in start)) if start else None
        branch = sf.continue_cycle(scene, name, ends, start=begin)
        found = {
            "ends": Seen((branch.ends, [(s.kind, s.jump) for s in branch.special])),
            "special": Seen([s.value for s in branch.special], dimension, rel),
            "values": Seen([np.min(branch.values), np.max(branch.values)], dimension, 1e-6),
        }
        for k, special in enumerate(branch.special):
            size = 1e-6 if special.kind != "hopf" else 1e-3
            found |= {
                f"{k} {n}": v for n, v in about(special.orbit, units.states(scene), size).items() if n == "period"
            }
        return found

    return question


def curve_over(name, span, names, spans) -> Question:
    """Return what a curve of the first special point of a branch is."""

    def question(scene, units):
        scale = [units.of(DIMENSIONS.get(n, NUMBER)) for n in (name, *names)]
        branch = sf.continue_cycle(scene, name, tuple(e * scale[0] for e in span))
        limits = tuple(tuple(e * s for e in pair) for pair, s in zip(spans, scale[1:], strict=True))
        curve = sf.continue_special(branch.special[0], names, limits)
        middle = 0.5 * (spans[0][0] + spans[0][1]) * scale[1]
        return {"ends": Seen(curve.ends), "at": Seen(curve.at(middle), DIMENSIONS.get(names[1], NUMBER), 1e-8)}

    return question


DIMENSIONS = BELT_DIMENSIONS | FLOOR_DIMENSIONS | {"a": LENGTH}


def thresholds(scene, units):
    rest, point = sf.equilibrium(scene), sf.hopf(scene, "v_b", tuple(e * units.of(SPEED) for e in (0.3, 0.6)))
    found = sf.stability(scene)
    return {
        "rest": Seen(rest.x / units.states(scene), NUMBER),
        "sliding": Seen(list(rest.sliding.values()), SPEED),
        "words": Seen((found.definiteness, found.stable, found.hurwitz.stable, point.kind)),
        "margin": Seen(found.margin, RATE, 1e-8),
        "eigenvalues": Seen(sorted(found.eigenvalues.imag), RATE, 1e-8),
        "hopf": Seen(point.value, SPEED),
        "omega": Seen(point.omega, RATE),
        "cubic": Seen(point.first_lyapunov, (0, -2, -1), 1e-6),
    }


def averaged(scene, units):
    slow = sf.average(scene)
    sizes = np.array([0.1, 0.5, 1.0]) * units.of(LENGTH)
    return {
        "amplitudes": Seen(list(slow.amplitudes), LENGTH, 1e-8),
        "stable": Seen(list(slow.stable)),
        "rate": Seen(slow(sizes), SPEED, 1e-8),
    }


def exponents(horizon) -> Question:
    def question(scene, units):
        found = sf.lyapunov(scene, horizon * units.of(TIME))
        return {
            "exponents": Seen(found.exponents, RATE, 1e-6),
            "spread": Seen(found.spread, RATE, 1e-3),
            "chaotic": Seen((found.chaotic, found.doubtful)),
        }

    return question


def section(of, dimension, **rules) -> Question:
    """Return the points on a section; `of` gives it from the scene and the units."""

    def question(scene, units):
        points = sf.poincare(scene, of(scene, units) if of else None, tolerance=1e-12, **rules)
        return {
            "number": Seen(points.times.size),
            "times": Seen(points.times, TIME, 1e-7),
            "states": Seen(points.states / units.states(scene)[:, None], NUMBER, 1e-7),
        }

    return question


def diagram(name, values, after, **rules) -> Question:
    def question(scene, units):
        row = np.array(values) * units.of(DIMENSIONS.get(name, NUMBER))
        found = sf.bifurcation_diagram(
            scene, name, row, "u", transient=after * units.of(TIME), tolerance=1e-11, **rules
        )
        return {
            "case": Seen((found.case.tolist(), found.status.tolist())),
            "coordinates": Seen(found.states[0], LENGTH, 1e-6),
        }

    return question


def basin(starts) -> Question:
    def question(scene, units):
        found = sf.basins(scene, {"x": np.array(starts) * units.of(LENGTH)})
        return {
            "label": Seen((found.label.tolist(), found.status.tolist(), [a.kind for a in found.attractors])),
            "orbits": Seen([a.orbit.period for a in found.attractors if a.orbit], TIME),
        }

    return question


def measured(scene, units):
    seen = vibration(scene, "x")
    return {
        "half range": Seen(seen.half_range, LENGTH, 1e-6),
        "period": Seen(seen.period, TIME, 1e-6),
        "note": Seen(seen.note),
    }


def design(found, names) -> dict[str, Seen]:
    """What a design is; the names of its values by the dimension."""
    return {
        "status": Seen(
            (
                found.status,
                len(found.doubts),
                [a.split(" at ")[0].rstrip("0123456789.e+-") for a in found.active],
                found.check.agrees,
            )
        ),
        **{n: Seen(found.values[n], d, 1e-6) for n, d in names.items()},
    }


def damped(scene, units, **rules):
    speeds = tuple(e * units.of(SPEED) for e in (0.2, 0.45))
    found = damper(scene, "beta", (0.0, units.of(RATE)), speeds, **rules)
    return design(found, {"beta": RATE})


def limited(scene, units):
    return damped(scene, units, half_range=0.1 * units.of(LENGTH))


def settled(scene, units):
    return design(
        damper(scene, "c", (0.0, 1.8 * units.of((1, 0, -1))), settle=10.0 * units.of(TIME)), {"c": (1, 0, -1)}
    )


def quenched(minimise="intensity", **limits) -> Question:
    def question(scene, units):
        dimensions = {"power": (1, 2, -3), "acceleration": (0, 1, -2), "friction": NUMBER}
        given = {n: v * units.of(dimensions[n]) for n, v in limits.items()}
        bounds = {"Omega": [e * units.of(RATE) for e in (20, 60)], "a": [e * units.of(LENGTH) for e in (0, 0.03)]}
        speeds = (0.0, units.of(SPEED))
        try:
            found = quench(scene, speeds=speeds, minimise=minimise, limits=given or None, **bounds)
        except sf.NotFound as failure:
            return {"none": Seen(str(failure).split(",")[0].split("from")[0])}
        return design(found, {"a": LENGTH, "Omega": RATE})

    return question


FORCED = belt(a=0.4 / 2.35**2, Omega=2.35)
WELLS = sf.Scene(
    sf.System([X], [U], [[1]], [X - X**3 - C * U + F * sp.cos(sf.TIME)]), (), {C: 0.25, F: 0.2}, {X: 1.0, U: 0.0}, 200.0
)
FREE = sf.Scene(
    sf.System([X], [U], [[1]], [-X - C * U]),
    [sf.Contact("ground", U, 0.06, sf.laws.coulomb(1.5, 1.0))],
    {C: 0.2},
    {X: 1.0, U: 0.0},
    60.0,
)
CASES: dict[str, tuple[sf.Scene, Question]] = {
    "cycle that sticks": (belt(), cycle),
    "cycle that slips": (belt(v_b=0.42), cycle),
    "cycle beside a body at rest": (pair(), cycle),
    "forced cycle": (floor(sf.laws.coulomb(0.4, 0.3)), cycle),
    "branch of the belt": (belt(), branch_over("v_b", (0.01, 0.6))),
    "branch from Hopf": (belt(), branch_over("v_b", (0.3, 0.6), start=(0.3, 0.6))),
    "branch with a fold": (belt(sf.laws.exponential(0.4, 1.0), v_b=1.0), branch_over("v_b", (0.8, 3.0))),
    "branch of a pair": (pair(0.2), branch_over("v_b", (0.19, 0.22))),
    "branch of the floor": (floor(sf.laws.coulomb(0.3)), branch_over("F", (0.42, 1.5))),
    "branch with a static peak": (floor(sf.laws.coulomb(0.4, 0.3)), branch_over("F", (0.42, 1.5))),
    "graze": (
        sf.scenes.two_slides(r=0.5, zeta=2.0, s1=0.2, s2=0.3, fc1=1.0, fs1=7.8, horizon=400.0),
        branch_over("fs1", (7.0, 8.5), 1e-8),
    ),
    "curve of onsets": (
        floor(sf.laws.coulomb(MU_S, 0.3)),
        curve_over("F", (0.42, 1.2), ("mu_s", "F"), ((0.38, 0.42), (0.3, 0.9))),
    ),
    "curve of folds": (
        belt(sf.laws.exponential(0.4, 1.0), v_b=1.0),
        curve_over("v_b", (0.8, 3.0), ("beta", "v_b"), ((0.045, 0.055), (0.8, 3.0))),
    ),
    "thresholds": (belt(), thresholds),
    "thresholds of a soft start": (belt(sf.laws.stribeck(0.4, 0.25, 0.3), v_b=0.4), thresholds),
    "averaged": (belt(), averaged),
    "exponents of a cycle": (belt(v_b=0.42), exponents(300.0)),
    "exponents that sticking takes": (belt(), exponents(200.0)),
    "exponents when forced": (WELLS, exponents(200.0)),
    "section of turns": (belt(), section(lambda s, n: "u", SPEED)),
    "section of a cube": (
        belt(),
        section(lambda s, n: s.system.q[0] ** 3 - sp.Float(0.2**3) * n.exactly((0, 3, 0)), LENGTH),
    ),
    "section of a small force": (
        belt(),
        section(lambda s, n: (s.system.q[0] * s.system.u[0]) ** 3 + s.system.u[0] ** 6 * n.exactly((0, 0, 3)), LENGTH),
    ),
    "section in phase": (FORCED, section(None, TIME)),
    "diagram to rest": (sf.scenes.coulomb_oscillator(0.03, horizon=100.0), diagram("delta", (0.02, 0.03), 95.0)),
    "diagram of the belt": (belt(horizon=200.0), diagram("v_b", (0.2, 0.42, 0.6), 150.0, carry=True)),
    "basins of sliding and a cycle": (
        belt(sf.laws.exponential(0.4, 1.0), v_b=1.6, horizon=800),
        basin(np.linspace(-3, 3, 9)),
    ),
    "basins of wells": (WELLS, basin((-1.5, -0.5, 0.5, 1.5))),
    "basins of rest": (sf.scenes.coulomb_oscillator(0.03), basin(np.linspace(-1, 1, 3))),
    "vibration of a study": (belt(), measured),
    "rest of a study": (FREE, measured),
    "damper": (belt(), damped),
    "damper of a limit": (belt(), limited),
    "settling damper": (FREE, settled),
    "quench": (belt(), quenched()),
    "quench for power": (belt(), quenched("power")),
    "quench with limits": (belt(), quenched("force", friction=0.5, acceleration=50.0, power=0.5)),
    "no quench": (belt(), quenched("power", power=1e-4)),
}
BASE = Units(0, 0, 0)
_FOUND: dict[str, dict[str, Seen]] = {}


def dimensions_of(scene):
    if "gamma2" in {s.name for s in scene.values}:
        return BELT_DIMENSIONS | {"gamma2": NUMBER}
    return FLOOR_DIMENSIONS


SLOW = (
    "cycle beside a body at rest",
    "curve of onsets",
    "branch of a pair",
    "damper of a limit",
    "branch of the belt",
    "branch of the floor",
    "curve of folds",
    "no quench",
)


@pytest.mark.one_in(16)
@pytest.mark.parametrize("name", longer(CASES, SLOW))
@pytest.mark.parametrize("seed", longer(range(4), range(1, 4)))
def test_other_units(name, seed):
    scene, question = CASES[name]
    if name not in _FOUND:
        _FOUND[name] = question(BASE.written(scene, dimensions_of(scene)), BASE)
    units = Units.drawn(np.random.default_rng([19, seed, *name.encode()]))
    found = question(units.written(scene, dimensions_of(scene)), units)
    for what, one in _FOUND[name].items():
        if one.dimension is None:
            assert found[what].value == one.value, what
            continue
        value, known = np.asarray(found[what].value) / units.of(one.dimension), np.asarray(one.value)
        assert value.shape == known.shape, what
        size = np.max(np.abs(known[np.isfinite(known)]), initial=0.0)
        assert value == pytest.approx(known, rel=one.rel, abs=one.rel * size, nan_ok=True), what


def test_a_slow_belt_is_no_belt_at_rest():
    """A belt of 1e-18 m/s slides below its mass as any other; two belts of one speed have no slip, whatever it is."""
    rest = sf.equilibrium(belt(v_b=1e-18, gamma2=1e-18))
    assert rest.x[0] == pytest.approx(0.4e-18)
    other = sp.Symbol("v_c", positive=True)
    system = sf.System([X], [U], [[1]], [-X])
    for size in (1.0, 1e9):
        contact = sf.Contact("belts", U - V + other + C, 1, sf.laws.coulomb(0.3))
        scene = sf.Scene(system, [contact], {V: 0.3 * size, other: 0.1 * size, C: 0.2 * size}, {X: 0.0, U: 0.0}, 10.0)
        with pytest.raises(sf.SceneError, match="does not slip"):
            sf.equilibrium(scene)


def test_amplitudes_without_a_speed_of_a_contact():
    """Van der Pol's cycle has the amplitude 2, in any unit of length: nothing else tells how large it is."""
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X + (1 - X**2) * U / 20]), (), {}, {X: 1.0, U: 0.0}, 100.0)
    for power in (-15, 0, 15):
        units = Units(0, power, 2)
        slow = sf.average(units.written(scene))
        assert slow.amplitudes == pytest.approx([2.0 * units.of(LENGTH)], rel=1e-9)
        assert slow.stable.all()
