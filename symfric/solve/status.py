"""Status codes of a run, with advice."""

from enum import IntEnum

PAUSED, PATH_FULL, EVENTS_FULL = -1, -2, -3  # returned by a loop that has to be called again


class Status(IntEnum):
    """How a run ended; a number, because a compiled route can only return numbers.

    Attributes
    ----------
    OK : Status
        The run reached its horizon; all others say why it ended before, and ``run.checked()`` what to do.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.Status.OK == 0
    True
    """

    OK = 0
    EVENT_BUDGET = 1
    STEP_BUDGET = 2
    STEP_COLLAPSE = 3
    CHATTER = 4
    NOT_FINITE = 5
    LOST_CONTACT = 6
    UNDECIDED = 7
    INTEGRATOR = 8
    NO_DERIVATIVE = 9
    QUEUE_FULL = 10
    PAINLEVE = 11
    MANY_CONTACTS = 12
    OVERLAP = 13


ADVICE = {
    Status.OK: "",
    Status.EVENT_BUDGET: "more events than the budget; shorten the horizon or raise max_events of the route, "
    "route=sf.Taylor(max_events=...)",
    Status.STEP_BUDGET: "more steps than the budget, or than a trajectory can store; shorten the horizon, use "
    "scalar outputs instead of a trajectory, or raise max_steps of the route, route=sf.Taylor(max_steps=...)",
    Status.STEP_COLLAPSE: "the steps became too short to reach the horizon: the motion is singular here, or "
    "stiff beyond this route; look at the final state, or try route='integrators'",
    Status.CHATTER: "events pile up without time advancing: the contacts chatter, or a reset leaves its guard at "
    "zero, from where it falls again, or a slip stays near a speed at which the slope of its law is infinite, as of an "
    "averaged law at the intensity of the vibration; look at run.events[-20:], check that static friction is not "
    "smaller than kinetic friction, and take a contact for impacts that come to rest",
    Status.NOT_FINITE: "the motion or a force is not finite; look at the final state, at values that make the mass "
    "zero or negative, and at divisions and roots in forces and integrals: the length of a slip is sf.slip(name), that "
    "of another vector has no series where it is zero",
    Status.LOST_CONTACT: "a normal load became negative: the bodies separate, which the contact does not model; write "
    "the load as Max(load, 0) if they may; a profile must not be negative either",
    Status.UNDECIDED: "no combination of sticking and slipping satisfies the friction laws here: a static "
    "coefficient is smaller than the kinetic one at rest or this one is negative, contacts on the same body exclude "
    "each other, surfaces under contacts in the plane that stick begin to move apart without an acceleration, or "
    "normal forces that bound friction are not unique, as of four feet that may lift of a rigid body; take a static "
    "coefficient that is not smaller, or put each foot on a small mass that a stiff spring and a damper hold to the "
    "body",
    Status.INTEGRATOR: "the integrator failed, or slips of contacts are so nearly equal that its error decides which "
    "one sticks; loosen the tolerance or use route='taylor'",
    Status.NO_DERIVATIVE: "the motion is correct to the end, but not differentiable: it grazes, two events coincide in "
    "time, it starts on the edge of sticking or on a contact that the derivative opens, or a law has an infinite slope "
    "at rest (square_root); move the parameter or the start, or compare runs on both sides",
    Status.QUEUE_FULL: "more values of a held variable are on their way than it has places for: give it more, "
    "sf.Held(..., waiting=...); or a period is not positive, a delay or an offset is negative, or the times of a reset "
    "do not increase from 0 on",
    Status.PAINLEVE: "the forces of contacts that open have no solution or several here (the paradox of Painleve): "
    "friction lets a normal force press its own contact; lower the friction, change the geometry, or put a stiffness "
    "in place of the rigid contact",
    Status.MANY_CONTACTS: "so many contacts that open touch at once that their combinations cannot all be tried, and "
    "the method that goes from one of them to the next has found none that is right, which does not prove that there "
    "is none; lower the friction, leave out contacts that other ones make superfluous, take a given normal load where "
    "a contact never opens, or start with small gaps between the bodies",
    Status.OVERLAP: "a reset puts bodies into each other: the gap of a contact that opens is negative after it; set "
    "coordinates with which no gap is negative",
}

# what helps the caller of a function that simulates by itself and takes no route
_ELSEWHERE = {
    **ADVICE,
    Status.EVENT_BUDGET: "more events than the budget: the contacts chatter, or the run is very long; shorten the "
    "horizon of the scene, or start nearer to the motion that is looked for",
    Status.STEP_BUDGET: "more steps than the budget: the run is very long; shorten the horizon of the scene, start "
    "nearer to the motion that is looked for, or loosen the tolerance",
    Status.STEP_COLLAPSE: "the steps became too short to go on: the motion is singular here, or stiff; simulate the "
    "scene from this start and look at its end, then change the start or smooth the forces",
    Status.CHATTER: "events pile up without time advancing: the contacts chatter; simulate the scene and look at "
    "run.events[-20:], and check that static friction is not smaller than kinetic friction",
    Status.NOT_FINITE: "the motion or a force is not finite: it leaves every bound, or a division or a root in a force "
    "fails; simulate the scene from this start to see where",
    Status.INTEGRATOR: "the integrator failed, or slips of contacts are so nearly equal that its error decides which "
    "one sticks; loosen the tolerance, or change the start",
}


def early_end(what: str, status: Status) -> str:
    """Return the message that a run inside another function ended early, with what the caller of that function can do.

    Parameters
    ----------
    what : str
        The motion.
    status : Status
    """
    return f"{what} ends early, {status.name}: {_ELSEWHERE[status]}"
