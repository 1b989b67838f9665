"""Lyapunov exponents of a motion, from its derivatives by the start with exact saltation at events."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.axes import Axes
from symfric.errors import NotFound
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.results import ArrayResult, Drawable, Labelled
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import positive
from symfric.orbits.cycle import values_of
from symfric.orbits.flow_map import FlowMap, flow_of
from symfric.orbits.passages import Passage
from symfric.orbits.sizes import over_time

LOST = 1e-11  # growth relative to the largest in a piece below which sticking has removed the direction
_BATCHES = 20  # batches of pieces whose means give the spread
_PIECES = 400  # number of pieces of the horizon of a scene without excitation
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)  # golden ratio step, whose multiples are evenly spread modulo 1
# least logarithmic growth that counts as chaos; bounded oscillations of the length can look like less
_GROWTH = np.log(1e3)


@dataclass(frozen=True, eq=False)
class Lyapunov(ArrayResult, Drawable):
    """Lyapunov exponents: mean exponential rates of divergence of neighbouring motions, per unit of time.

    `plot` draws the convergence of the largest exponent.

    Attributes
    ----------
    exponent : float
        The largest.
    spread : float
        Uncertainty of `exponent`: the larger of its standard error, from the means of 20 stretches of the motion, and
        of what a whole number of turns more or less would change, the range over which the logarithm of the growth
        swings about its trend, over the time.
    exponents : ndarray, shape (n_x,)
        All, by falling value; -inf for a direction that is lost, because a contact sticks.
    times : ndarray, shape (n,)
        Since the end of the transient, at the end of every piece of the motion.
    history : ndarray, shape (n,)
        The estimate of `exponent` from the motion so far.
    end : ndarray, shape (n_x,)
        The last state, of a forced scene at a whole number of periods; to go on from there.
    doubtful : int
        Pieces in which the derivatives do not exist: the motion grazes, or two events come at one time. Their growth
        counts as the formulas give it.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> found = sf.lyapunov(belt, 200.0)
    >>> abs(found.exponent) < 0.05
    True
    >>> sorted(found.to_dict())[:2]
    ['doubtful', 'exponent']
    >>> len(found.to_xarray().data_vars) > 0
    True
    >>> ax = found.plot()
    """

    exponent: float
    spread: float
    exponents: np.ndarray
    times: np.ndarray
    history: np.ndarray
    end: np.ndarray
    doubtful: int

    def _labelled(self) -> Labelled:
        about = {"exponent": self.exponent, "spread": self.spread, "doubtful": self.doubtful}
        return {"history": ("t", self.history)}, {"t": self.times}, about

    @property
    def chaotic(self) -> bool:
        """Whether the largest exponent is positive by more than three times its spread, over a growth of 1000 or more.

        A growth of less than that may be a swing that a longer window would show as one: give a longer horizon.
        """
        return bool(self.exponent > 3 * self.spread and self.exponent * self.times[-1] > _GROWTH)

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.orbits.plotting import plot_lyapunov

        return plot_lyapunov(self, ax)

    def to_dict(self) -> dict[str, Any]:
        told = {"exponent": self.exponent, "spread": self.spread, "exponents": self.exponents.tolist()}
        return {**told, "time": float(self.times[-1]), "doubtful": self.doubtful}

    def __repr__(self) -> str:
        doubt = f", {self.doubtful} pieces without derivatives" if self.doubtful else ""
        return f"Lyapunov({self.exponent:.6g} +- {self.spread:.2g}, over {self.times[-1]:.6g}{doubt})"


@logged
def lyapunov(
    scene: Scene,
    horizon: float | None = None,
    *,
    transient: float | None = None,
    piece: float | None = None,
    tolerance: float = 1e-10,
) -> Lyapunov:
    """Compute the Lyapunov exponents of a scene.

    Parameters
    ----------
    scene : Scene
        Autonomous, or excited by sines and cosines of time with a common period.
    horizon : float, optional
        Time over which the growth is averaged; that of the scene unless given.
    transient : float, optional
        Time before that, which is left out; a fifth of the horizon unless given.
    piece : float, optional
        Time between two renormalisations. For a forced scene it is rounded to whole periods of the excitation, one
        unless given; otherwise it varies about 1/400 of the horizon unless given.
    tolerance : float
        Tolerance of the motion and its derivatives.

    Returns
    -------
    Lyapunov

    Raises
    ------
    NotFound
        If the motion ends early.
    SceneError
        If the excitation has no period, or a time is wrong.

    Notes
    -----
    The derivatives of a piece by its start, with the saltation at every event, carry an orthonormal basis; its QR
    decomposition gives the growth ``ln R_kk`` of each direction (Benettin, Galgani, Giorgilli and Strelcyn, Meccanica
    15, 1980, 9-30). All directions are carried, since the first one may be among those that sticking takes away. An
    autonomous motion that does not come to rest keeps the direction along itself, whose exponent is 0: a stable limit
    cycle has 0, a stable forced one something negative. If sticking takes all directions away, neighbouring motions
    become one and the same, and the largest exponent is -inf. A body that friction holds for good may rest anywhere
    within bounds: its exponent is 0.

    Growth is that of a length in which every state is measured in units of its range: the sum of metres and metres per
    second is none. The exponents of an infinite time do not depend on it.

    The growth along a cycle swings with its period. Pieces of one length may be nearly whole periods; then their ends
    see but one phase of the swing, and its rise over the window passes for growth. So the lengths vary from piece to
    piece and the ends meet all phases alike, and the spread holds the swing.

    Every piece starts where the last one ended, so that one call uses one processor; exponents for many values are
    calls of their own, from several threads if need be.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> sf.lyapunov(belt, 200.0).chaotic
    False
    """
    check_scene(scene)
    values, flow = values_of(scene), flow_of(scene, (), tolerance)
    horizon = scene.horizon if horizon is None else positive(horizon, "horizon")
    period = flow.period(values) if flow.period else None
    length = positive(piece, "piece") if piece is not None else period or horizon / _PIECES
    length = max(1, round(length / period)) * period if period else length
    count = max(1, int(np.ceil(horizon / length - 1e-9)))
    skipped = positive(0.2 * horizon if transient is None else transient, "transient", zero=True)
    skipped = int(np.ceil(skipped / length - 1e-9))
    numbers = scene.numbers()
    start = np.array([numbers[s] for s in scene.system.states])
    lengths = np.full(skipped + count, length)
    if piece is None and not period:
        lengths = np.concatenate([_varied(length, n) for n in (skipped, count)])
    growth, end, doubtful = _grow(flow, values, start, lengths, skipped)
    return _summed(growth, np.cumsum(lengths[skipped : skipped + len(growth)]), end, doubtful)


def _varied(length: float, n: int) -> np.ndarray:
    """Return n lengths between 0.5 and 1.5 times the given one, with that mean and with sums spread over all phases."""
    parts = 0.5 + (np.arange(n) * _GOLDEN) % 1.0
    return np.asarray(n * length * parts / max(np.sum(parts), 0.5))


def _grow(
    flow: FlowMap, values: dict[str, float], y: np.ndarray, lengths: np.ndarray, skipped: int
) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the growth of every direction in every piece after the transient (n, n_x), last state, doubtful ones."""
    slopes, low, high, doubtful, done = np.empty((lengths.size, y.size, y.size)), y, y, 0, 0
    with until_interrupted("lyapunov"):
        for k, length in enumerate(lengths.tolist()):
            tell("", k / lengths.size)
            passage = _passage(flow, values, y, length, np.sum(lengths[:k]))
            if k >= skipped:
                low = np.minimum(low, passage.low) if k > skipped else passage.low
                high = np.maximum(high, passage.high) if k > skipped else passage.high
                doubtful += passage.doubtful
            y, slopes[k], done = passage.end, passage.by_start, k + 1
    if done <= skipped:
        raise KeyboardInterrupt  # within the transient: there is nothing to keep
    size = over_time(high - low, len(flow.scene.system.q), np.sum(lengths[:done]))
    return _growth_of(slopes[:done] * size / size[:, None])[skipped:], y, doubtful


