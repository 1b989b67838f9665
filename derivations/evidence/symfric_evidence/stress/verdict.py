"""Verdicts of a stress run."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass

VERDICTS = ("agrees", "not unique", "sensitive", "status", "unconfirmed", "silent failure")
UNEXPLAINED = ("unconfirmed", "silent failure")


@dataclass(frozen=True)
class Verdict:
    """Verdict on one random scene.

    Attributes
    ----------
    family : str
    name : str
        Family, seed of the structure and number of the run, "weak-load/17/42".
    kind : str
        Kind of its numbers, where the family has several.
    verdict : str
        "agrees" with the reference, and with a run at a finer tolerance if that ended well. "not unique": agrees with
        the reference only where that takes another of several admissible modes, which move differently. "sensitive":
        runs differ, but a perturbation at the level of the tolerance changes both the run and the reference as much.
        "status": ended early, with advice. "unconfirmed": nothing independent had an answer. "silent failure": none of
        these, whichever side is wrong. The last two are unexplained.
    route, status : str
        Of the chosen run.
    tolerance : float
    finer, second, energy : float
        Largest difference from the run at a finer tolerance and from the reference, relative to each state's largest
        value, and the residual of the energies; NaN where there is none.
    change : float
        The smaller of the largest changes of the run and of the reference by the same perturbations of start and
        values, relative likewise; NaN where it was not needed.
    note : str
        Why the reference had no answer, and which method had; whether it had one where the run ended early; how a third
        method judges a difference.
    """

    family: str
    name: str
    kind: str
    verdict: str
    route: str
    status: str
    tolerance: float
    finer: float
    second: float
    energy: float
    change: float
    note: str


@dataclass(frozen=True)
class StressResult:
    """Result of a stress run.

    Attributes
    ----------
    verdicts : tuple of Verdict
    """

    verdicts: tuple[Verdict, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of scenes by verdict."""
        return _counted(self.verdicts)

    @property
    def by_family(self) -> dict[str, dict[str, int]]:
        """Number of scenes by verdict for every family."""
        families = dict.fromkeys(v.family for v in self.verdicts)
        return {name: _counted([v for v in self.verdicts if v.family == name]) for name in families}

    @property
    def failures(self) -> tuple[Verdict, ...]:
        """The silent failures."""
        return tuple(v for v in self.verdicts if v.verdict == "silent failure")

    @property
    def unexplained(self) -> tuple[Verdict, ...]:
        """The silent failures, and the runs that nothing confirmed."""
        return tuple(v for v in self.verdicts if v.verdict in UNEXPLAINED)

    def to_dict(self) -> dict[str, object]:
        """Return counts and all scenes without the verdict "agrees", as plain data."""
        statuses = Counter(v.status for v in self.verdicts if v.verdict == "status")
        notable = [asdict(v) for v in self.verdicts if v.verdict != "agrees"]
        plain = [{k: None if x != x else x for k, x in row.items()} for row in notable]
        return {
            "scenes": len(self.verdicts),
            "counts": self.counts,
            "families": self.by_family,
            "statuses": dict(statuses),
            "notable": plain,
        }

    def __repr__(self) -> str:
        return f"StressResult({', '.join(f'{n} {name}' for name, n in self.counts.items() if n)})"


def _counted(verdicts: Iterable[Verdict]) -> dict[str, int]:
    counts = Counter(v.verdict for v in verdicts)
    return {name: counts[name] for name in VERDICTS}
