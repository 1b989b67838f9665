"""Sizes of the work space of `symfric.solve.loop.events.directions`."""

SAMPLES = 5  # values that determine a trigonometric polynomial of degree 2
QUARTIC = 4  # degree of its polynomials in the tangent of half of the angle
MOST_ANGLES = 16  # places for roots, some of them found twice
