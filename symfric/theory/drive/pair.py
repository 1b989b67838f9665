"""Two slides in contact: linear flows between events, and periodic orbits with one stick composed of them.

With y = (eta1 + fc1, eta2 - r zeta^2 fc1, eta1', eta2'), deviations from steady sliding, forward slip is ``y' = A y``
and sticking ``y' = M y`` with ``w = 1 + h.y = 0``. The friction that sticking needs is ``fc1 + f.y``, and a stick ends
where ``f.y = fs1 - fc1 = delta``: only that difference enters. Slip starts and ends with ``w' = (1 + r) f.y``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symfric.errors import NotFound
from symfric.search import ROUNDING, zero

W = np.array([0.0, 0.0, 1.0, -1.0])  # h
SAMPLES = 2048  # samples of one phase of an orbit
_NEWTON = 40  # most steps of Newton's method
_CLOSED = 1e-15  # relative step at which an orbit is closed to rounding
_STALLED = 1e-9  # relative step below which no further progress means that rounding is reached
_LONGER = 10  # largest factor of a phase against that of the guess; beyond, it is another orbit
_AT_END = 1e-6  # fraction of the slip before its end within which a touch of w = 0 is that end


@dataclass(frozen=True, eq=False)
class Pair:
    """Matrices of the flows.

    Attributes
    ----------
    r, zeta, s1, d2 : float
    slip, stick : ndarray, shape (4, 4)
        A and M.
    load : ndarray, shape (4,)
        f.
    """

    r: float
    zeta: float
    s1: float
    d2: float
    slip: np.ndarray = field(init=False)
    stick: np.ndarray = field(init=False)
    load: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        held = np.array([[1.0, 0.0, 2 * self.s1, 0.0], [0.0, 1 / self.zeta**2, 0.0, 2 * self.d2]])
        common = -(self.r * held[0] + held[1]) / (1 + self.r)  # from r (24)_1 + (24)_2, in which the friction cancels
        rates = np.eye(2, 4, 2)
        object.__setattr__(self, "slip", np.vstack([rates, -held]))
        object.__setattr__(self, "stick", np.vstack([rates, common, common]))
        object.__setattr__(self, "load", (held[1] - held[0]) / (1 + self.r))

    def slipping(self, t: float) -> np.ndarray:
        """Return ``exp(A t)``."""
        from scipy.linalg import expm

        return np.asarray(expm(self.slip * t))

    def sticking(self, t: float) -> np.ndarray:
        """Return ``exp(M t)``, t >= 0, accurate after sticks of any length.

        Notes
        -----
        The common velocity and the force of both springs decay towards those of `ramp`; the place is an integral.
        """
        from scipy.linalg import expm

        r, soft = self.r, 1 / self.zeta**2
        m = np.array([[-2 * (r * self.s1 + self.d2) / (1 + r), -1 / (1 + r)], [r + soft, 0.0]])
        speed = r / (r + soft)
        force = 2 * r * self.s1 - 2 * (r * self.s1 + self.d2) * speed
        to = np.array([[0, 0, 0, 1.0], [r, soft, 0, 0], [0, 0, -1, 1], [1, 0, 0, 0]])
        to[:2] -= np.outer([speed, force], to[2])  # (velocity, force) less those of the ramp, -h.y, y1
        rate = np.min(-np.linalg.eigvals(m).real)
        decay = expm(m * t) if rate * t < 200 else np.zeros((2, 2))
        inner = np.eye(4)
        inner[:2, :2] = decay
        inner[3, :2] = np.linalg.solve(m, decay - np.eye(2))[0]
        inner[3, 2] = (speed - 1) * t
        return np.linalg.solve(to, inner @ to)

    def ramp(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a and b, shape (4,): after a long stick the slip starts at ``y = a + b delta``.

        At the end of the stick both move steadily, ``r eta1' + eta2'/zeta^2 = 0``, without acceleration.
        """
        ratio = self.r * self.zeta**2
        u1, u2 = -1 / (1 + ratio), ratio / (1 + ratio)
        balance = np.array([[-1.0, 1 / self.zeta**2], [self.r, 1 / self.zeta**2]])
        place = np.linalg.solve(
            balance, [2 * self.s1 * u1 - 2 * self.d2 * u2, -2 * self.r * self.s1 * u1 - 2 * self.d2 * u2]
        )
        return np.array([*place, u1, u2]), np.array([-1.0, ratio, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class SlidesOrbit:
    """A closed path of one slip and one stick.

    Attributes
    ----------
    y : ndarray, shape (4,)
        State at the end of the slip.
    slip, stick : float
        Durations of the two phases.
    """

    y: np.ndarray
    slip: float
    stick: float


def path(flow: Callable[..., Any], y: np.ndarray, end: float, number: int = SAMPLES) -> tuple[np.ndarray, np.ndarray]:
    """Return times (n,) and states (4, n) of a flow from y, in n - 1 equal steps."""
    states = y[:, None]
    while (k := states.shape[1]) < number:
        states = np.hstack([states, flow(k * end / (number - 1)) @ states])
    return np.linspace(0.0, end, number), states


def closed(
    pair: Pair, guess: SlidesOrbit, *, landing: float | None = None, release: float | None = None, share: float = 1.0
) -> SlidesOrbit | None:
    """Close an orbit by Newton's method; None if that fails.

    Parameters
    ----------
    guess : SlidesOrbit
    landing, release : float
        One of them: the load f.y at the end of the slip, or at the end of the stick.
    share : float
        Weight of the dependence of the stick on the previous slip, 0 to 1; for the homotopy.

    Notes
    -----
    Six equations for y and the two times: ``exp(A T1) exp(M T2) y = y``, ``h.y = -1`` and the load.
    """
    y, T1, T2 = guess.y, guess.slip, guess.stick
    a, b = pair.ramp()
    keep = share * np.eye(4) + (1 - share) * np.outer(b, pair.load)
    last = np.inf
    for _ in range(_NEWTON):
        E, S = pair.slipping(T1), pair.sticking(T2)
        out = S @ y
        back = E @ (keep @ out + (1 - share) * a)
        load = pair.load @ y - landing if release is None else pair.load @ out - release
        residual = np.array([*(back - y), W @ y + 1, load])
        slope = np.zeros((6, 6))
        slope[:4, :4] = E @ keep @ S - np.eye(4)
        slope[:4, 4], slope[:4, 5] = pair.slip @ back, E @ keep @ pair.stick @ out
        slope[4, :4] = W
        slope[5, :4] = pair.load if release is None else pair.load @ S
        slope[5, 5] = 0.0 if release is None else pair.load @ pair.stick @ out
        if not (np.all(np.isfinite(slope)) and np.all(np.isfinite(residual))):
            return None
        step = np.linalg.lstsq(slope, residual, rcond=1e-15)[0]  # at a graze the equations are singular
        y, T1, T2 = y - step[:4], T1 - step[4], T2 - step[5]
        if not (0 < T1 < _LONGER * guess.slip and 0 < T2 < _LONGER * guess.stick):
            return None
        size = np.max(np.abs(step)) / max(1.0, np.max(np.abs(y)))
        if size < _CLOSED or (size < _STALLED and size >= 0.5 * last):
            return SlidesOrbit(y, float(T1), float(T2))
        last = size
    return None


def landed(pair: Pair, guess: SlidesOrbit, landing: float) -> SlidesOrbit:
    """Close an orbit whose slip ends with a load between those of two closed ones; raise `NotFound` if that fails."""
    orbit = closed(pair, guess, landing=landing)
    if orbit is None:
        raise NotFound(f"the cycle of two slides whose slip ends with the load {landing:.12g} does not close")
    return orbit


def released(pair: Pair, orbit: SlidesOrbit) -> np.ndarray:
    """Return the state in which the stick of an orbit ends, shape (4,)."""
    return np.asarray(pair.sticking(orbit.stick) @ orbit.y)


def difference(pair: Pair, orbit: SlidesOrbit) -> float:
    """Return delta of an orbit."""
    return float(pair.load @ released(pair, orbit))


def slope(pair: Pair, orbit: SlidesOrbit) -> float:
    """Return d delta/d (load where the slip ends) along the family of orbits; zero at grazing and at folds."""
    E, S = pair.slipping(orbit.slip), pair.sticking(orbit.stick)
    out = S @ orbit.y
    system = np.zeros((6, 6))
    system[:4, :4] = E @ S - np.eye(4)
    system[:4, 4], system[:4, 5] = pair.slip @ orbit.y, E @ pair.stick @ out
    system[4, :4], system[5, :4] = W, pair.load
    change = np.linalg.solve(system, np.eye(6)[5])
    return float(pair.load @ (S @ change[:4] + pair.stick @ out * change[5]))


def passes(pair: Pair, orbit: SlidesOrbit, fc1: float) -> bool:
    """Whether an orbit satisfies the friction law: w > 0 during slip, and the load within bounds during stick."""
    out = released(pair, orbit)
    delta = pair.load @ out
    if delta <= 0:
        return False
    t, states = path(pair.slipping, out, orbit.slip)
    rates = (1 + pair.r) * (pair.load @ states)
    dips = np.flatnonzero((rates[1:-2] < 0) & (rates[2:-1] >= 0)) + 1
    for k in dips:
        touch = t[k] - rates[k] * (t[k + 1] - t[k]) / (rates[k + 1] - rates[k])
        if orbit.slip - touch > _AT_END * orbit.slip and 1 + W @ pair.slipping(touch) @ out <= 0:
            return False
    loads = pair.load @ path(pair.sticking, orbit.y, orbit.stick)[1]
    return bool(np.all(loads[:-1] < delta) and np.all(loads > -(2 * fc1 + delta)) and loads[0] <= 1e-9 * delta)


def multipliers(pair: Pair, orbit: SlidesOrbit) -> np.ndarray:
    """Return the two Floquet multipliers that are not identically zero, largest first.

    Notes
    -----
    Where the stick begins, the flows differ by ``k w'`` with k = (0, 0, 1, -r)/(1 + r), so that a deviation v becomes
    ``v - k h.v`` up to a shift in time, which is undone where the stick ends.
    """
    E, S = pair.slipping(orbit.slip), pair.sticking(orbit.stick)
    along = pair.stick @ S @ orbit.y
    begin = np.eye(4) - np.outer([0.0, 0.0, 1 / (1 + pair.r), -pair.r / (1 + pair.r)], W)
    end = np.eye(4) - np.outer(along, pair.load) / (pair.load @ along)
    values = np.linalg.eigvals(end @ S @ begin @ E)
    return values[np.argsort(-np.abs(values))][:2]


def turns(flow: Callable[..., Any], y: np.ndarray, end: float, row: int) -> np.ndarray:
    """Return the values of a coordinate at both ends of a phase and at zeros of its velocity in between."""
    t, states = path(flow, y, end)

    def speed(s: float) -> float:
        return float((flow(s) @ y)[2 + row])

    near = np.flatnonzero(np.diff(np.sign(states[2 + row])) != 0)
    ends = ((t[k], t[k + 1]) for k in near if speed(t[k]) * speed(t[k + 1]) < 0)
    times = [zero(speed, *pair, xtol=1e-14 * end, rtol=ROUNDING) for pair in ends]
    return np.array([y[row], (flow(end) @ y)[row], *((flow(s) @ y)[row] for s in times)])
