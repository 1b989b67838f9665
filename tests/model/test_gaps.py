"""Gaps with corners and jumps are refused, since a closed contact would strike there; smooth pieces are not."""

import pytest
import sympy as sp

import symfric as sf

X, Y, U, V = sp.symbols("x y u v", real=True)
PLAIN, PLAIN_U = sp.symbols("s w")  # not declared real
B, H = sp.symbols("b h", positive=True)
T = sf.TIME


def scene(gap, values=None):
    """Return a body under weight above a gap, which is positive at the start."""
    return sf.Scene(
        sf.System([X, Y, PLAIN], [U, V, PLAIN_U], sp.eye(3), [0, -1, 0]),
        [sf.Contact("floor", None, sf.Unilateral(gap, restitution=0.5))],
        values or {},
        {X: 0.25, Y: 1.0, PLAIN: 1.0, U: 1.0, V: 0.0, PLAIN_U: 0.0},
        3.0,
    )


def steps(at, *pieces):
    """Return pieces between increasing values of a quantity."""
    quantity, *places = at
    return sp.Piecewise(*((p, quantity < b) for p, b in zip(pieces, places, strict=False)), (pieces[-1], True))


@pytest.mark.parametrize(
    ("gap", "where"),
    [
        (Y - sp.Abs(X) / 10, "slope jumps where x = 0"),
        (Y + sp.Abs(X) / 10, "slope jumps where x = 0"),
        (Y - sp.Max(X - 1, 0) / 2, "x - 1 = 0"),
        (sp.Min(Y, Y - X / 2 + 1, X + Y), "slope jumps by"),
        (Y - steps((X, 1), 0, sp.Rational(1, 10)), "jumps by 0.1 at x = 1"),
        (Y - steps((X, 0, 1), 0, X / 10, sp.Rational(1, 10)), "slope jumps by -0.1 at x = 0"),
        (Y - sp.sqrt(X**2) / 2, "x = 0"),
        (Y + sp.Abs(PLAIN) / 2, "slope jumps where s = 0"),
        (Y - sp.Abs(X - T) / 10, "slope jumps"),
        (Y - sp.Max(T - 1, 0), "write a bend in time as a Piecewise"),
        (Y - sp.Abs(T - 1) / 10, "write a bend in time as a Piecewise"),
        (Y - steps((T, 1), 0, sp.Rational(1, 10)), "jumps by -0.1 at t = 1"),
        (Y - sp.Heaviside(T - 2) / 10, "jumps by -0.1 at t = 2"),
        (Y - steps((sp.Mod(T, 2), 1), sp.Rational(1, 10), 0), "in no time"),
        (Y - sp.sign(X), "which jumps"),
    ],
)
def test_corners_and_jumps_are_refused(gap, where):
    with pytest.raises(sf.SceneError, match=r"gap of contact 'floor'") as error:
        scene(gap)
    assert where in str(error.value)


def test_corners_that_depend_on_parameters_are_refused():
    with pytest.raises(sf.SceneError, match=r"corner .* x = 1\.5"):
        scene(Y - steps((X, B), 0, H * (X - B)), {B: 1.5, H: 0.1})
    with pytest.raises(sf.SceneError, match=r"jumps by -0\.2 at t = 1\.5"):
        scene(Y - steps((T, B), 0, H), {B: 1.5, H: 0.2})


@pytest.mark.parametrize(
    ("gap", "values"),
    [
        (Y - steps((X, 0, B), 0, H * (X / B) ** 2, H * (2 * X / B - 1)), {B: 1.0, H: 0.1}),
        (Y - sp.Max(X, 0) ** 2 / 5, {}),
        (Y - sp.Abs(X) ** 3 / 5, {}),
        (Y - sp.Abs(T - 1) ** 3 / 5, {}),
        (Y - steps((T, 1), 0, (T - 1) / 5), {}),  # a bend in time
        (Y - X * steps((T, 1), 0, (T - 1) / 5), {}),
        (Y - steps((sp.Mod(T, 2), 1), H * sp.sin(sp.pi * T) ** 2, 0), {H: 0.1}),
        (Y - sp.Abs(B) / 10, {B: 1.0}),
        (sp.sqrt(X**2 + Y**2) - sp.Rational(1, 10), {}),
    ],
)
def test_smooth_pieces_and_bends_in_time_are_taken(gap, values):
    assert scene(gap, values).contacts_that_open


def test_a_valley_of_two_contacts_stops_and_reflects():
    """A body slides down one side of a valley and strikes the other: its speed along that is the cosine's share."""
    slope = sp.Rational(1, 10)
    sides = [sf.Contact(n, None, sf.Unilateral(Y - s * slope * X)) for n, s in (("left", -1), ("right", 1))]
    system = sf.System([X, Y], [U, V], sp.eye(2), [0, -1])
    start = {X: -1.0, Y: 0.1, U: 0.0, V: 0.0}
    run = sf.simulate(sf.Scene(system, sides, {}, start, 15.0), tolerance=1e-12).checked()
    strike = next(e for e in run.events if e.contact == "right")
    assert strike.kind == "close"
    before, after = run.before(strike.t), run(strike.t)
    assert before[0] == pytest.approx(0.0, abs=1e-12)
    assert before[2] == pytest.approx((2 * 0.1 / 1.01) ** 0.5, rel=1e-11)  # energy
    assert after[2] / before[2] == pytest.approx((1 - 0.01) / (1 + 0.01), rel=1e-11)
    assert run.energy_residual() < 1e-10


def test_a_floor_bent_smoothly_is_followed():
    """The body stays on the floor, and its energy is that of its height."""
    profile = steps((X, 0, 1), 0, X**2 / 10, (2 * X - 1) / 10)
    floor = sf.Contact("floor", None, sf.Unilateral(Y - profile))
    system = sf.System([X, Y], [U, V], sp.eye(2), [0, -1])
    run = sf.simulate(sf.Scene(system, [floor], {}, {X: -1.0, Y: 0.0, U: 0.6, V: 0.0}, 4.0), tolerance=1e-12).checked()
    t = [0.5, 1.8, 2.5, 3.3, 4.0]
    for x, y, u, v in run(t).T:
        assert y == pytest.approx(float(profile.subs(X, x)), abs=1e-11)
        assert (u * u + v * v) / 2 + y == pytest.approx(0.18, abs=1e-11)


def test_a_floor_that_starts_at_once_strikes():
    floor = sf.Contact("floor", None, sf.Unilateral(Y - steps((T, 1), 0, T - 1), restitution=0.25))
    scene = sf.Scene(sf.System([Y], [V], [[1]], [-1]), [floor], {}, {Y: 0.0, V: 0.0}, 1.2)
    run = sf.simulate(scene, tolerance=1e-12).checked()
    assert [(e.t, e.kind) for e in run.events] == [(pytest.approx(1.0, abs=1e-14), "open")]
    assert run.final == pytest.approx([1.25 * 0.2 - 0.02, 1.25 - 0.2], abs=1e-12)
    assert run.energy_residual() < 1e-12
