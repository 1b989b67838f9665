"""What each part of the event loop works with: the records of `symfric.solve.loop.workspace.LoopArrays`.

The first five are constants of a scene, the same for all of its runs.
"""

from dataclasses import dataclass

from symfric.codegen.array_table import ArraySet, Cube, IntegerMatrix, Integers, Matrix, Reals


@dataclass(frozen=True, eq=False, kw_only=True)
class Inputs(ArraySet):
    """Inputs in pieces of straight lines."""

    times: Reals  # times at which inputs change their slope, increasing, the last one infinite
    values: Matrix  # start, value and slope of every input from there on


@dataclass(frozen=True, eq=False, kw_only=True)
class Contacts(ArraySet):
    """What does not change of contacts and switches."""

    sticks: Integers  # whether a contact can stick, (n_c,)
    anchor: Integers  # index of the only velocity in a contact's slip, or -1, (n_c,)
    factor: Reals  # factor of this velocity, (n_c,)
    parallel: Integers  # first contact whose slip is a multiple of that of a contact, (n_c,)
    depends: Integers  # whether the slip may depend on those of others that are not parallel, (n_c,)
    loads: Integers  # index of the guard of a contact's load, or -1, (n_c,)
    edge: Integers  # 1, 2, ... for the switches at which a profile jumps, 0 for the others, (n_s,)
    step: Integers  # 1 for the switches that are steps in time, (n_s,)
    opens: Integers  # index among the contacts that open, or -1, (n_c,)
    partner: Integers  # the other component of the slip of a contact in the plane, or -1, (n_c,)
    shown: Integers  # index in m of what a trajectory keeps of contacts that do not slip along a line
    other_guards: IntegerMatrix  # contact of each of their guards, and its first variable in m or -1


@dataclass(frozen=True, eq=False, kw_only=True)
class Kinds(ArraySet):
    """What is computed of every observable."""

    kind: Integers  # RANGE, INTEGRAL, VALUES, TURN, FOLLOW or CROSSINGS, (n_e,)
    follows: Integers  # the row that a derivative follows, or -1, (n_e,)
    start: Reals  # time from which on each is accumulated, (n_e,)


@dataclass(frozen=True, eq=False, kw_only=True)
class Tables(ArraySet):
    """Constants of the series."""

    damping: Reals  # weights of the coefficients in weighted steps, (order + 1,)
    exposed: Integers  # rows whose coefficients may miss features, (n_h,)
    bernstein: Cube  # table of Bernstein coefficients
    columns: Matrix  # the same of the highest degree, for vectors, see `.events.bernstein.bernstein_columns`


@dataclass(frozen=True, eq=False, kw_only=True)
class LinearEquations(ArraySet):
    """Of linear equations; but the pattern, of a structure alone, see `symfric.lower.structure_modes`."""

    pattern: IntegerMatrix  # rows and columns of the entries of the matrices that are not zero in every mode, (n, 2)
    weights: Matrix
    operators: Matrix
    places: IntegerMatrix
    own: Integers
    joint: Integers


@dataclass(frozen=True, eq=False, kw_only=True)
class Powers(ArraySet):
    """Linear equations in the current mode, and what their series are computed with."""

    filled: Integers  # number of nonzero entries: of the rates, and of all, (2,)
    row: Integers  # rows of these entries, (n,)
    column: Integers
    entry: Reals
    newest: Matrix  # coefficients of the states of one order and of the next, (2, n_x)
    combined: Reals  # the operators in one with the present factors
    given: Reals  # what is felt of one coefficient, the columns of D
    answers: Reals  # what follows from it, the rows of D
    pushed: Reals  # the accelerations, (n_q,)


@dataclass(frozen=True, eq=False, kw_only=True)
class Step(ArraySet):
    """A trial step, and what it is accepted by."""

    lengths: Reals  # length of the step, and time over which guards are followed, (2,)
    reach: Reals  # change of the states over the step, and bounds of the change of guards, (n_x + n_g,)
    end: Reals  # state and time at the end, (n_x + 1,)
    unseen: Reals  # bounds of unseen features in a part of the step; next, sizes of terms; (n_r,) if any row is exposed
    terms: Reals
    box: Reals  # middles and radii of states and time in a part of the step, (2 n_x + 2,)
    bend: Reals  # largest second derivative of the states over the step, (n_x,)
    base: Matrix  # state before a singular start, and its first two coefficients, (3, n_x)


@dataclass(frozen=True, eq=False, kw_only=True)
class Roots(ArraySet):
    """Work space of roots of polynomials, see `symfric.solve.loop.events.polynomials`."""

    poly: Reals  # copy of a polynomial, (order + 5,)
    slope: Reals  # derivative of this polynomial
    places: Reals  # of roots
    stack: Matrix  # stack of the subdivision


@dataclass(frozen=True, eq=False, kw_only=True)
class Guards(ArraySet):
    """State of the guards."""

    hit: Integers  # guards that have just reached zero, (n_g,)
    fresh: Integers  # first coefficient that counts of guards that start their mode at zero, 0 for the others, (n_g,)
    slack: Reals  # shift of a guard so that it starts its mode at zero, and of a load for its rounding, (n_g,)
    other: Reals  # scales of the guards of contacts while they were slips, of those that carry forces, or the reverse
    carries: Integers  # contacts whose guards are forces, (n_c,)