def _passage(flow: FlowMap, values: dict[str, float], y: np.ndarray, length: float, after: float) -> Passage:
    """Return the motion over a piece, with its derivatives."""
    try:
        passage = flow.run(y, values, length)
    except NotFound as reason:
        raise NotFound(f"no Lyapunov exponents: {reason}, after t = {after:g}") from None
    if not np.all(np.isfinite(passage.by_start)):
        raise NotFound(f"the motion has no derivatives by its start: it grazes after t = {after:g}")
    return passage


def _growth_of(slopes: np.ndarray) -> np.ndarray:
    """Return the growth of every direction under a sequence of maps, (n, n_x, n_x), by QR factorisation."""
    basis, growth = np.eye(slopes.shape[1]), np.empty(slopes.shape[:2])
    for k, slope in enumerate(slopes):
        basis, R = np.linalg.qr(slope @ basis)
        size = np.abs(np.diag(R))
        with np.errstate(divide="ignore"):
            growth[k] = np.log(np.where(size <= LOST * np.max(size), 0.0, size))
    return growth


def _summed(growth: np.ndarray, times: np.ndarray, end: np.ndarray, doubtful: int) -> Lyapunov:
    """Return means, convergence and spread of the growth rates, from the growth per piece (n, n_x)."""
    exponents = np.sum(growth, axis=0) / times[-1]
    largest = growth[:, int(np.argmax(exponents))]
    total = np.cumsum(largest)
    spread = _spread(total, times) if np.isfinite(total[-1]) else 0.0
    history = total / times
    return Lyapunov(float(history[-1]), spread, -np.sort(-exponents), times, history, end, doubtful)


def _spread(total: np.ndarray, times: np.ndarray) -> float:
    """Return the uncertainty of a mean growth rate, from the logarithm of the growth at some times, (n,)."""
    if times.size < 2:
        return np.inf
    edges = np.linspace(0, times.size, min(times.size, _BATCHES) + 1).round().astype(int)
    means = np.diff(np.append(0.0, total)[edges]) / np.diff(np.append(0.0, times)[edges])
    error = np.std(means, ddof=1) / np.sqrt(means.size)
    swing = np.ptp(np.append(0.0, total - total[-1] * times / times[-1])) / times[-1]
    return float(max(error, swing))
