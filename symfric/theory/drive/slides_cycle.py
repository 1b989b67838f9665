"""Limit cycle of two slides: one slip and one stick in each period."""

from dataclasses import dataclass, field

import numpy as np

from symfric.model.results import COMPLEX, Result


@dataclass(frozen=True, eq=False, repr=False)
class SlidesCycle(Result):
    """Limit cycle of two slides with one stick in each period.

    Attributes
    ----------
    fs1 : float
        Static friction over ``m1 omega1 v``.
    slip_time, stick_time : float
        Durations in units of 1/omega1.
    ranges : tuple of two floats
        Largest less smallest eta1, and eta2.
    landing, release : ndarray, shape (4,)
        (eta1, eta2, eta1', eta2') where the stick begins and ends.
    multipliers : ndarray of complex, shape (2,)
        Floquet multipliers, largest first; the others are zero.
    end : {"", "grazing", "longer slip", "fold", "inner grazing"}
        At the smallest fs1, why this cycle does not exist below. "grazing": the end of the slip only touches w = 0, and
        a slip that misses it dies out; "longer slip": it comes back later, and cycles of several slips go on below;
        "fold": the cycle meets an unstable one; "inner grazing": an earlier part of the slip touches w = 0.

    Examples
    --------
    >>> import symfric as sf
    >>> pair = dict(r=0.5, zeta=2, s1=0.2, s2=0.3)
    >>> cycle = sf.theory.drive.two_slides_cycle(**pair, fs1=7.8)
    >>> round(cycle.period, 6)
    30.525932
    >>> "period" in cycle.to_dict()
    True
    """

    fs1: float
    slip_time: float
    stick_time: float
    ranges: tuple[float, float]
    landing: np.ndarray
    release: np.ndarray
    multipliers: np.ndarray = field(metadata=COMPLEX)
    end: str = ""
    _told = ("fs1", "period", "stick_fraction", "ranges", "landing", "release", "multipliers", "stable", "end")

    @property
    def period(self) -> float:
        """Duration of one slip and one stick."""
        return self.slip_time + self.stick_time

    @property
    def stick_fraction(self) -> float:
        """Fraction of the period in which the slides stick."""
        return self.stick_time / self.period

    @property
    def stable(self) -> bool:
        """Whether both multipliers are below 1 in size."""
        return bool(np.all(np.abs(self.multipliers) < 1))

    def __repr__(self) -> str:
        end = f", {self.end}" if self.end else ""
        return f"SlidesCycle(fs1 {self.fs1:.10g}, period {self.period:.10g}, sticking {self.stick_fraction:.6g}{end})"
