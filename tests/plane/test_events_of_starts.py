"""What happens while a contact in the plane starts to slip, beside its start: kinks, steps, stops of others, lost loads.

The motion is along a line, on which the contact along a line is the second method. All series are polynomials here, so
that steps are as long as they may be.
"""

import math

import pytest
import sympy as sp

import symfric as sf

x, y, u, w, X, U = sp.symbols("x y u w X U", real=True)
t = sf.TIME
RELEASE = 0.5  # time at which the pull reaches the friction


def pulled(plane, extra, load=1, horizon=40.0):
    """Return a block that a growing force pulls, with a neighbour that slides to its stop at RELEASE + .01."""
    c, s = (0.6, 0.8) if plane else (1, 0)
    along = c * x + s * y
    force = t + extra(along)
    stop = sf.Contact("neighbour", U, 1, sf.laws.coulomb(1))
    q, v = ([x, y, X], [u, w, U]) if plane else ([x, X], [u, U])
    forces = [c * force, s * force, 0] if plane else [force, 0]
    slip = (u, w) if plane else u
    start = dict.fromkeys((*q, *v), 0.0) | {U: RELEASE + 0.01}
    contacts = [sf.Contact("table", slip, load, sf.laws.coulomb(0.5)), stop]
    wanted = {"events": sf.Events()}
    return sf.Scene(sf.System(q, v, sp.eye(len(q)), forces), contacts, {}, start, horizon, wanted)


def motion(scene):
    run = sf.simulate(scene, tolerance=1e-12)
    ends = dict(zip(run.names, run.final, strict=True))
    way, speed = (math.hypot(ends.get(a, 0.0), ends.get(b, 0.0)) for a, b in (("x", "y"), ("u", "w")))
    return (
        run,
        [run.t_final, way, speed, ends["X"]],
        [(e.contact, e.kind) for e in run.events],
        [e.t for e in run.events],
    )


EXTRA = {
    "kink in time": lambda later: lambda along: 10 * sp.Max(0, t - RELEASE - later),
    "step in time": lambda later: lambda along: sp.Piecewise((0, t < RELEASE + later), (5, True)),
    "kink of place": lambda later: lambda along: 1e4 * sp.Max(0, along - later**3 / 6),
}


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("kind", "later"), [*((kind, 1e-3) for kind in EXTRA), ("kink in time", 1e-7), ("kink of place", 0.2)]
)
def test_a_start_ends_at_the_next_event(kind, later):
    extra = EXTRA[kind](later)
    line, plane = motion(pulled(False, extra, horizon=1.5)), motion(pulled(True, extra, horizon=1.5))
    assert plane[0].status is line[0].status is sf.Status.OK
    assert plane[1] == pytest.approx(line[1], rel=1e-10)
    assert plane[2] == line[2]
    assert plane[3] == pytest.approx(line[3], abs=1e-12)


def test_a_load_is_lost_during_a_start():
    """The block is without load from t = .6 on; a Taylor step of a start would reach beyond."""
    load = 2 * (0.6 - t) / 0.2
    runs = [motion(pulled(plane, lambda along: 0, load)) for plane in (False, True)]
    for run, ends, _, _ in runs:
        assert run.status is sf.Status.LOST_CONTACT
        assert ends[0] == pytest.approx(0.6, abs=1e-9)
    assert runs[1][1] == pytest.approx(runs[0][1], rel=1e-8)


def test_a_block_flies_and_lands_on_a_soft_plate():
    """The slip passes zero in flight, where friction has no bound: no step may then pass over the landing."""
    z, v = sp.symbols("z v", real=True)
    rate, stiff, a = 100 * math.pi, 1e5, 3e-4
    up, ahead = math.sin(0.4363), math.cos(0.4363)
    press = sp.Max(0, -stiff * (z - a * up * sp.sin(rate * t)))
    belt = a * ahead * rate * sp.cos(rate * t)

    def thrown(plane):
        q, speeds = ([x, y, z], [u, w, v]) if plane else ([x, z], [u, v])
        system = sf.System(q, speeds, sp.eye(len(q)), [*([0] * (len(q) - 1)), press - 9.81])
        contact = sf.Contact("plate", (u - belt, w) if plane else u - belt, press, sf.laws.coulomb(0.3))
        start = dict.fromkeys((*q, *speeds), 0.0) | {z: -9.81 / stiff}
        return sf.simulate(sf.Scene(system, [contact], {}, start, 0.3), tolerance=1e-12).checked()

    line, plane = thrown(False), thrown(True)
    assert plane.energy_residual() < 1e-9
    assert plane.final[[0, 2, 3, 5]] == pytest.approx(line.final, abs=1e-9)
