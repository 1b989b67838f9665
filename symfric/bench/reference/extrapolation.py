"""Answers in many digits for written-out scenes: extrapolated midpoint rule in multiple-precision arithmetic."""

import mpmath as mp
import sympy as sp

from symfric.bench.peers.written_out import Form, Loop, form_of
from symfric.bench.result import Answer
from symfric.model.scene import Scene

_COLUMNS = 14  # of the extrapolation: order 28
_LONGEST = 0.1  # step; guards are looked at where steps end
_GUARD = 4  # digits kept beyond those asked for


def solved(scene: Scene, digits: int = 24) -> Answer:
    """Return the final state and the number of events, independent of every route and peer.

    Parameters
    ----------
    scene : Scene
        See `symfric.bench.peers.written_out.form_of`; its floats are taken as the binary numbers they are.
    digits : int
        Of the steps and events.

    Notes
    -----
    Gragg's midpoint rule, extrapolated by Aitken and Neville in the square of the step (Hairer, Norsett and Wanner,
    Solving Ordinary Differential Equations I, section II.9). Events by the Illinois method on whole steps.
    """
    with mp.workdps(digits + _GUARD):
        form = form_of(scene)
        return Loop(form, _Stepper(form, mp.mpf(10) ** -digits), "mpmath", mp.mpf)()


class _Stepper:
    """Goes from event to event; what `Loop` takes."""

    def __init__(self, form: Form, tolerance):
        self._rates = sp.lambdify(form.arguments, list(form.rates), "mpmath", cse=True)
        self._guards = sp.lambdify(form.arguments, list(form.guards), "mpmath", cse=True)
        self._tolerance, self._h = tolerance, mp.mpf(_LONGEST)

    def __call__(self, t, y, mode, line, end):
        constants, fresh = (*mode, *line), True
        while True:
            h = min(self._h, end - t)
            new, error = self._step(t, y, constants, h)
            if error > self._tolerance:
                self._h = h * max(mp.mpf("0.1"), 0.8 * (self._tolerance / error) ** (mp.mpf(1) / (2 * _COLUMNS - 1)))
                continue
            fell = [k for k, g in enumerate(self._guards(t + h, *new, *constants)) if g < 0]
            if fell:
                # a guard that starts at zero rises first: the root looked for is the last one
                roots = {k: self._root(t, y, constants, h, k, fresh) for k in fell}
                first = min(roots, key=lambda k: roots[k])
                return t + roots[first], self._step(t, y, constants, roots[first])[0], first
            t, y, fresh = t + h, new, False
            grown = (self._tolerance / error) ** (mp.mpf(1) / (2 * _COLUMNS - 1)) if error else mp.mpf(2)
            self._h = min(mp.mpf(_LONGEST), max(self._h, h * min(mp.mpf(2), 0.8 * grown)))
            if t >= end:
                return end, y, None

    def _root(self, t, y, constants, h, k, fresh):
        value = lambda s: self._guards(t + s, *self._step(t, y, constants, s)[0], *constants)[k]  # noqa: E731
        low = mp.mpf(0)
        while fresh and value(low) <= 0:
            low = (low + h) / 8 if low == 0 else (low + h) / 2
        return mp.findroot(value, (low, h), solver="illinois", tol=self._tolerance**2, verify=False)

    def _step(self, t, y, constants, h):
        """Return the state after h and the difference of the last two columns."""
        final, before = midpoint(lambda at, now: self._rates(at, *now, *constants), t, y, h, _COLUMNS)
        return final, max(abs(a - b) for a, b in zip(final, before, strict=True))


def midpoint(rate, t, y: list, h, columns: int) -> tuple[list, list]:
    """Extrapolate Gragg's midpoint rule over a step h; return the state of the last column and of the one before.

    ``rate(t, y)`` is asked at the start once, and then, column after column, at the inner nodes and the end of each.
    """
    row: list[list] = []
    start = rate(t, y)
    for j in range(1, columns + 1):
        n = 2 * j
        part = h / n
        before, now = y, [a + part * b for a, b in zip(y, start, strict=True)]
        for i in range(1, n):
            slope = rate(t + i * part, now)
            before, now = now, [a + 2 * part * b for a, b in zip(before, slope, strict=True)]
        slope = rate(t + h, now)
        coarser, row = row, [[(a + b + part * c) / 2 for a, b, c in zip(now, before, slope, strict=True)]]
        for i, old in enumerate(coarser, 1):
            factor = (mp.mpf(n) / (2 * (j - i))) ** 2 - 1
            row.append([a + (a - b) / factor for a, b in zip(row[-1], old, strict=True)])
    return row[-1], row[-2]
