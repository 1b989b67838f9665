"""Contacts in the plane late in a run, where the rounding of time decides how near to rest and release a motion comes.

The table is at rest up to a time T_0 and moves as a function of ``t - T_0`` from then on: the motion is the same whatever
T_0 is, but for the rounding of time.
"""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer
from tests.plane.test_cycles_on_feet import DROP, MU, STRIBECK, A, W, body, q, u

T_0 = sp.Symbol("T_0", positive=True)
COULOMB, STRONG = sf.laws.coulomb(MU), sf.laws.coulomb(4 * MU)
BODIES = {
    "one foot that holds more": (3, (COULOMB, COULOMB, STRONG), 1.2),
    "equal feet": (3, (COULOMB,) * 3, 0.6),
    "two feet, a drop of friction": (2, (DROP,) * 2, 0.5),
    "four feet": (4, (STRIBECK,) * 4, 0.6),
}
pytestmark = pytest.mark.filterwarnings("ignore:redundant contacts")


def prepared(which, span):
    n, laws, size = BODIES[which]
    since = sf.TIME - T_0
    ways = A * sp.sin(W * since), sp.Rational(7, 10) * A * sp.sin(sp.Rational(4, 5) * W * since)
    table = tuple(sp.Piecewise((way, sf.TIME > T_0), (0, True)) for way in ways)
    scene = body(n, table=table, laws=laws, values={A: size, T_0: 1.0}).starting(dict.fromkeys((*q, *u), 0.0))
    return scene.until(1.0 + span).wanting({"end": sf.End(), "events": sf.Events()})


@pytest.mark.one_in(4)
@pytest.mark.parametrize("begin", longer([1e3, 1e5], [1e3]))
@pytest.mark.parametrize("which", BODIES)
def test_a_motion_that_begins_late_is_the_same(which, begin):
    span = 12.0
    early = sf.simulate(prepared(which, span), tolerance=1e-9).checked()
    assert len(early.events) > 5
    late = sf.simulate(prepared(which, span).where({T_0: begin}).until(begin + span), tolerance=1e-9).checked()
    kinds = [[(e.contact, e.kind) for e in run.events] for run in (early, late)]
    assert kinds[0] == kinds[1]
    times = [np.array([e.t for e in run.events]) - t for run, t in ((early, 1.0), (late, begin))]
    assert times[1] == pytest.approx(times[0], abs=1e-8 + 1e3 * np.spacing(begin))
    assert late.final == pytest.approx(early.final, abs=1e-8 + 1e3 * np.spacing(begin))


def lasting_sticks(run):
    """Return how many sticks last: a slip that only turns fast may be seen to stop for less than the error of its time."""
    began, count = {}, 0
    for e in run.events:
        if e.kind == "stick":
            began[e.contact] = e.t
        elif e.contact in began:
            count += e.t - began.pop(e.contact) > 1e-8
    return count


@pytest.mark.long(beside="test_a_motion_that_begins_late_is_the_same")
@pytest.mark.parametrize(
    ("frequency", "speed", "mu"), [(1.3, 1.2, 0.5), pytest.param(3.1, 1.2, 0.9, marks=pytest.mark.long)]
)
def test_small_slips_about_another_foot_end_late_in_a_run(frequency, speed, mu):
    """The rounding of time turns a slip of 1e-10 on a table that shakes fast by more than its terms tell."""
    scene = body(2, spin=speed * sp.sin(frequency * sf.TIME), values={MU: mu}).until(1000.0)
    rough, *fine = (sf.simulate(scene, tolerance=tolerance).checked() for tolerance in (1e-6, 1e-9, 1e-10))
    assert fine[0].final == pytest.approx(fine[1].final, abs=1e-8)
    assert rough.final == pytest.approx(fine[1].final, abs=1e-5)
    assert lasting_sticks(fine[0]) == lasting_sticks(fine[1]) > 150


@pytest.mark.long(beside="test_a_motion_that_begins_late_is_the_same")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_a_slow_slip_beside_a_foot_that_sticks_comes_to_rest(tolerance):
    """It is not held up by the slip of that foot, an error of the run, at the angle at which friction no longer slows it."""
    scene = body(2, spin=0.9 * sp.sin(1.3 * sf.TIME), values={MU: 0.4}).until(1500.0)
    run, fine = (sf.simulate(scene, tolerance=e).checked() for e in (tolerance, 1e-10))
    assert len(run.events) == len(fine.events) > 600
    assert run.final == pytest.approx(fine.final, abs=10 * tolerance)
    assert len(run.t) < 20_000
