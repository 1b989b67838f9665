"""Closed-form orbits of ``w'' + 2 mu(w) w' + w = 0``, where mu has one value below a corner of w and another above.

With w = x' this is the slide on a piecewise-linear friction characteristic: differentiating its equation of motion
removes the constant forces, and w' does not jump at the corner, because the friction is continuous there.
"""

import math
from dataclasses import dataclass, field
from typing import Any

from symfric.errors import SceneError
from symfric.model.symbols import finite
from symfric.search import ROUNDING, zero

STEEPEST = 1e12  # largest slope mu for which the closed forms were verified


def slope(value: Any, name: str) -> float:
    """Return a slope mu as a float; raise if it is out of range."""
    mu = finite(value, name)
    if abs(mu) > STEEPEST:
        raise SceneError(f"{name} is {mu:g}; slopes up to {STEEPEST:g} in size are taken")
    return mu


@dataclass(frozen=True)
class FreeResponse:
    """Solutions of ``w'' + 2 mu w' + w = 0``: ``w = w0 A + v0 S`` and ``w' = v0 S' - w0 S``.

    S is the response to a unit impulse, A the one to a unit displacement. ``w = w0 + v0 S - w0 I`` with the integral
    I = 1 - A of S gives a small change of w without cancellation.

    Attributes
    ----------
    mu : float
        Damping ratio; any real number.
    omega, q : float
        ``sqrt(1 - mu^2)`` and ``sqrt(mu^2 - 1)``, 0 where not real.
    slow, fast : float
        The decay rates mu - q and mu + q where overdamped.
    """

    mu: float
    omega: float = field(init=False)
    q: float = field(init=False)
    slow: float = field(init=False)
    fast: float = field(init=False)

    def __post_init__(self) -> None:
        # the square roots of both factors avoid the cancellation of 1 - mu^2 at |mu| = 1, and overflow
        side = 1 - abs(self.mu)
        omega, q = (math.sqrt(max(e, 0.0)) * math.sqrt(1 + abs(self.mu)) for e in (side, -side))
        large = abs(self.mu) + q
        slow, fast = (1 / large, large) if self.mu > 0 else (-large, -1 / (large or 1.0))  # their product is 1
        for name, value in {"omega": omega, "q": q, "slow": slow, "fast": fast}.items():
            object.__setattr__(self, name, value)

    def responses(self, s: float) -> tuple[float, float, float, float, float]:
        """Return S, A, I and S' after time s, multiplied by the fifth value, a factor <= 1 against overflow."""
        mu, omega, q = self.mu, self.omega, self.q
        if q > 0:
            down = min(self.slow, 0.0) * s
            S = math.exp(down - self.slow * s) * -math.expm1(-2 * q * s) / (2 * q)
            slope = math.exp(down - self.fast * s) - self.slow * S
            small = min(self.slow, self.fast, key=abs)
            A = math.exp(down - small * s) + small * S
        else:
            down = min(mu, 0.0) * s
            decay = math.exp(down - mu * s)
            S = decay * (math.sin(omega * s) / omega if omega > 0 else s)
            A, slope = (decay * math.cos(omega * s) + sign * mu * S for sign in (1, -1))
        scale = math.exp(down)
        if (1 + abs(mu)) * s < 0.1:
            integral = scale * self._series(s)
        elif q > 0.5:
            integral = (_ramp(self.slow, s, down) - _ramp(self.fast, s, down)) / (2 * q)
        else:
            integral = scale - A
        return S, A, integral, slope, scale

    def _series(self, s: float) -> float:
        """Return I for small s, where the closed form cancels; ``n (n + 1) c_(n+1) = -2 mu n c_n - c_(n-1)`` for S."""
        before, c, power, total = 0.0, 1.0, s * s, 0.0
        for n in range(1, 14):
            total += c * power / (n + 1)
            before, c = c, (-2 * self.mu * n * c - before) / (n * (n + 1))
            power *= s
        return total

    def gap(self, w: float, v: float, s: float, level: float) -> float:
        """Return w - level at time s from (w, v), times a positive factor."""
        S, A, integral, _, scale = self.responses(s)
        if abs(level) < abs(level - w):
            return w * A + v * S - level * scale
        return v * S - w * integral - (level - w) * scale

    def rate(self, w: float, v: float, s: float) -> float:
        """Return w' after time s from (w, v); infinite beyond the largest float."""
        S, _, _, slope, scale = self.responses(s)
        number = v * slope - w * S
        return number / scale if abs(number) < 1.7e308 * scale else math.copysign(math.inf, number)

    def turn(self, w: float, v: float) -> float:
        """Return the time from (w, v >= 0), rising, until w' vanishes; infinite if it does not.

        Notes
        -----
        ``v S' = w S``: ``tan(omega s) = omega v/(w + mu v)``, or tanh where overdamped.
        """
        if self.omega > 0:
            return math.atan2(v * self.omega, w + self.mu * v) / self.omega
        if v == 0:
            return 0.0 if w > 0 else math.inf
        if self.q == 0:
            return v / (w + self.mu * v) if w + self.mu * v > 0 else math.inf
        rest = w + self.slow * v
        return math.log1p(2 * self.q * v / rest) / (2 * self.q) if rest > 0 else math.inf


