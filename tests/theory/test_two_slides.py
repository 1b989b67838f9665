"""The smallest static friction of a stick-slip cycle, and the cycles above it, against the event-driven solver."""

import json
import math

import numpy as np
import pytest

import symfric as sf
from symfric.theory import drive
from symfric.theory.drive.pair import Pair

PAIR = {"r": 0.5, "zeta": 2.0, "s1": 0.2, "s2": 0.3}
OTHERS = [
    ({"r": 0.5, "zeta": 2.0, "s1": 0.2, "s2": 0.3}, "grazing"),
    ({"r": 0.2, "zeta": 0.7, "s1": 0.1, "s2": 0.13}, "grazing"),
    ({"r": 5.3, "zeta": 2.1, "s1": 0.46, "s2": 0.15}, "grazing"),
    ({"r": 1.056, "zeta": 4.272, "s1": 0.085, "s2": 1.651}, "grazing"),
    ({"r": 0.62, "zeta": 0.203, "s1": 0.132, "s2": 0.237}, "fold"),
    ({"r": 9.8, "zeta": 0.44, "s1": 0.13, "s2": 0.066}, "grazing"),
]


@pytest.fixture(scope="module")
def program():
    scene = sf.scenes.two_slides(**PAIR, fc1=1.0, fs1=7.8, horizon=2000.0)
    return sf.prepare(scene.wanting({"events": sf.Events()}), 1e-12)


def sticks(program, cycle, fs1, **values):
    """Number of sticks in 2000 units of time from where a cycle's stick begins."""
    landing = cycle.landing.copy()
    landing[2] = landing[3] - 1  # exactly without slip
    start = dict(zip(("eta1", "eta2", "u1", "u2"), landing, strict=True))
    events = program.run({**values, "fs1": fs1}, start).checked().events
    return sum(e.kind == "stick" for e in events), events


@pytest.mark.parametrize(
    ("change", "value"),
    [({}, 7.742901728076077), ({"damping": "omega2"}, 4.365104609277730), ({"fc1": 0.0}, 6.742901728076077)],
)
def test_smallest_static_friction(change, value):
    assert drive.two_slides_threshold(**{**PAIR, **change}) == pytest.approx(value, rel=2e-13)


def test_more_damping_of_the_second_slide_can_lower_it():
    least = [drive.two_slides_threshold(**{**PAIR, "s2": s2}) for s2 in (0.3, 1.3)]
    assert np.round(least, 3).tolist() == [7.743, 3.875]


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("values", "end"), OTHERS)
def test_a_billionth_beside_it_the_solver_decays_or_cycles(program, values, end):
    onset = drive.two_slides_onset(**values)
    assert onset.end == end
    above, below = (1 + (onset.fs1 - 1) * (1 + side) for side in (1e-9, -1e-9))
    cycle = drive.two_slides_cycle(**values, fs1=above)
    count, _ = sticks(program, cycle, above, **values)
    assert count >= math.floor(2000 / cycle.period) - 1 > 10
    assert cycle.fs1 == pytest.approx(above, rel=1e-13)
    if end == "grazing":
        assert onset.stable
        assert sticks(program, onset, below, **values)[1][-1].t < 1000
    else:
        assert abs(onset.multipliers[0]) == pytest.approx(1, abs=1e-6)
        # nothing holds the motion a thousandth below; the ghost of the fold slows it down nearer to it
        assert sticks(program, onset, 1 + (onset.fs1 - 1) * 0.999, **values)[1][-1].t < 1000


def test_below_the_threshold_cycles_of_two_slips_may_go_on(program):
    values = {"r": 0.5313659, "zeta": 2.3179513, "s1": 0.0552555, "s2": 0.2599565}
    onset = drive.two_slides_onset(**values)
    assert onset.end == "longer slip"
    periods = []
    for side in (1e-6, -1e-6):
        _, events = sticks(program, onset, onset.fs1 + side, **values)
        periods.append(np.diff([e.t for e in events if e.kind == "stick"])[-3:])
    assert periods[0] == pytest.approx([onset.period] * 3, rel=1e-3)
    assert periods[1][0] == pytest.approx(periods[1][2], rel=1e-6)
    assert abs(periods[1][1] - periods[1][0]) > 1


@pytest.mark.one_in(2)
@pytest.mark.parametrize("fs1", [7.743, 7.8, 9.0, 20.0])
def test_cycles_in_closed_form_are_those_of_the_solver(program, fs1):
    cycle = drive.two_slides_cycle(**PAIR, fs1=fs1)
    assert cycle.stable
    _, events = sticks(program, cycle, fs1)
    begin = [e.t for e in events if e.kind == "stick"][-2:]
    released = next(e.t for e in events if e.kind == "slip" and e.t > begin[0])
    assert begin[1] - begin[0] == pytest.approx(cycle.period, rel=1e-10)
    assert released - begin[0] == pytest.approx(cycle.stick_time, rel=1e-10)
    scene = sf.scenes.two_slides(**PAIR, fc1=1.0, fs1=fs1, horizon=cycle.period)
    e1, e2 = scene.system.q
    wanted = {"a": sf.HalfRange(e1), "b": sf.HalfRange(e2), "end": sf.End()}
    start = dict(zip(("eta1", "eta2", "u1", "u2"), cycle.release, strict=True))
    run = sf.simulate(scene.starting(start).wanting(wanted), 1e-13).checked()
    assert (2 * run["a"], 2 * run["b"]) == pytest.approx(cycle.ranges, rel=1e-10)
    assert run.final == pytest.approx(cycle.release, abs=1e-8)


