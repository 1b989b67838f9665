"""Answers in many digits: Taylor series in multiple-precision arithmetic, independent of every route and peer."""

from dataclasses import dataclass, fields

import mpmath as mp

from symfric.bench.problems import Oscillator

_ORDER = 40
_SAMPLES = 48  # of the guard on a step; the series are smooth on it, and no problem here grazes


@dataclass(frozen=True)
class Reference:
    """Final state in `digits` digits, and the events on the way."""

    x: mp.mpf
    u: mp.mpf
    events: int
    t: mp.mpf


def reference(oscillator: Oscillator, digits: int = 40) -> Reference:
    """Solve the problem with series of order 40 and steps whose last term is below rounding.

    Parameters
    ----------
    oscillator : Oscillator
        Its floats are read as the decimal numbers they print as.
    digits : int
        Working precision.

    Raises
    ------
    NotImplementedError
        If a forced mass sticks; no problem of the benchmark does.
    """
    with mp.workdps(digits):
        numbers = {f.name: _exact(getattr(oscillator, f.name)) for f in fields(oscillator)}
        return _continuous(numbers) if oscillator.v_s else _set_valued(numbers)


def _exact(value):
    return value if isinstance(value, bool | mp.mpf) else mp.mpf(repr(value))


def _set_valued(n: dict) -> Reference:
    """Run the law with its jump: slip until w = 0, then cross or stick by the forces."""
    t, x, u, events = mp.mpf(0), n["x0"], mp.mpf(0), 0
    known, sign = _known_roots(n, t, x, u)
    while True:
        while sign:  # slip
            t, x, u, crossed = _step(n, t, x, u, _outer(n, sign), [(sign, 0, known)])
            known = 0
            if t >= n["horizon"]:
                return Reference(x, u, events, t)
            if crossed is not None:
                u, events = n["v_b"], events + 1
                known, sign = _known_roots(n, t, x, u)
        if n["v_b"] == 0 and not n["a"]:
            return Reference(x, u, events, t)
        if n["a"]:
            raise NotImplementedError("a forced mass sticks; the reference has no rule for that")
        release = (n["mu_s"] - 2 * n["beta"] * n["v_b"] - x) / n["v_b"]
        if t + release >= n["horizon"]:
            return Reference(x + n["v_b"] * (n["horizon"] - t), u, events, n["horizon"])
        t, x, events, known, sign = t + release, x + n["v_b"] * release, events + 1, 2, -1


def _known_roots(n: dict, t, x, u) -> tuple[int, int]:
    """Roots of the guard at the start, and the direction of slip; 0 sticks."""
    if u != n["v_b"]:
        return 0, 1 if u > n["v_b"] else -1
    pull = -2 * n["beta"] * u - x + n["a"] * n["Omega"] ** 2 * mp.sin(n["Omega"] * t)
    if abs(pull) <= n["mu_s"]:
        return 0, 0
    return 1, 1 if pull > 0 else -1


def _continuous(n: dict) -> Reference:
    """Run the regularised law: the line within v_s, the cubic outside; its kinks are the guards."""
    t, x, u, v_s = mp.mpf(0), n["x0"], mp.mpf(0), n["v_s"]
    w = u - n["v_b"]
    zone = 0 if abs(w) < v_s else (1 if w > 0 else -1)
    known: dict[int, int] = {}  # roots of the guards at the start
    while t < n["horizon"]:
        if zone:
            guards = [(zone, -v_s, known.get(zone, 0))]  # zone * w - v_s > 0
            t, x, u, crossed = _step(n, t, x, u, _outer(n, zone), guards)
            left, zone = zone, zone if crossed is None else 0
        else:
            guards = [(-1, v_s, known.get(1, 0)), (1, v_s, known.get(-1, 0))]  # v_s -+ w > 0
            t, x, u, crossed = _step(n, t, x, u, _inner(n), guards)
            left = zone = 0 if crossed is None else (1, -1)[crossed]
        known = {}
        if crossed is not None:
            known = {left: 1}
            u = n["v_b"] + left * v_s
    return Reference(x, u, 0, t)


def _outer(n: dict, sign: int):
    """Friction of a slipping contact, one Taylor coefficient after the other from those of w."""
    y: list[mp.mpf] = []
    y2: list[mp.mpf] = []

    def following(w_k):
        k = len(y)
        y.append(sign * w_k - (0 if k else n["v_s"]))
        mu = n["c1"] * y[k] + (0 if k else n["mu_s"])
        if n["c3"]:
            y2.append(mp.fdot((y[i], y[k - i]) for i in range(k + 1)))
            mu += n["c3"] * mp.fdot((y2[i], y[k - i]) for i in range(k + 1))
        return sign * mu

    return following


def _inner(n: dict):
    """Friction on the steep line of the regularised law."""
    return lambda w_k: w_k * n["mu_s"] / n["v_s"]


def _series(n: dict, t, x, u, friction) -> tuple[list, list]:
    """Coefficients of x and u."""
    xs, us = [x], [u]
    factor = n["a"] * n["Omega"] ** 2
    waves = (mp.sin(n["Omega"] * t), mp.cos(n["Omega"] * t))
    for k in range(_ORDER):
        pull = factor * waves[k % 2] * (-1) ** (k // 2)
        factor *= n["Omega"] / (k + 1)
        brake = friction(us[k] - (0 if k else n["v_b"]))
        xs.append(us[k] / (k + 1))
        us.append((pull - 2 * n["beta"] * us[k] - xs[k] - brake) / (k + 1))
    return xs, us


def _step(n: dict, t, x, u, friction, guards: list):
    """Advance by one step or to the first guard that falls; a guard is (factor, offset, roots known at the start)."""
    xs, us = _series(n, t, x, u, friction)
    last = max(abs(c) / max(abs(us[0]), abs(xs[0]), mp.mpf("0.1")) for c in (us[-1], us[-2]))
    h = mp.mpf("0.5") if last == 0 else min(mp.mpf("0.5"), (mp.eps / last) ** (mp.mpf(1) / (_ORDER - 1)))
    h = min(h, n["horizon"] - t)
    first, which = h, None
    for k, (factor, offset, known) in enumerate(guards):
        poly = [factor * c for c in us]
        poly[0] += offset - factor * n["v_b"]
        root = _first_root(poly[known:], h)
        if root is not None and root < first:
            first, which = root, k
    return t + first, mp.polyval(xs[::-1], first), mp.polyval(us[::-1], first), which


def _first_root(poly: list, h):
    """Return the first change of sign on (0, h], refined to rounding."""
    value = lambda s: mp.polyval(poly[::-1], s)  # noqa: E731
    low, sign = mp.mpf(0), mp.sign(poly[0])
    for k in range(1, _SAMPLES + 1):
        high = h * k / _SAMPLES
        if mp.sign(value(high)) not in (sign, 0) and sign:
            return mp.findroot(value, (low, high), solver="anderson", tol=mp.eps**2 * 100, verify=False)
        low = high
    return None