@dataclass(frozen=True, eq=False, kw_only=True)
class Selection(ArraySet):
    """Work space of mode selection."""

    old: Integers  # modes before an event, (n_c,)
    zero: Integers  # contacts whose slip is zero now, (n_c,)
    rested: Integers  # whether a switch had no sign before the event, (n_s,)
    turns: Integers  # number of changes of a contact or switch, (n_c + n_s,)
    tried: Integers  # contacts already tried as sticking, (n_c,)
    kept: Reals  # marks and directions saved before a trial, (2 n_c,)
    passes: Integers  # contacts that pass through zero slip, (n_c,)
    entry_m: Reals  # modes and state before mode selection
    entry_y: Reals
    impulse: Reals  # impulse of each contact that makes its slip exactly zero, (n_c,)


@dataclass(frozen=True, eq=False, kw_only=True)
class Basis(ArraySet):
    """The sticking contacts: their constraints, and how they share forces; see `.modes.sticking_basis`."""

    share: Matrix  # Cholesky factor of the coupling of the sticking contacts, (n_c, n_c)
    order: Integers  # order of the contacts in this factorisation, (n_c,)
    weight: Reals  # coefficients of a slip row in the basis, and their errors in units of rounding, (n_c,)
    error: Reals
    slips: Reals  # directions of contacts that slip together, (n_c,)
    slopes: Matrix  # orthogonalised slip rows of the sticking contacts, (n_c, n_q)
    response: Matrix  # response of the velocities to these, (n_c, n_q)
    facet: Reals  # directions of the contacts that have to slip, (n_c,)
    force: Reals  # sum of the forces of parallel contacts, at their representative; next, sum of the bounds, (n_c,)
    most: Reals


@dataclass(frozen=True, eq=False, kw_only=True)
class Saltation(ArraySet):
    """Derivatives across events; see `symfric.lower.variational_equations`."""

    before: Reals  # inputs of the saltation: parameters, modes before and after an event, guards hit
    after: Reals  # outputs of the saltation
    tau: Reals  # derivatives of the time of the event at which this step begins, (n_s,)
    left: Reals  # state and time before an event, (n_x + 1,) if there are contacts of other kinds
    rise: Matrix  # slopes of rows with their lowest or highest value at the end of the last step; for crossings, the
    # places in this step, from 0 to 1, of the first and of the last one, or -1; (n_e, 2)


@dataclass(frozen=True, eq=False, kw_only=True)
class Transition(ArraySet):
    """Events of contacts that do not slip along a line."""

    asked: Reals  # inputs of a transition: parameters, mode, guards hit, guards at zero
    answer: Reals  # its outputs: state, mode, guards at zero


@dataclass(frozen=True, eq=False, kw_only=True)
class Openings(ArraySet):
    """What does not change of contacts that open."""

    variable: Integers  # index in m of each, (n_n,)
    line: Integers  # its index among the contacts along a line, or -1
    number: Integers  # under which runs show it
    direction: Integers  # of every direction of differentiation the parameter, -1 if it is a state, -2 for a pair


@dataclass(frozen=True, eq=False, kw_only=True)
class Impacts(ArraySet):
    """Impacts of contacts that open, and the selection of their modes; see `symfric.lower.impacts`."""

    asked: Reals  # inputs of an impact: parameters, what every contact does
    answer: Reals  # its outputs
    exact: Reals  # outputs of another impact, which makes exact what is held
    best: Reals  # the best of the inputs tried
    touches: Integers  # contacts without a gap, (n_n,)
    rests: Integers  # those whose gap has no rate, (n_n,)
    struck: Integers  # those that struck at this event, (n_n,)
    before: Integers  # modes that the run shows, (n_n,)
    entry_y: Reals  # state and mode before the event
    entry_m: Reals
    options: Integers  # number of modes to try of each contact that opens, then of each along a line
    tried: Integers  # which of them is tried
    chosen: Reals  # mode chosen, and its accelerations
    rates: Reals
    factor: Matrix  # factorisation of the coupling of all contacts that hold, (n_c + n_n, n_c + n_n)
    held: Integers  # these contacts in its order
    flight_m: Reals  # mode of the flights of bounces that died out
    last_m: Reals  # mode of the closed contacts
    last_y: Reals  # state, up to its derivatives, at the end of the bounces
    slope_y: Reals  # rates of the state before the impact
    late: Reals  # derivatives of the time until then, (n_s,)


