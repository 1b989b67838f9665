"""A mass on a floor of friction cells under a shaken ground, event by event: a reference of its own, without symfric.

``w' = -a(t) - c w - sgn(w) mu(u) g`` with a linear between samples. Between events the motion is written down in closed
form (a cubic for c = 0); the first event is bracketed by what is monotone.
"""

import math
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq


def motion(u, w, c, f, slope, t):
    """Return displacement and velocity after the time t under the force ``f + slope t``."""
    if c == 0.0:
        return u + t * (w + t * (f / 2 + t * slope / 6)), w + t * (f + t * slope / 2)
    steady, rise = f / c - slope / c**2, slope / c
    fall = -math.expm1(-c * t)
    return u + steady * t + rise * t * t / 2 + (w - steady) * fall / c, w + rise * t + (steady - w) * fall


def first_rest(u, w, c, f, slope, end, way):
    """Return when the velocity, which has the sign of `way` or is zero and gains it, is zero; inf if not before end."""
    speed = lambda t: way * motion(u, w, c, f, slope, t)[1]  # noqa: E731
    rate = lambda t: way * (f + slope * t - c * motion(u, w, c, f, slope, t)[1])  # noqa: E731
    turn = 0.0
    if rate(0.0) > 0.0:
        if rate(end) >= 0.0:
            return math.inf
        turn = brentq(rate, 0.0, end, xtol=1e-16, rtol=1e-15)
    elif rate(0.0) < 0.0 < rate(end):
        lowest = brentq(rate, 0.0, end, xtol=1e-16, rtol=1e-15)
        return brentq(speed, 0.0, lowest, xtol=1e-16, rtol=1e-15) if speed(lowest) < 0.0 else math.inf
    if speed(end) >= 0.0:
        return math.inf
    return brentq(speed, turn, end, xtol=1e-16, rtol=1e-15) if speed(turn) > 0.0 else turn


def shaken(edges, values, record, dt, *, u=0.0, w=0.0, c=0.0, g=9.81, near=3e-16):
    """Return final u and w, the largest |u| at an event, and the events (t, before, after).

    Parameters
    ----------
    edges : sequence
        Inner edges of the cells, increasing.
    values : sequence
        Coefficients of the cells, one more than edges.
    record : sequence
        Acceleration of the ground, every dt.
    """
    edges = [-math.inf, *edges, math.inf]

    def cell(way):
        """Return the cell into which the mass moves from here."""
        inside = [a - way * near < u < b - way * near for a, b in pairwise(edges)]
        return inside.index(True)

    def release(a):
        """Return the way in which a mass at rest is moved, 0 if it is held."""
        way = -np.sign(a)
        return way if way and abs(a) > values[cell(way)] * g else 0.0

    way, events, largest = np.sign(w), [], abs(u)
    for k, (a, b) in enumerate(pairwise(record)):
        slope, t = (b - a) / dt, 0.0
        if k == 0 and way == 0.0:
            way = release(a)
        while t < dt:
            now = a + slope * t
            if way == 0.0:
                way = release(b)
                bound = values[cell(-np.sign(b))] * g if way else 0.0
                if way == 0.0:
                    break
                t = max(t, (-way * bound - a) / slope)
                events.append((k * dt + t, 0.0, way))
                continue
            here = cell(way)
            force = -now - way * values[here] * g
            span = min(dt - t, first_rest(u, w, c, force, -slope, dt - t, way))
            edge = edges[here + 1] if way > 0 else edges[here]
            start = u, w, c, force, -slope

            def place(t, start=start, edge=edge):
                return motion(*start, t)[0] - edge

            crosses = way * place(span) > near
            if crosses:
                span = brentq(place, 0.0, span, xtol=1e-16, rtol=1e-15) if way * place(0.0) < -near else 0.0
            rests = not crosses and span < dt - t
            u, w = motion(u, w, c, force, -slope, span)
            t += span
            u = edge if crosses else u
            if rests:
                w, before = 0.0, way
                way = release(a + slope * t)
                events.append((k * dt + t, before, way))
            largest = max(largest, abs(u))
    return u, w, largest, events
