"""What a design promises beside what the event-driven model does."""

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Compared:
    """One quantity at an optimum.

    Attributes
    ----------
    quantity : str
    predicted, computed : float
        Of the design's own model; of the event-driven one.
    tolerance : float
        Largest difference that counts as agreement, relative to the predicted value, or to `size` if that is larger.
    size : float
        What counts as a large value of the quantity, in its unit.
    """

    quantity: str
    predicted: float
    computed: float
    tolerance: float
    size: float = 0.0

    @property
    def agrees(self) -> bool:
        """Whether they are the same within the tolerance; NaN agrees with nothing."""
        if self.predicted == self.computed:
            return True
        return bool(abs(self.computed - self.predicted) <= self.tolerance * max(self.size, abs(self.predicted)))

    @property
    def words(self) -> str:
        """The comparison in one line."""
        return f"{self.quantity}: predicted {self.predicted:.8g}, computed {self.computed:.8g}"


@dataclass(frozen=True)
class Comparison:
    """What the event-driven model does at an optimum.

    Attributes
    ----------
    rows : tuple of Compared
    """

    rows: tuple[Compared, ...]

    @property
    def agrees(self) -> bool:
        """Whether every row does."""
        return all(row.agrees for row in self.rows)

    @property
    def disagreements(self) -> tuple[str, ...]:
        """The rows that do not, in words."""
        return tuple(row.words for row in self.rows if not row.agrees)

    def __getitem__(self, quantity: str) -> Compared:
        """Return the row of a quantity."""
        return {row.quantity: row for row in self.rows}[quantity]

    def to_dict(self) -> dict[str, object]:
        """Return plain Python data."""
        return {"agrees": self.agrees, "rows": [{**asdict(row), "agrees": row.agrees} for row in self.rows]}

    def __str__(self) -> str:
        return "; ".join(row.words for row in self.rows)
