"""Verdicts of a stress run."""

from collections import Counter
from dataclasses import asdict, dataclass

VERDICTS = ("agrees", "alone", "unconfirmed", "status", "sensitive", "silent failure")


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
        "agrees" with the reference; "alone" if that had no answer: agrees with itself at a finer tolerance;
        "unconfirmed" if that had none either; the energies balance in all three. "status": ended early, with advice;
        "sensitive": runs differ, but by no more than the change of the reference when the start is perturbed; "silent
        failure": none of these.
    route, status : str
        Of the chosen run.
    tolerance : float
    finer, second, energy : float
        Largest difference from the run at a finer tolerance and from the reference, relative to each state's largest
        value, and the residual of the energies; NaN where there is none.
    change : float
        Largest change of the reference by perturbations of the start, relative likewise; NaN where it was not needed.
    note : str
        Why the reference had no answer; whether it had one where the run ended early.
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

    def to_dict(self) -> dict[str, object]:
        """Return counts and all scenes without the verdict "agrees", as plain data."""
        statuses = Counter(v.status for v in self.verdicts if v.verdict == "status")
        notable = [asdict(v) for v in self.verdicts if v.verdict not in ("agrees", "alone")]
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


def _counted(verdicts) -> dict[str, int]:
    found = Counter(v.verdict for v in verdicts)
    return {name: found[name] for name in VERDICTS}
