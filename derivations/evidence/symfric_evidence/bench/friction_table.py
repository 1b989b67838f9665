"""A mass on a friction table of 50 points under a sine force, and its motion in closed form between the points."""

import math
from itertools import pairwise

import mpmath as mp
import sympy as sp

from symfric.model import laws
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact, System

_DIGITS = 40
POINTS, FASTEST = 50, 12.0
PUSH, HORIZON = 25, 5.0  # N, s; the force is PUSH sin(pi t/2)
_LOOK = 1e-3  # s, between looks for the end of a segment, in which the motion is monotone enough


def stribeck_table() -> tuple[list[float], list[float]]:
    """Return speeds and friction forces: 5 N, 1 N s/m and 10 N that fall by ``exp(-2 v)``."""
    speeds = [FASTEST * i / (POINTS - 1) for i in range(POINTS)]
    return speeds, [5 + v + 10 * math.exp(-2 * v) for v in speeds]


def table_scene() -> Scene:
    """Return mass and support friction of Modelica.Mechanics.Translational.Examples.Friction."""
    s, v = sp.symbols("s v", real=True)
    speeds, forces = stribeck_table()
    support = Contact("support", v, 1, laws.piecewise_linear(forces[0], speeds, forces))
    system = System([s], [v], [[1]], [PUSH * sp.sin(sp.pi * TIME / 2)])
    return Scene(system, [support], {}, {s: 0.0, v: 0.0}, HORIZON)


class _Segment:
    """The motion from a time and state on while ``v' = P sin(w t) - side a - b v``."""

    def __init__(self, begin: mp.mpf, s: mp.mpf, v: mp.mpf, side: int, a: mp.mpf, b: mp.mpf):
        self._begin, self._s, self._b, self._rest, self._w = begin, s, b, -side * a / b, mp.pi / 2
        self._size = PUSH / (b**2 + self._w**2)
        self._c = v - self._rest - self._forced(begin)

    def _forced(self, t: mp.mpf) -> mp.mpf:
        return self._size * (self._b * mp.sin(self._w * t) - self._w * mp.cos(self._w * t))

    def speed(self, t: mp.mpf) -> mp.mpf:
        """Return v."""
        return self._c * mp.exp(-self._b * (t - self._begin)) + self._rest + self._forced(t)

    def place(self, t: mp.mpf) -> mp.mpf:
        """Return s."""

        def whole(at: mp.mpf) -> mp.mpf:
            wave = -self._b * mp.cos(self._w * at) / self._w - mp.sin(self._w * at)
            return -self._c / self._b * mp.exp(-self._b * (at - self._begin)) + self._rest * at + self._size * wave

        return self._s + whole(t) - whole(self._begin)


def motion_in_many_digits(until: float = HORIZON) -> tuple[mp.mpf, mp.mpf]:
    """Return place and speed at a time, in 40 digits.

    Notes
    -----
    At rest the force grows to that of the table at zero speed. In each segment of the table the equation is linear; the
    time at which the speed reaches the end of the segment is the root of its solution. Where the speed passes zero the
    force is larger than the friction (this is checked).
    """
    with mp.workdps(_DIGITS):
        speeds, forces = ([mp.mpf(e) for e in column] for column in stribeck_table())
        lines = []
        for (v0, v1), (f0, f1) in zip(pairwise(speeds), pairwise(forces), strict=True):
            slope = (f1 - f0) / (v1 - v0)
            lines.append((f0 - slope * v0, slope))
        t = mp.asin(forces[0] / PUSH) / (mp.pi / 2)
        s, v, side, k, end = mp.mpf(0), mp.mpf(0), 1, 0, mp.mpf(until)
        while t < end:
            motion = _Segment(t, s, v, side, *lines[k])
            leaves = _left(motion, t, end, side, speeds[k], speeds[k + 1] if k + 2 < len(speeds) else None)
            if leaves is None:
                return motion.place(end), motion.speed(end)
            t, up = leaves
            s, v = motion.place(t), motion.speed(t)
            k += 1 if up else -1
            if k < 0:
                k, side = 0, -side
                if abs(PUSH * mp.sin(mp.pi / 2 * t)) <= forces[0]:
                    raise ArithmeticError(f"the mass rests at t = {mp.nstr(t, 8)}")
        return s, v


def _left(
    motion: _Segment, t: mp.mpf, end: mp.mpf, side: int, low: mp.mpf, high: mp.mpf | None
) -> tuple[mp.mpf, bool] | None:
    """Return when the speed leaves a segment, and whether upwards; None if not before the end."""
    before = t
    while before < end:
        after = min(before + _LOOK, end)
        v = side * motion.speed(after)
        for bound, up in ((high, True), (low, False)):
            if bound is not None and (v > bound if up else v < bound):
                inside = lambda time, bound=bound: side * motion.speed(time) - bound  # noqa: E731
                begin = before if before > t else t + _LOOK / 1024  # it may start at a bound
                return mp.findroot(inside, (begin, after), solver="anderson", tol=mp.mpf(10) ** (5 - 2 * _DIGITS)), up
        before = after
    return None
