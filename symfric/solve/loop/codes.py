"""Whole numbers by which compiled loops say how a run ends, where it is, and what a row or an address is for."""

from symfric.solve.status import Status

# how a run ends
OK, UNDECIDED, LOST_CONTACT = int(Status.OK), int(Status.UNDECIDED), int(Status.LOST_CONTACT)
NOT_FINITE, STEP_COLLAPSE = int(Status.NOT_FINITE), int(Status.STEP_COLLAPSE)
PAINLEVE = int(Status.PAINLEVE)
MANY_CONTACTS, OVERLAP = int(Status.MANY_CONTACTS), int(Status.OVERLAP)
STEP_BUDGET, EVENT_BUDGET, CHATTER = int(Status.STEP_BUDGET), int(Status.EVENT_BUDGET), int(Status.CHATTER)
QUEUE_FULL = int(Status.QUEUE_FULL)

SELECT, EXPAND, GO, SEGMENT = range(4)  # values of `Counts.phase`
HIT, LOADED = 1, 2  # values of `Counts.flagged`

STRUCTURE = 2  # value of `LoopLimits.linear`
# rows of the gauge; those of the coupling and of the response follow
SLIP, TERMS, PULL, LOAD, DROP, FORCES, COUPLING = range(7)

# entries of `code`: the first of all modes, then those of one or two variants of the series
GAUGE, REACH, VARIANTS = range(3)
PRELUDE, SERIES, PROBE, UNSEEN, ROW_TERMS, FUNCTIONS = range(6)  # of one variant, and how many
JUMP, TRANSITION, IMPACT = (VARIANTS + 2 * FUNCTIONS + k for k in range(3))
