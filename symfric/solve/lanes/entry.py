"""Cases in lanes, as machine code takes it; see `symfric.solve.loop.entry`.

There are two blocks of lanes. In the first all lanes take steps without events; one that cannot changes places with one
of the second block that is ready to go on. Once none there is, all that the lanes of the second block need is done at
once: events in lanes as well, what is rare by the event loop, one case after the other.
"""

from symfric.codegen.loop_calls import FAILED, call_loop
from symfric.codegen.numba_types import call_code, compiled, opener
from symfric.solve.lanes.arrays import LaneArrays
from symfric.solve.lanes.fields import CALLED, HELD, LEFT, MET, OWED, WANTING
from symfric.solve.lanes.owed_rows import pay
from symfric.solve.lanes.transfer import BEGINS, NOT, STICKS, readiness, to_lane, to_loop
from symfric.solve.loop.case_results import take
from symfric.solve.loop.codes import NOT_FINITE, OK
from symfric.solve.loop.workspace import LoopArrays
from symfric.solve.status import PAUSED

# what a lane that waits is: without a case, ready to move, before an event, sticking, at an event whose mode the event
# loop chooses, before something rare, amid that
EMPTY, READY, EVENT, STUCK, TURNS, RARE, LOOPING = range(7)
MOVING, WAITING = 0, 1  # the blocks
_MOST = 100_000  # steps, about a hundredth of a second; then Python may report or stop
_lanes_at, _loop_at = opener(LaneArrays), opener(LoopArrays)


@compiled
def launch(address: int, fresh: int) -> int:
    """Run cases until all are done (0), `PAUSED`, or `WANTING` more of them."""
    b = _lanes_at(address)
    width = b.state.size
    if fresh:
        for k in range(width):
            b.state[k], b.case_of[MOVING, k], b.case_of[WAITING, k] = EMPTY, -1, -1
    done = 0
    while True:
        if done > _MOST:
            return PAUSED
        alive, left = 0, 0
        for k in range(width):
            if b.case_of[MOVING, k] < 0:
                j, spent = _ready(b, width)
                done += spent
                if j < 0:
                    continue
                _exchange(b, k, j)
            alive |= 1 << k
        if b.kernels.wanting and not b.kernels.closing:
            return WANTING
        if alive == 0:
            return PAUSED if _find(b, LOOPING) >= 0 else OK
        while left == 0 and done <= _MOST:
            call_code(b.kernels.smooth, b.moving.ctypes.data, b.notes.ctypes.data, b.masks.ctypes.data)
            left = b.masks[LEFT] & alive
            if b.masks[OWED] & alive:
                done += pay(b, _loop_at, b.moving, MOVING, alive)
            done += width
        for k in range(width):
            if (left >> k) & 1:
                j, spent = _ready(b, width)
                done += spent
                if j < 0:
                    j = _find(b, EMPTY)
                if j < 0:  # all others wait for the event loop, which pauses: this lane is left again
                    return PAUSED
                _exchange(b, k, j)
                ended = b.waiting[b.kernels.t, j] >= b.waiting[b.kernels.end, j]
                b.state[j] = EVENT if b.kernels.event != 0 and not ended else RARE


@compiled
def _find(b: LaneArrays, what: int) -> int:
    for k in range(b.state.size - 1, -1, -1):
        if b.state[k] == what:
            return k
    return -1


@compiled
def _ready(b: LaneArrays, width: int) -> tuple[int, int]:
    """Return a lane that waits and is ready to go on, -1 if there is none, and about how many steps that took."""
    j = _find(b, READY)
    if j >= 0:
        return j, 0
    spent = _process(b, width)
    return _find(b, READY), spent


