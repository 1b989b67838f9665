"""Comparison of predicted quantities of a design with the event-driven model."""

from dataclasses import dataclass
from typing import Any

from symfric.model.results import Result


@dataclass(frozen=True)
class Compared(Result):
    """A predicted and a computed value of one quantity at an optimum.

    Attributes
    ----------
    quantity : str
    predicted, computed : float
        Value of the design's own model; value of the event-driven model.
    tolerance : float
        Largest difference that counts as agreement, relative to the predicted value, or to `size` if that is larger.
    size : float
        Scale of the quantity, in its unit.
    """

    quantity: str
    predicted: float
    computed: float
    tolerance: float
    size: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return plain Python data."""
        return {**super().to_dict(), "agrees": self.agrees}

    @property
    def agrees(self) -> bool:
        """Whether both values agree within the tolerance; False if one is NaN."""
        if self.predicted == self.computed:
            return True
        return bool(abs(self.computed - self.predicted) <= self.tolerance * max(self.size, abs(self.predicted)))

    @property
    def words(self) -> str:
        """The comparison as one line of text."""
        return f"{self.quantity}: predicted {self.predicted:.8g}, computed {self.computed:.8g}"


@dataclass(frozen=True)
class Comparison(Result):
    """Verification of an optimum: several quantities compared with the event-driven model.

    Attributes
    ----------
    rows : tuple of Compared
    """

    _told = ("agrees", "rows")

    rows: tuple[Compared, ...]

    @property
    def agrees(self) -> bool:
        """Whether all quantities agree."""
        return all(row.agrees for row in self.rows)

    @property
    def disagreements(self) -> tuple[str, ...]:
        """The quantities that do not agree, as lines of text."""
        return tuple(row.words for row in self.rows if not row.agrees)

    def __getitem__(self, quantity: str) -> Compared:
        """Return the comparison of one quantity."""
        return {row.quantity: row for row in self.rows}[quantity]

    def __str__(self) -> str:
        return "; ".join(row.words for row in self.rows)
