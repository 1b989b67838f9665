"""Sampled inputs as functions that are straight lines between some times."""

from collections.abc import Sequence

import numpy as np

from symfric.model.system import Signal


def segments(signals: Sequence[Signal], horizon: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the times at which an input changes its slope or jumps, and value and slope of the inputs from each on.

    Returns
    -------
    times : ndarray, shape (n + 1,)
        Increasing from 0, the last one infinite.
    data : ndarray, shape (n, 3 * number of signals)
        Start, value at the start, and slope of every signal; value and slope are zero outside its samples.
    """
    grids = [s.t0 + s.dt * np.arange(s.samples.size + s.hold) for s in signals]
    times = np.unique(np.concatenate([np.zeros(1), *grids]))
    times = times[(times >= 0) & (times < horizon)]
    data = np.zeros((times.size, 3 * len(signals)))
    for k, s in enumerate(signals):
        index = np.floor((times - s.t0) / s.dt + 1e-9).astype(int)
        pieces = s.samples.size - (not s.hold)
        inside = (index >= 0) & (index < pieces)
        at = np.clip(index, 0, pieces - 1)
        data[:, 3 * k] = s.t0 + s.dt * at
        data[:, 3 * k + 1] = np.where(inside, s.samples[at], 0.0)
        if not s.hold:
            data[:, 3 * k + 2] = np.where(inside, (s.samples[at + 1] - s.samples[at]) / s.dt, 0.0)
    return np.append(times, np.inf), data
