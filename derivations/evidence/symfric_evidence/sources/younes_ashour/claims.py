"""Tests of the verbal claims of Younes and Ashour, under each interpretation, with the deciding numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from symfric.model import laws
from symfric.report.study.data import plain
from symfric.theory.transient import averaged_decay_time, half_cycles
from symfric_evidence.sources.younes_ashour.decay_figures import FREQUENCIES, RIG, RODS
from symfric_evidence.sources.younes_ashour.decays import FALLING, GRAVITY, LAWS, PRINTED, START, decay, start_of

Evidence = tuple[bool | None, dict[str, float]]


@dataclass(frozen=True)
class Reading:
    """One interpretation of a claim.

    Attributes
    ----------
    words : str
    holds : bool or None
        None if only the source's records could decide.
    evidence : dict of str to float
    """

    words: str
    holds: bool | None
    evidence: Mapping[str, float]


@dataclass(frozen=True)
class Claim:
    """A sentence of the source, and the result of testing it.

    Attributes
    ----------
    where, words : str
    readings : tuple of Reading
    measured : bool
        Whether the sentence is about measured records: the model can agree with it or not, but neither prove nor refute
        it.
    """

    where: str
    words: str
    readings: tuple[Reading, ...]
    measured: bool = False

    @property
    def verdict(self) -> str:
        """'true', 'false', 'true only under a stated reading', 'so in the model', 'not so in the model', ..."""
        held = {r.holds for r in self.readings} - {None}
        if not held:
            return "not testable"
        if self.measured:
            return "partly so in the model" if len(held) == 2 else f"{'' if True in held else 'not '}so in the model"
        return "true only under a stated reading" if len(held) == 2 else "true" if True in held else "false"


def claims() -> tuple[Claim, ...]:
    """Test every claim."""
    return tuple(
        Claim(where, words, tuple(Reading(reading, *test()) for reading, test in readings.items()), where in MEASURED)
        for where, words, readings in CLAIMS
    )


def claims_table(judged: tuple[Claim, ...] | None = None) -> list[dict[str, object]]:
    """Return one row for each reading of each claim, plain data for JSON or CSV."""
    rows: list[dict[str, object]] = plain(
        [
            {
                "where": claim.where,
                "claim": claim.words,
                "verdict": claim.verdict,
                "measured": claim.measured,
                "reading": reading.words,
                "holds": reading.holds,
                "evidence": dict(reading.evidence),
            }
            for claim in (claims() if judged is None else judged)
            for reading in claim.readings
        ]
    )
    return rows


# --- Stiffness ---------------------------------------------------------------------------------------------------


def _stiffer(slow: float, fast: float, zeta: float = 0.0) -> Evidence:
    """Test whether the stiffer support stops sooner, by more than half a period of the soft one."""
    times = {f: decay(f_n=f, mu_m=0.1, zeta=zeta).time for f in (slow, fast)}
    return times[fast] < times[slow] - 0.5 / slow, {f"time at {f:g} Hz, s": t for f, t in times.items()}


def _stiffer_at_equal_energy() -> Evidence:
    energy = {f: start_of(0.05, f_n=f, m=0.5) for f in (3.5, 20.0)}
    times = {f: decay(f_n=f, mu_m=0.1, x0=float(x0)).time for f, x0 in energy.items()}
    averaged = {f: averaged_decay_time(f, 0.1, x0=float(x0)) for f, x0 in energy.items()}
    evidence = {f"time at {f:g} Hz, s": t for f, t in times.items()}
    evidence |= {f"averaged at {f:g} Hz, s": t for f, t in averaged.items()}
    return times[20.0] < times[3.5] - 0.5 / 3.5, evidence


def _rate() -> Evidence:
    """Test the mean power from a given displacement."""
    power = {f: 0.25 * (2 * np.pi * f * START) ** 2 / decay(f_n=f, mu_m=0.1).time for f in (3.5, 10.0)}
    return power[10.0] > power[3.5], {f"mean power at {f:g} Hz, W": p for f, p in power.items()}


# --- Friction ----------------------------------------------------------------------------------------------------


def _one_cycle(law: str, x0: float = START) -> Evidence:
    motion = decay(law, f_n=3.5, mu_m=0.1, x0=x0)
    return motion.half_cycles <= 2, {"half cycles": motion.half_cycles, "closest margin": motion.closest}


def _one_cycle_constant() -> Evidence:
    count = half_cycles(0.1 * GRAVITY / (7 * np.pi) ** 2, x0=START)
    return count <= 2, {"half cycles": count}


def _below_two_seconds(law: str, frequencies: tuple[float, ...]) -> Evidence:
    times = {f: decay(law, f_n=f, mu_m=0.1).time for f in frequencies}
    return max(times.values()) < 2, {f"time at {f:g} Hz, s": t for f, t in times.items()}


def _two_seconds_limit() -> Evidence:
    """Find the frequency at which the averaged decay takes 2 s."""
    from scipy import optimize

    limit = float(optimize.brentq(lambda f: averaged_decay_time(f, 0.1) - 2, 5, 30, xtol=1e-9))
    holds = decay(f_n=limit - 0.5, mu_m=0.1).time < 2 < decay(f_n=limit + 0.5, mu_m=0.1).time
    return holds, {"frequency of 2 s, Hz": limit}


# --- Start -------------------------------------------------------------------------------------------------------


def _twice_the_displacement() -> Evidence:
    times = {x: decay(f_n=10.0, mu_m=0.1, x0=x).time for x in (START, 2 * START)}
    same = abs(times[START] - times[2 * START]) <= 0.05
    return same, {f"time from {1000 * x:g} mm, s": t for x, t in times.items()}


def _displacement_or_impulse(f_n: float = 10.0) -> Evidence:
    differences = []
    for energy in np.linspace(0.004, 0.2, 40):
        x0, v0 = (float(start_of(energy, f_n=f_n, m=0.5, impulse=i)) for i in (False, True))
        still, hit = decay(f_n=f_n, mu_m=0.1, x0=x0), decay(f_n=f_n, mu_m=0.1, x0=0.0, v0=v0)
        differences.append(abs(still.time - hit.time))
    worst = max(differences)
    return worst <= 0.5 / f_n, {"largest difference, s": worst, "half a period, s": 0.5 / f_n}


# --- Shares of damping and friction ------------------------------------------------------------------------------


def _ratio_with_energy(law: str) -> Evidence:
    ratios = {x: decay(law, f_n=10.0, mu_m=0.1, zeta=0.05, x0=x).ratio for x in (START / 5, START)}
    return ratios[START / 5] < 1 < ratios[START], {f"R from {1000 * x:g} mm": r for x, r in ratios.items()}


def _role_of_friction(zeta: float) -> Evidence:
    """Test the effect of halving friction on the decay time, with much damping and without."""
    longer = {
        z: averaged_decay_time(10.0, 0.05, zeta=z) / averaged_decay_time(10.0, 0.1, zeta=z) - 1 for z in (0, zeta)
    }
    return longer[zeta] < 0.5 * longer[0], {f"longer by, zeta = {z:g}": v for z, v in longer.items()}


def _irrespective(zeta: float) -> Evidence:
    """Test whether the decay time stays within a tenth when friction is halved."""
    longer = averaged_decay_time(20.0, 0.05, zeta=zeta) / averaged_decay_time(20.0, 0.1, zeta=zeta) - 1
    return longer < 0.1, {"longer by": longer}


def _share(zeta: float) -> Evidence:
    """Test whether the contact takes less than a tenth of the energy."""
    share = 1 / (1 + decay(f_n=20.0, mu_m=0.1, zeta=zeta).ratio)
    return share < 0.1, {"share of the contact": share}


def _parts(powers: bool) -> Evidence:
    """Test viscous part proportional to speed, contact part falling with it, from 0.1 to 0.2 m/s."""
    low, high = 0.1, 0.2
    falling = laws.exponential(1.0)
    viscous, contact = high / low, float(falling(high) / falling(low))
    if powers:
        viscous, contact = viscous * high / low, contact * high / low
    return viscous == high / low and contact < 1, {"viscous at twice the speed": viscous, "contact": contact}


# --- The rods ----------------------------------------------------------------------------------------------------

ENERGIES = np.linspace(0.004, 0.1, 49)


def _rod_times(name: str, averaged: bool) -> np.ndarray:
    rod = RODS[name]
    starts = start_of(ENERGIES, f_n=RIG["f_n"], m=rod["m"])
    if averaged:
        return np.array([averaged_decay_time(mu_m=rod["mu_m"], x0=x0, **RIG) for x0 in starts])
    return np.array([decay(FALLING, **rod, **RIG, x0=float(x0)).time for x0 in starts])


def _steel_longer(averaged: bool) -> Evidence:
    steel, aluminium = (_rod_times(name, averaged) for name in ("steel", "aluminium"))
    longer = steel - aluminium
    evidence = {"smallest difference, s": float(np.min(longer)), "largest, s": float(np.max(longer))}
    return bool(np.all(steel > aluminium)), evidence


def _linear_in_energy() -> Evidence:
    """Test the exponent of the averaged decay time of the steel rod in the energy, and a straight line's misfit."""
    times = _rod_times("steel", averaged=True)
    exponent = np.polyfit(np.log(ENERGIES), np.log(times), 1)[0]
    misfit = {
        word: float(np.max(np.abs(np.polyval(np.polyfit(x, times, 1), x) - times)) / np.ptp(times))
        for word, x in (("energy", ENERGIES), ("root of energy", np.sqrt(ENERGIES)))
    }
    evidence = {"exponent": float(exponent), **{f"misfit of a line in {w}": m for w, m in misfit.items()}}
    return misfit["energy"] < misfit["root of energy"], evidence


