"""Hunting of a positioning stage under PID control: the limit cycle of slips and waits about the target."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.model.symbols import finite, positive
from symfric.search import changes, zero
from symfric.spelling import spelt

_SLIPS = 400  # points of a slip at which its end is looked for, in the time of the slowest decay
_SLOW = 40.0  # times of decay after which a motion has ended


class Hunting(NamedTuple):
    """A symmetric hunting cycle.

    Attributes
    ----------
    offset : float
        Distance from the target at which the stage waits.
    slip_time, stick_time : float
        Lengths of a slip and of a wait.
    period : float
        ``2 (slip_time + stick_time)``.

    Examples
    --------
    >>> import symfric as sf
    >>> cycle = sf.theory.hunting(k_p=4.0, k_d=1.0, k_i=1.0, F_s=1.5, F_c=1.0)
    >>> round(cycle.slip_time, 9), round(cycle.stick_time, 9)
    (1.598243027, 23.079886529)
    """

    offset: float
    slip_time: float
    stick_time: float
    period: float


@spelt
def hunting(*, k_p: float, k_d: float, k_i: float, F_s: float, F_c: float, m: float = 1.0) -> Hunting:
    r"""Limit cycle of a PID-controlled mass with static and Coulomb friction.

    Parameters
    ----------
    k_p, k_d, k_i : float
        Gains on position, velocity and integral of the position, > 0.
    F_s, F_c : float
        Static and Coulomb friction, F_s > F_c >= 0, force.
    m : float
        Mass, > 0.

    Returns
    -------
    Hunting

    Raises
    ------
    NotFound
        If there is none: static friction does not exceed kinetic friction, or the loop is unstable without friction,
        ``k_i >= k_p k_d/m``; there the waits have become short as the gain was raised.
    SceneError
        If a number is out of range.

    Notes
    -----
    The stage waits at X until the integrator pulls with F_s, and slips by :math:`m x''' + k_d x'' + k_p x' + k_i x = 0`
    from :math:`x = X, x' = 0, x'' = -(F_s - F_c)/m`. With phi and psi the solutions from unit position and from unit
    acceleration, it stops at -X if :math:`\phi'\psi = \psi'(\phi + 1)`, and then
    :math:`X = \frac{F_s - F_c}{m}\frac{\psi'}{\phi'}`. The wait takes as long as the integrator needs from the force at
    the stop to F_s. The offset and the slip scale with F_s - F_c; without that difference there is no hunting. See
    Hensen, van de Molengraft and Steinbuch, Automatica 39 (2003) 2131.

    Examples
    --------
    >>> import symfric as sf
    >>> cycle = sf.theory.hunting(k_p=4.0, k_d=1.0, k_i=1.0, F_s=1.5, F_c=1.0)
    >>> round(cycle.offset, 12), round(cycle.period, 9)
    (0.096250811741, 49.356259112)
    """
    given = {"k_p": k_p, "k_d": k_d, "k_i": k_i, "F_s": F_s, "m": m}
    for name, value in given.items():
        positive(value, name)
    if not 0 <= finite(F_c, "F_c") <= F_s:
        raise SceneError(f"F_c is {F_c:g}; it must lie between 0 and F_s = {F_s:g}")
    if F_c == F_s:
        raise NotFound("no hunting: static friction does not exceed Coulomb friction, and every slip ends nearer")
    if k_i * m >= k_p * k_d:
        raise NotFound(f"no hunting: k_i is {k_i:g}, and from k_p k_d/m = {k_p * k_d / m:g} the loop is unstable")
    pull = (F_s - F_c) / m
    slip = _Slip(np.array([[0, 1, 0], [0, 0, 1], [-k_i / m, -k_p / m, -k_d / m]]))
    for t in slip.ends():
        (_, speed_1, bend_1), (_, speed_2, bend_2) = slip(t)
        offset = pull * speed_2 / speed_1
        stopping = offset * bend_1 - pull * bend_2  # acceleration against the slip at its end
        if not offset > 0 or slip.stops_before(t, offset, pull):
            continue
        wait = (F_s + F_c - m * stopping) / (k_i * offset)
        if not wait > 0:
            break
        return Hunting(float(offset), float(t), float(wait), float(2 * (t + wait)))
    raise NotFound("no hunting: no slip ends at rest as far beyond the target as it began before it")


class _Slip:
    """The solutions of the slip from unit position and from unit acceleration, with two derivatives each."""

    def __init__(self, matrix: np.ndarray):
        self.matrix = matrix
        self.rates = np.linalg.eigvals(matrix)

    def __call__(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        from scipy.linalg import expm

        flow = expm(self.matrix * t)
        return flow[:, 0], flow[:, 2]

    def ends(self) -> Iterator[float]:
        """Yield the times at which a slip may end opposite to its start, increasing."""

        def gap(t: float) -> float:
            (place_1, speed_1, _), (place_2, speed_2, _) = self(t)
            return float(speed_1 * place_2 - speed_2 * (place_1 + 1))

        fast = np.max(np.abs(self.rates))
        last = _SLOW / np.min(-self.rates.real)
        grid = np.unique(np.concatenate([np.linspace(0, 20 / fast, _SLIPS), np.geomspace(20 / fast, last, _SLIPS)]))[1:]
        values = np.array([gap(t) for t in grid])
        for k in changes(values):
            yield zero(gap, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-15)

    def stops_before(self, t: float, offset: float, pull: float) -> bool:
        """Whether the velocity is zero before the end."""
        times = np.linspace(0, t, _SLIPS)[1:-1]
        speeds = [offset * first[1] - pull * second[1] for first, second in map(self, times)]
        return bool(np.any(np.array(speeds) >= 0))