def test_the_cycle_of_figure_15():
    cycle = drive.two_slides_cycle(**PAIR, fs1=7.8)
    assert cycle.period == pytest.approx(30.5259317470719, rel=1e-14)
    assert cycle.stick_fraction == pytest.approx(0.643933628935, abs=1e-12)
    assert cycle.ranges == pytest.approx((10.18899503638, 13.21670790688), abs=1e-11)
    told = cycle.to_dict()
    assert json.loads(json.dumps(told))["period"] == cycle.period
    assert repr(cycle) == "SlidesCycle(fs1 7.8, period 30.52593175, sticking 0.643934)"


def test_only_the_difference_of_the_frictions_matters():
    one, other = (drive.two_slides_cycle(**PAIR, fc1=fc1, fs1=fc1 + 7.5) for fc1 in (0.5, 3.0))
    assert (one.period, *one.ranges) == pytest.approx((other.period, *other.ranges), rel=1e-12)
    assert other.landing - one.landing == pytest.approx([-2.5, 5.0, 0.0, 0.0], abs=1e-12)


def test_multipliers_are_the_slope_of_the_return_map(program):
    values = {"r": 0.2, "zeta": 0.7, "s1": 0.1, "s2": 0.13}
    cycle = drive.two_slides_cycle(**values, fs1=3.0)
    scene = sf.scenes.two_slides(**values, fc1=1.0, fs1=3.0, horizon=1.5 * cycle.period).wanting({"p": sf.Trajectory()})
    scheme = sf.prepare(scene, 1e-13)

    def back(shift):
        y = cycle.release + shift
        y[2] = y[3] - 1
        run = scheme.run({}, dict(zip(("eta1", "eta2", "u1", "u2"), y, strict=True)))
        at = next(e.t for e in run.events[1:] if e.kind == "slip")
        return run(at)

    pair = Pair(0.2, 0.7, 0.1, 0.13)
    plane = np.linalg.svd(np.array([pair.load, [0, 0, 1, -1]]))[2][2:]  # directions that keep w = 0 and the load
    slopes = np.array([(back(1e-5 * d) - back(-1e-5 * d)) / 2e-5 for d in plane])
    found = np.linalg.eigvals(plane @ slopes.T)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(cycle.multipliers), abs=1e-5)


def test_following_a_parameter_gives_the_single_answers():
    values = [0.15, 0.3, 0.6, 1.3, 2.5]
    rest = {k: v for k, v in PAIR.items() if k != "s2"}
    curve = drive.two_slides_thresholds("s2", values, **rest)
    assert curve == pytest.approx([drive.two_slides_threshold(**rest, s2=s2) for s2 in values], rel=1e-12)
    overdamped = drive.two_slides_thresholds("s1", [0.2, 1.3, 1.4], r=0.5, zeta=2.0, s2=1.3)
    assert np.isfinite(overdamped).tolist() == [True, False, False]


def test_no_cycle_where_both_dampers_are_beyond_critical(program):
    values = {**PAIR, "s1": 1.3, "s2": 1.3}
    assert drive.two_slides_threshold(**values) == math.inf
    assert program.run({**values, "fs1": 300.0}).checked().stats["events"] == 1
    with pytest.raises(sf.NotFound, match="does not come back"):
        drive.two_slides_onset(**values)


def test_a_long_stick_forgets_everything_without_losing_digits():
    pair = Pair(5.1, 3.2, 1.27, 0.285)
    a, b = pair.ramp()
    after = pair.sticking(1e5) @ (a + np.array([0.3, -0.2, 0.1, 0.1]))
    delta = pair.load @ after
    assert after == pytest.approx(a + b * delta, rel=1e-12)
    assert pair.load @ pair.stick @ after == pytest.approx(1 / (1 + 5.1 * 3.2**2), rel=1e-12)
    from scipy.linalg import expm

    assert pair.sticking(7.0) == pytest.approx(expm(7.0 * pair.stick), abs=1e-12)


@pytest.mark.parametrize(
    ("ask", "error", "message"),
    [
        (lambda: drive.two_slides_cycle(**PAIR, fs1=7.7), sf.NotFound, "from 7.7429017"),
        (lambda: drive.two_slides_threshold(**{**PAIR, "s1": 0.0}), sf.SceneError, "s1 is 0"),
        (lambda: drive.two_slides_threshold(**PAIR, fc1=-1.0), sf.SceneError, "fc1 is -1"),
        (lambda: drive.two_slides_threshold(**PAIR, damping="s2"), sf.SceneError, "damping is 's2'"),
        (lambda: drive.two_slides_thresholds("fc1", [1.0], **PAIR), sf.SceneError, "no parameter 'fc1'"),
        (lambda: drive.two_slides_thresholds("s2", [1.0], **PAIR), sf.SceneError, "leave it out"),
    ],
)
def test_bad_questions_are_named(ask, error, message):
    with pytest.raises(error, match=message):
        ask()