def _ramp(rate: float, s: float, down: float) -> float:
    """Return ``exp(down) (1 - exp(-rate s))/rate`` without overflow."""
    if rate > 0:
        return math.exp(down) * -math.expm1(-rate * s) / rate
    return math.exp(down - rate * s) * math.expm1(rate * s) / rate


def rise(flow: FreeResponse, w: float, v: float, level: float) -> float | None:
    """Return the speed at which the orbit that rises from (w, v >= 0) reaches a level above w; None if it turns first.

    An overdamped orbit that tends to w = 0 has no turning point, and reaches no level above.
    """
    end = flow.turn(w, v)
    if end == math.inf:
        if flow.mu > 0 and level >= 0:
            return None
        end = 1.0
        while flow.gap(w, v, end, level) < 0:
            end *= 2
    elif flow.gap(w, v, end, level) < 0:
        return None
    return max(flow.rate(w, v, _crossing(flow, w, v, level, 0.0, end)), 0.0)


def fall(flow: FreeResponse, w: float, v: float) -> float | None:
    """Return the speed < 0 at which the orbit that leaves w upwards with v >= 0 returns to w.

    None if it decays towards 0 without returning; infinite if it grows without turning.
    """
    top = flow.turn(w, v)
    if top == math.inf:
        return math.inf if flow.mu < 0 else None
    if flow.omega > 0:
        end = top + math.pi / flow.omega
        if flow.gap(w, v, end, w) >= 0:
            return None
    else:
        if flow.mu > 0 and w <= 0:
            return None
        end = 2 * top
        while flow.gap(w, v, end, w) >= 0:
            end *= 2
    return flow.rate(w, v, _crossing(flow, w, v, w, top, end))


def _crossing(flow: FreeResponse, w: float, v: float, level: float, start: float, end: float) -> float:
    return zero(lambda s: flow.gap(w, v, s, level), start, end, rtol=ROUNDING, most=5000)


def excursion(floor: float, v: float, corner: float, inner: float, outer: float) -> tuple[float, bool]:
    """Compute the orbit that leaves w = `floor` upwards with ``w' = v`` >= 0 until it returns.

    Parameters
    ----------
    floor, v, corner : float
        ``floor < corner``.
    inner, outer : float
        Slopes mu below and above the corner.

    Returns
    -------
    speed : float
        ``|w'|`` on return: 0 if the orbit turns back before the floor or only tends to it, infinite if it never turns.
    crossed : bool
        Whether it passed the corner.
    """
    below = FreeResponse(inner)
    up = rise(below, floor, v, corner)
    if not up:
        return abs(fall(below, floor, v) or 0.0), False
    down = abs(fall(FreeResponse(outer), corner, up) or 0.0)
    return (descent(below, corner, down, floor) if math.isfinite(down) else down), True


def descent(flow: FreeResponse, level: float, v: float, floor: float) -> float:
    """Return ``|w'|`` at the floor of the orbit that leaves a level with ``w' = -v`` <= 0; 0 if it never reaches it."""
    return rise(flow, -level, v, -floor) or 0.0
