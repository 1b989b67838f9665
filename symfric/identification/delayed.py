"""Predictions for records whose clocks are shifted against the run by unknown times."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symfric.identification.prediction import Prediction, Predictor
from symfric.identification.records import Channel, places
from symfric.identification.unknowns import Unknowns
from symfric.model.scene import Scene

FINER, FEWEST, MOST = 3, 600, 6000  # samples of the run for each one of a record, and their number


@dataclass(frozen=True, eq=False)
class Delayed:
    """Predictions at the times of the records less a shift of each record, from runs sampled more finely.

    Attributes
    ----------
    predictor : Predictor
        Without shifts.
    reach : float
        Largest size of a shift.
    low, high : ndarray, shape (n_channels,)
        Bounds of the shifts; samples earlier than an upper bound have no prediction for all of them and must not count.
    """

    predictor: Predictor
    reach: float
    low: np.ndarray
    high: np.ndarray

    @cached_property
    def fine(self) -> Predictor:
        """The predictor of the finer samples, from the start of the run until after the end of the records."""
        finer = []
        for c in self.predictor.channels:
            count = int(np.clip(FINER * c.t.size, FEWEST, max(MOST, c.t.size)))
            t = np.linspace(0.0, float(c.t[-1]) + self.reach, count)
            finer.append(replace(c, t=t, y=np.zeros(count), sigma=None))
        return replace(self.predictor, channels=tuple(finer))

    def between(self, low: Sequence[float], high: Sequence[float]) -> "Delayed":
        """Return the same with other bounds of the shifts; the finer samples are shared."""
        wider = replace(self, low=np.array(low, dtype=float), high=np.array(high, dtype=float))
        wider.__dict__["fine"] = self.fine
        return wider

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Measured channels."""
        return self.predictor.channels

    @cached_property
    def rows(self) -> tuple[slice, ...]:
        """Place of each channel in the predictions."""
        return places(self.channels)

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(self.rows[-1].stop)

    @cached_property
    def unknowns(self) -> Unknowns:
        """Unknowns of the predictor, then the shifts."""
        own, n = self.predictor.unknowns, len(self.channels)
        return Unknowns(
            (*own.names, *(f"{c.key}.shift" for c in self.channels)),
            np.concatenate([own.low, self.low]),
            np.concatenate([own.high, self.high]),
            (*own.targets, *((),) * n),
            np.concatenate([own.logarithmic, np.zeros(n, dtype=bool)]),
        )

    def scenes_at(self, values: np.ndarray) -> dict[str, Scene]:
        """Return the scenes of the user with the values of a fit."""
        return self.predictor.scenes_at(values[: self.predictor.unknowns.size])

    def at(self, values: np.ndarray, differences: bool = True) -> Prediction:
        """Return the predictions for one set of values and shifts with their derivatives."""
        from scipy.interpolate import CubicSpline  # slow to import

        n_p = self.predictor.unknowns.size
        sampled = self.fine.at(values[:n_p], differences)
        y, slopes = np.full(self.size, np.nan), np.zeros((self.size, values.size))
        for k, (channel, rows, fine) in enumerate(zip(self.channels, self.rows, self.fine.rows, strict=True)):
            if np.all(np.isfinite(sampled.y[fine])):
                table = np.column_stack([sampled.y[fine], np.nan_to_num(sampled.slopes[fine])])
                curve, t = CubicSpline(self.fine.channels[k].t, table), channel.t - values[n_p + k]
                t = np.maximum(t, 0.0)
                here = curve(t)
                y[rows], slopes[rows, :n_p] = here[:, 0], here[:, 1:]
                slopes[rows, n_p + k] = -curve(t, 1)[:, 0]
        return Prediction(y, slopes, sampled.sequence, sampled.secants)

    def many(self, values: np.ndarray) -> np.ndarray:
        """Return the predictions for many sets of values and shifts, shape (n, n_p) to (samples, n)."""
        n_p = self.predictor.unknowns.size
        sampled = self.fine.many(values[:, :n_p])
        y = np.full((self.size, len(values)), np.nan)
        for k, (channel, rows, fine) in enumerate(zip(self.channels, self.rows, self.fine.rows, strict=True)):
            for j, row in enumerate(values):
                y[rows, j] = np.interp(channel.t - row[n_p + k], self.fine.channels[k].t, sampled[fine, j])
        return y