def _aluminium_one_cycle() -> Evidence:
    """Find the displacement up to which the aluminium rod stops within one cycle."""
    places = np.arange(0.0005, 0.03, 0.0005).tolist()
    counts = {x: decay(FALLING, **RODS["aluminium"], **RIG, x0=x).half_cycles for x in places}
    over = [x for x, n in counts.items() if n > 2]
    largest = max(x for x in counts if x < over[0]) if over else max(counts)
    return largest >= START, {"one cycle up to, mm": 1000 * largest}


def _records() -> Evidence:
    return None, {}


Test = Callable[[], Evidence]
MEASURED = ("figure 9", "figure 10", "conclusion 4")  # what the source says there, it says of its records
CLAIMS: tuple[tuple[str, str, dict[str, Test]], ...] = (
    (
        "figure 3, conclusion 1",
        "a stiff support restores its equilibrium sooner than an elastic one",
        {
            "from a given displacement, no damping": lambda: _stiffer(3.5, 10.0),
            "from a given energy, no damping": _stiffer_at_equal_energy,
            "from a given displacement, damping ratio 0.1, 10 to 20 Hz": lambda: _stiffer(10.0, 20.0, zeta=0.1),
        },
    ),
    (
        "figure 3",
        "a stiff support dissipates the energy at a higher rate",
        {"mean power from a given displacement, no damping": _rate},
    ),
    (
        "figure 4",
        "friction of 0.1 dissipates the initial energy in one cycle (3.5 Hz, 10 mm, no damping)",
        {
            "corrected law": lambda: _one_cycle(FALLING),
            "law as printed, displaced to x0 > 0": lambda: _one_cycle(PRINTED),
            "law as printed, displaced to x0 < 0": lambda: _one_cycle(PRINTED, -START),
            "constant friction": _one_cycle_constant,
        },
    ),
    (
        "figure 5",
        "decay takes less than two seconds for a large range of natural frequencies at 0.1",
        {
            "3.5 to 20 Hz": lambda: _below_two_seconds(FALLING, FREQUENCIES),
            "3.5 to 20 Hz, law as printed": lambda: _below_two_seconds(PRINTED, FREQUENCIES),
            "up to the frequency given": _two_seconds_limit,
        },
    ),
    (
        "figure 6",
        "the decay time is not affected by the initial values",
        {
            "a larger displacement": _twice_the_displacement,
            "displacement or impulse of equal energy, within half a period": _displacement_or_impulse,
        },
    ),
    (
        "after (6)",
        "viscous dissipation is proportional to the speed, that of the contact falls with it",
        {"the forces": lambda: _parts(powers=False), "the powers": lambda: _parts(powers=True)},
    ),
    (
        "figure 7, conclusion 2",
        "with high structural damping friction plays a small role",
        {"halving friction costs less than half as much time as without damping": lambda: _role_of_friction(0.2)},
    ),
    (
        "abstract",
        "with a stiff and damped support the decay time is minimal irrespective of friction",
        {
            "time within a tenth when friction is halved, damping ratio 0.2, 20 Hz": lambda: _irrespective(0.2),
            "friction takes less than a tenth of the energy there": lambda: _share(0.2),
        },
    ),
    (
        "abstract, conclusion 3",
        "for low excitation energy friction dominates over damping (10 Hz, friction 0.1, damping ratio 0.05)",
        {law: partial(_ratio_with_energy, law) for law in LAWS},
    ),
    (
        "figure 10",
        "the steel rod decays longer than the aluminium rod",
        {
            "averaged law, equal energy": lambda: _steel_longer(True),
            "every single decay, equal energy": lambda: _steel_longer(False),
        },
    ),
    (
        "figure 10",
        "the decay time of the steel rod varies linearly with the energy",
        {"averaged law": _linear_in_energy},
    ),
    (
        "figure 9",
        "for small displacements the aluminium rod rests after one cycle",
        {"up to 10 mm at least": _aluminium_one_cycle},
    ),
    ("conclusion 4", "the exponential law fits lubricated Hertzian contacts", {"measured records": _records}),
)