@dataclass(frozen=True, eq=False, kw_only=True)
class Pivots(ArraySet):
    """The forces or impulses of many contacts that touch; see `symfric.solve.loop.modes.complementarity`.

    Arrays of all contacts hold those along a line first, then those that open.
    """

    takes: Integers  # contacts that take part
    place: Integers  # first unknown of each
    free: Reals  # rates of slips and gaps without their forces
    static: Reals  # coefficient, or bound under a given load, of contacts along a line at rest
    kinetic: Reals  # the same while they slip
    slides: Integers  # whether they do
    drag: Reals  # direction times coefficient of the slip of contacts that open, 0 where that is zero
    unit: Reals  # force of each in the scaled problem; then its largest rate
    table: Matrix  # equations by Lemke's method
    basis: Integers  # unknown of each row
    kind: Integers  # directions of slips, 0 at rest; 1 for contacts that are closed
    force: Reals  # forces, or impulses
    target: Reals  # rates of gaps after an impact by Newton's rule
    apart: Integers  # contacts that were open before the event, and have not struck
    wrong: Integers  # whether a contact contradicts the mode
    instead: Integers  # the option it takes instead


@dataclass(frozen=True, eq=False, kw_only=True)
class Planes(ArraySet):
    """Contacts in the plane, and the selection of modes beside them; see `symfric.solve.loop.modes.planes`."""

    row: Integers  # their first rows among the contacts along a line, (n_p,)
    arrived: Integers  # whether they have just come to rest, (n_p,)
    rests: Integers  # whether their slip is zero, (n_p,)
    variable: Integers  # of every contact the index in m of the first variable of its plane, or -1, (n_c,)
    leaves: Integers  # whether the force of a contact has reached its bound, (n_c,)
    slides: Integers  # whether it starts to slip
    returned: Integers  # how often it was held again
    stands: Integers  # the contact of the same slip that stands for it
    turned: Reals  # 1 if its components are those of that contact turned, -1 if mirrored
    free: Reals  # slip accelerations without forces of contacts at rest
    static: Reals  # largest forces of these at rest
    kinetic: Reals  # and once they slip
    bound: Reals  # those of the present problem
    force: Reals  # their forces
    gain: Reals  # and accelerations
    coupling: Matrix  # what a turn of one direction does to the slips of all across theirs, (n_p, n_p)
    turning: Matrix  # equations of the rates at which directions turn, (n_p, n_p + 1)
    across: Reals  # solution of these, (n_p,)
    aimed: Integers  # the only contact whose direction is one of several, or -1, (1,)
    weights: Reals  # normal forces in these directions
    samples: Reals  # values from which directions follow, see `symfric.solve.loop.events.directions`
    series: Reals  # their trigonometric polynomial
    angles: Reals  # its roots
    since: Integers  # of every contact the index in m of the time since which its direction or force is told, or -1


@dataclass(frozen=True, eq=False, kw_only=True)
class Starts(ArraySet):
    """Collocation of derivatives over a start in the plane; see `symfric.solve.loop.stepping.start_derivatives`."""

    nodes: Reals  # the start and the d nodes behind it, from 0 to 1, (d + 1,)
    rates: Matrix  # rates at the nodes, of values at all of them, (d, d + 1)
    powers: Matrix  # coefficients of the polynomial through values at all of them, (d + 1, d + 1)
    inner: Matrix  # and through those at the nodes behind the start, (d, d)
    equations: Matrix  # of the derivatives at the nodes, and their right sides, (d n_y, d n_y + n_s)
    rows: Matrix  # derivatives of observables at the nodes, the first n_f n_s, (n_e, d)


@dataclass(frozen=True, eq=False, kw_only=True)
class Feet(ArraySet):
    """Contacts at rest of bodies that can turn, see `symfric.solve.loop.modes.feet`; n_c of them at most.

    The last ones are for the directions in which those in the plane start, see
    `symfric.solve.loop.stepping.common_start`.
    """

    among: Integers  # whether each contact is one of the problem, (n_c,)
    used: Integers  # whether its slip is one of those the others follow from
    pivot: Integers  # these, in their order
    rank: Integers  # and their number, (1,)
    sticks: Integers  # whether it has no acceleration
    yields: Integers  # whether it slips although it seemed to stick
    factor: Matrix  # L, (n_c, n_c)
    size: Reals  # size of its rows in L
    target: Reals  # zeta_0
    offset: Reals  # part of each slip acceleration by surfaces that move apart, which no zeta removes
    scale: Reals  # size of the accelerations without these forces, (1,)
    point: Matrix  # zeta, one that is tried, and one that is kept, (3, n_c)
    slope: Reals  # first derivatives by zeta
    matrix: Matrix  # second ones, (n_c, n_c)
    step: Reals  # Newton's step
    kept: Matrix  # orthonormal directions of zeta that sticking holds, (n_c, n_c)
    place: Reals  # where along these, zero unless surfaces move apart
    hold: Reals  # forces that hold all contacts of the problem
    before: Reals  # the same at the state, while they are computed a little later
    mark: Reals  # marks in the mode, likewise
    entry_y: Reals  # the state, likewise, (n_x + 1,)
    turning: Matrix  # equations of the turns of directions, (n_p, n_p + 1)
    axes: Matrix  # principal axes of these, one a column
    weight: Reals  # what a turn about each gives, (n_p,)
    idle: Integers  # whether that is nothing
    order: Integers  # the axes for which this is so
    left: Reals  # right-hand sides of the equations
    turn: Reals  # times the friction, how far each direction turns
    limit: Reals  # of an end of the sticking, what `symfric.lower.variational_equations` tells, (3 n_c,); else zero
