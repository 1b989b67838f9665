"""Directions in the plane in which what a contact does agrees with its friction.

With friction ``-mu N e`` of a contact in the plane in the direction e, and all other contacts in a given mode, the
change of its slip is

    c(e) = c_0 - mu N(e) A_t e + A_n N(e),   N(e) = b/(A_nn - mu A_nt^T e),

where N is given, or follows from the gap that stays closed. So ``e x c(e)/N(e) = 0``, the condition that friction
opposes the slip, is a trigonometric polynomial of degree 2 in the angle of e: five values determine it, and all its
roots, four at most, are those of polynomials in the tangent of half of the angle.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.events.direction_sizes import MOST_ANGLES, QUARTIC, SAMPLES
from symfric.solve.loop.events.polynomials import roots
from symfric.solve.loop.workspace import LoopArrays

START_ANGLE = 0.31415  # of the first sample, which is no direction that scenes are given in
POLISHES = 3  # chord steps that improve a root
MOST_SWEEPS, AGREE = 200, 1e-14  # repetitions over several contacts, and the turn up to which they agree
_ARCS, _BEYOND = 4, 1.02  # parts of the circle, and by how much they overlap
_SAME = 1e-7  # difference of angles that are the same root, found in two arcs
_NOTHING = 1e-14  # coefficient relative to the largest that is rounding


@compiled(inline=True)
def sample_angle(s: int) -> float:
    """Return the angle of sample s."""
    return START_ANGLE + s * (2.0 * np.pi / SAMPLES)


@compiled
def find_angles(w: LoopArrays) -> int:
    """Find the angles at which the polynomial with the values ``w.planes.samples`` is zero; return how many."""
    p, n, b = w.planes, 0, w.roots.poly
    _interpolate(w)
    mean, size = p.series[0], 0.0
    for k in range(SAMPLES):
        size = max(size, abs(p.series[k]))
    if not 0.0 < size < np.inf:
        return 0
    c1, s1, c2, s2 = p.series[1], p.series[2], p.series[3], p.series[4]
    for arc in range(_ARCS):
        b[0] = mean + c1 + c2
        b[1] = 2.0 * s1 + 4.0 * s2
        b[2] = 2.0 * mean - 6.0 * c2
        b[3] = 2.0 * s1 - 4.0 * s2
        b[4] = mean - c1 + c2
        scale = 1.0
        for k in range(QUARTIC + 1):
            b[k] *= scale
            scale *= _BEYOND
        degree = QUARTIC
        while degree > 1 and abs(b[degree]) <= _NOTHING * size:
            degree -= 1
        for r in range(roots(b, degree, degree, w.tables.bernstein, w.roots.stack, w.roots.places)):
            angle = START_ANGLE + 2.0 * np.arctan(_BEYOND * w.roots.places[r]) + arc * 0.5 * np.pi
            if n < MOST_ANGLES and not _is_known(w, n, angle):
                p.angles[n] = angle
                n += 1
        c1, s1, c2, s2 = s1, -c1, -c2, -s2  # a quarter further
    return n


@compiled
def _interpolate(w: LoopArrays) -> None:
    """Compute mean, and cosine and sine of the angle from the first sample on and of its double."""
    p = w.planes
    for k in range(SAMPLES):
        p.series[k] = 0.0
    for s in range(SAMPLES):
        turn, g = s * (2.0 * np.pi / SAMPLES), p.samples[s]
        p.series[0] += g / SAMPLES
        for k in range(1, 3):
            p.series[2 * k - 1] += 2.0 * g * np.cos(k * turn) / SAMPLES
            p.series[2 * k] += 2.0 * g * np.sin(k * turn) / SAMPLES


@compiled
def _is_known(w: LoopArrays, n: int, angle: float) -> bool:
    """Whether a root was found in another arc."""
    for k in range(n):
        apart = abs(w.planes.angles[k] - angle)
        if min(apart, abs(apart - 2.0 * np.pi)) <= _SAME:
            return True
    return False


@compiled
def chord_step(w: LoopArrays, angle: float, g: float) -> float:
    """Return by how much to go back from an angle where the polynomial is g, with its slope as it was interpolated."""
    a, p = angle - START_ANGLE, w.planes.series
    slope = p[2] * np.cos(a) - p[1] * np.sin(a) + 2.0 * (p[4] * np.cos(2.0 * a) - p[3] * np.sin(2.0 * a))
    step = g / slope if slope != 0.0 else 0.0
    return step if abs(step) < _SAME else 0.0
