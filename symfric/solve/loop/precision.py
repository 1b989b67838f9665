"""Numbers that say what counts as zero; without numba, for code that is not compiled by it."""

EPS = 2.0**-52
ROUNDING = 64 * EPS  # rounding error of a sum of a few terms, relative to their magnitudes
TIE = 1e-13  # derivative relative to its scale that counts as zero
MOST_DOUBT = 1e-3  # largest error of a stick force, relative to its bound, attributed to the error of the run
TOUCH = 10.0  # depth below zero, in tolerances of its largest value, up to which a load only touches zero
HALF_OF_DIGITS = 1e-5  # step to the place of an extremum, as part of a step of the run, after which it is known to half
LAST_STEP = 1e-9  # step of Newton's method, relative, after which a root is known to rounding
MARCHES = 12  # steps towards a crossing before subdivision takes over
TINY = 1e-300  # scale that counts as zero
# factor by which a step may be longer if an event or the end follows: at order 20 its error is three times as large,
# still below the tolerance, see MARGIN in `symfric.solve.taylor.route`
STRETCH = 1.05
LATE = 1e-9  # part of a step behind its end at which a value is not yet due
NEAREST = 1e-3  # part of a step over which guards are followed at least
LEAST_TERM = 1e-13  # first term of a guard that starts at zero, relative to all of them, that decides its sign
