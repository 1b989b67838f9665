"""Contacts whose slips differ by 1e-12 to 1e-6 of themselves, at rest: bodies that start at rest, stop and start again.

Such contacts hold next to nothing across their common direction, so that one of them sticks while the others slip, at
speeds that are near the rounding of those of the bodies. The motion is that of the scene in which the slips are the
same, as long as friction does not drop when slip begins: then those that slip carry less.
"""

from dataclasses import dataclass

import numpy as np
import pytest
import sympy as sp

import symfric as sf

HORIZON, TOLERANCE = 6.0, 1e-10
ALLOWED = 1e-7  # largest difference of two runs that agree
MERGED = 300.0  # the same in differences of the slips, between a scene and that of equal slips
SENSITIVE = 10.0  # largest difference in changes by a relative perturbation of the numbers
PERTURBATION = 1e-12


@dataclass(frozen=True)
class Structure:
    """Two or three bodies with two to five nearly parallel contacts, all numbers symbols."""

    system: sf.System
    contacts: list[sf.Contact]
    drops: bool  # whether friction drops when slip begins

    def scene(self, values, start):
        known = set().union(*(c.slip.free_symbols for c in self.contacts), *(f.free_symbols for f in self.system.force))
        for c in self.contacts:
            known |= c.normal.free_symbols | c.law.kinetic.free_symbols | c.law.stick.free_symbols
        known -= {*self.system.q, *self.system.u, sf.TIME, sf.SPEED}
        numbers = {s: values[s.name] if values else 0.5 for s in known}
        return sf.Scene(self.system, self.contacts, numbers, start or dict.fromkeys(self.system.states, 0.1), HORIZON)


def structure(seed):
    rng = np.random.default_rng([77, seed])
    n, n_c = int(rng.choice([2, 3])), int(rng.integers(2, 6))
    q, u = sp.symbols(f"q1:{n + 1}", real=True), sp.symbols(f"u1:{n + 1}", real=True)
    k, links = sp.symbols(f"k1:{n + 1}", positive=True), sp.symbols(f"l1:{n}", positive=True)
    constant, d = sp.symbols(f"f1:{n + 1}", real=True), sp.Symbol("d", positive=True)
    force = [-k[i] * q[i] - d * u[i] + constant[i] for i in range(n)]
    for i, link in enumerate(links):
        pull = link * (q[i] - q[i + 1])
        force[i], force[i + 1] = force[i] - pull, force[i + 1] + pull
    if rng.random() < 0.4:
        force[0] += sp.Symbol("F", real=True) * sp.sin(sp.Symbol("Omega", positive=True) * sf.TIME)
    base = [u[0] - u[1], u[0], u[0] + u[1] / 2][rng.integers(3)]
    belt = sp.Symbol("belt", real=True) if rng.random() < 0.2 else sp.Integer(0)
    drops = bool(rng.random() < 0.4)
    contacts = []
    for i in range(n_c):
        e = sp.Symbol(f"e{i}", real=True)
        mu, load, more = sp.symbols(f"mu{i} N{i} r{i}", positive=True)
        others = [base * (1 + e), base + e * u[-1], base + e * u[0], base + e * (u[0] + u[1]), base]
        slip = base if i == 0 else others[int(rng.choice(5, p=[0.15, 0.35, 0.25, 0.15, 0.1]))]
        law = sf.laws.coulomb(mu * (1 + more), mu) if drops else sf.laws.coulomb(mu)
        contacts.append(sf.Contact(f"c{i}", slip - belt, load, law))
    if rng.random() < 0.4:
        mu, load = sp.symbols("mux Nx", positive=True)
        contacts.append(sf.Contact("cx", u[1] if rng.random() < 0.5 else u[-1], load, sf.laws.coulomb(mu)))
    return Structure(sf.System(q, u, sp.eye(n), force), contacts, drops)


def numbers(made, rng):
    """Return values and a start; loads are equal in some draws, and differences are equal in some, or opposite."""
    apart, alike, tied = 10.0 ** rng.uniform(-12, -6), rng.random() < 0.4, rng.random() < 0.4
    ranges = {
        "k": (0.3, 4),
        "l": (0.1, 3),
        "d": (0, 0.2),
        "F": (0.2, 2),
        "O": (0.5, 5),
        "b": (-0.3, 0.3),
        "f": (-0.5, 0.5),
    }
    ranges |= (
        {"m": (0.3, 0.3), "N": (0.5, 0.5), "r": (0.1, 0.1)}
        if alike
        else {"m": (0.1, 0.6), "N": (0.1, 1), "r": (0.01, 0.5)}
    )
    values = {}
    for s in sorted(made.scene(None, None).values, key=lambda s: s.name):
        if s.name[0] == "e":
            values[s.name] = apart * float(rng.choice([-2, -1, 1, 2]) if tied else rng.normal())
        else:
            values[s.name] = float(rng.uniform(*ranges[s.name[0]]))
    rest = rng.random() < 0.4
    start = {s.name: float(rng.uniform(-1.5, 1.5)) for s in made.system.q}
    start |= {s.name: 0.0 if rest else float(rng.uniform(-1, 1)) for s in made.system.u}
    return values, start, apart


def change(program, values, start):
    """Return the largest change of the final state by perturbations of all numbers; NaN if no run ends."""
    rng, final, largest = np.random.default_rng(0), program.run(values, start).final, np.nan
    for _ in range(8):
        moved = [{k: v * (1 + PERTURBATION * rng.choice([-1, 1])) for k, v in e.items()} for e in (values, start)]
        run = program.run(*moved)
        if run.status == sf.Status.OK:
            largest = np.fmax(largest, np.max(np.abs(run.final - final)))
    return largest


# one draw of sixty, 36 two, by one of the two routes: slips of 1e-12 to 1e-6 of the others are lost in rounding
ENDS_EARLY = {8: "STEP_COLLAPSE", 14: "CHATTER", 18: "STEP_COLLAPSE", 36: "STEP_COLLAPSE"}


# of 2, 6 and 10, draws ended as CHATTER, UNDECIDED and STEP_COLLAPSE
@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("seed", "number"), [(2, 20), (6, 20), (10, 20), *(pytest.param(s, 60, marks=pytest.mark.long) for s in range(40))]
)
def test_nearly_parallel_contacts_at_rest(seed, number, request):
    if seed in ENDS_EARLY:
        request.applymarker(pytest.mark.xfail(raises=sf.RunFailed, strict=True, reason=ENDS_EARLY[seed]))
    made = structure(seed)
    programs = [sf.prepare(made.scene(None, None), TOLERANCE, route) for route in ("taylor", "exact")]
    rng, compared = np.random.default_rng([78, seed]), 0
    for _ in range(number):
        values, start, apart = numbers(made, rng)
        series, exact = (program.run(values, start).checked() for program in programs)
        differ = np.max(np.abs(series.final - exact.final))
        assert differ <= ALLOWED or differ <= SENSITIVE * change(programs[0], values, start)
        if not made.drops:
            equal = {k: 0.0 if k[0] == "e" else v for k, v in values.items()}
            differ = np.max(np.abs(series.final - programs[0].run(equal, start).checked().final))
            allowed = ALLOWED + MERGED * apart
            assert differ <= allowed or differ <= SENSITIVE * change(programs[0], values, start)
            compared += 1
    assert compared or made.drops