@compiled
def _exchange(b: LaneArrays, k: int, j: int) -> None:
    """Exchange lane k of those that move and lane j of those that wait."""
    of_k, of_j = b.moving.ctypes.data + 8 * k, b.waiting.ctypes.data + 8 * j
    call_code(b.kernels.swap, of_k, of_j, b.masks.ctypes.data)
    b.case_of[MOVING, k], b.case_of[WAITING, j] = b.case_of[WAITING, j], b.case_of[MOVING, k]
    b.room_of[MOVING, k], b.room_of[WAITING, j] = b.room_of[WAITING, j], b.room_of[MOVING, k]
    b.state[j] = EMPTY


@compiled
def _process(b: LaneArrays, width: int) -> int:
    """Bring every lane that waits to where it moves, or replace its case by another; return the steps that took."""
    spent = 0
    again = True
    while again and spent <= _MOST:
        again = False
        for k in range(width):
            if b.state[k] == RARE or b.state[k] == TURNS:
                to_loop(b, _loop_at(b.tables[b.room_of[WAITING, k], 0]), b.waiting, k, b.state[k] == TURNS)
            if b.state[k] >= TURNS:
                spent += _loop_on(b, k, 0)
            while b.state[k] == EMPTY and _next_case(b, k):
                spent += _loop_on(b, k, 1)
        for kind in (EVENT, STUCK):
            called = 0
            for k in range(width):
                if b.state[k] == kind:
                    called |= 1 << k
            if called == 0:
                continue
            b.masks[CALLED] = called
            code = b.kernels.event if kind == EVENT else b.kernels.stick
            call_code(code, b.waiting.ctypes.data, b.notes.ctypes.data, b.masks.ctypes.data)
            spent += width
            if b.masks[OWED]:
                spent += pay(b, _loop_at, b.waiting, WAITING, called)
            for k in range(width):
                if (called >> k) & 1:
                    if (b.masks[LEFT] >> k) & 1:
                        b.state[k], again = RARE, True
                    elif b.kernels.selects_mode == 0 and (b.masks[MET] >> k) & 1:
                        b.state[k], again = TURNS, True
                    elif kind == STUCK if b.kernels.selects_mode == 0 else (b.masks[HELD] >> k) & 1 != 0:
                        b.state[k] = STUCK
                        again = again or kind == STUCK
                    else:
                        b.state[k] = READY
    return spent


@compiled
def _next_case(b: LaneArrays, k: int) -> bool:
    """Give lane k the next case; return whether there was one."""
    place = b.place
    while place.next < place.end and b.status[place.next] != OK:  # it cannot begin
        place.next += 1
    if place.next >= place.end:
        b.kernels.wanting = 1
        return False
    b.case_of[WAITING, k] = place.next
    place.next += 1
    w = _loop_at(b.tables[b.room_of[WAITING, k], 0])
    for i in range(w.given_y.size):
        w.given_y[i] = b.given_y[b.case_of[WAITING, k], i]
    for i in range(w.given_p.size):
        w.given_p[i] = b.given_p[b.case_of[WAITING, k], i]
    return True


@compiled
def _loop_on(b: LaneArrays, k: int, fresh: int) -> int:
    """Let the event loop run the case of lane k until it may go on in lanes, or ends; return how many steps it took."""
    room = b.room_of[WAITING, k]
    w, case = _loop_at(b.tables[room, 0]), b.case_of[WAITING, k]
    spent = 0
    while True:
        code = call_loop(b.place.loop, b.tables[room, 1], b.tables[room, 2], b.tables[room, 0], fresh)
        fresh, spent = 0, spent + 8  # each takes as long as some steps in lanes
        b.kernels.calls += 1
        if code >= 0 or code == FAILED:
            take(b, w, case)
            b.status[case] = NOT_FINITE if code == FAILED else code
            b.state[k], b.case_of[WAITING, k] = EMPTY, -1
            return spent
        ready = readiness(b, w)
        if ready != NOT:
            to_lane(b, w, b.waiting, k)
            b.state[k] = STUCK if ready == STICKS else EVENT if ready == BEGINS else READY
            return spent
        if spent > _MOST:
            b.state[k] = LOOPING
            return spent
