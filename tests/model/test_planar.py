"""Gap, slip and normal of points and discs against lines and circles, and what stands on them in ten lines."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

Q = X, Y, TH = sp.symbols("x y theta", real=True)
RATES = U, V, OM = sp.symbols("u v omega", real=True)
MORE = sp.symbols("X Y Theta", real=True), sp.symbols("Xd Yd Td", real=True)
T = sf.TIME


def numbers(seed, *symbols):
    rng = np.random.default_rng(seed)
    return dict(zip(symbols, rng.uniform(0.3, 1.5, len(symbols)), strict=True))


def value(e, at):
    return float(sp.sympify(e).subs(at))


def moved(at, dt):
    """Coordinates a moment later, with the velocities of a state."""
    q, u = (*Q, *MORE[0]), (*RATES, *MORE[1])
    return {**at, **{a: at[a] + dt * at[b] for a, b in zip(q, u, strict=True) if a in at}, T: at[T] + dt}


def two_bodies():
    q, u = (*Q, *MORE[0]), (*RATES, *MORE[1])
    return sf.mechanics.Body(X, Y, TH, q, u), sf.mechanics.Body(*MORE[0], q=q, u=u)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("radius", [0, 0.4])
def test_a_point_against_the_edge_of_a_moving_body(seed, radius):
    """Gap and slip from vectors in numbers: place of the point in the axes of the edge, and velocities of both bodies."""
    one, other = two_bodies()
    a, b, c, d, phi = np.random.default_rng(seed).uniform(-1, 1, 5)
    found = sf.mechanics.against_line(
        one.point(a, b), other.point(c, d), other.direction(np.cos(phi), np.sin(phi)), radius=radius
    )
    at = numbers(seed, *Q, *RATES, *MORE[0], *MORE[1], T)

    def turn(angle):
        return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def place(at, body, own):
        x, y, angle = (at[s] for s in body)
        return np.array([x, y]) + turn(angle) @ own

    def velocity(at, body, rates, where):
        x, y, _ = (at[s] for s in body)
        u, v, spin = (at[s] for s in rates)
        return np.array([u, v]) + spin * np.array([-(where[1] - y), where[0] - x])

    p, p0 = place(at, Q, [a, b]), place(at, MORE[0], [c, d])
    t = turn(at[MORE[0][2]] + phi) @ [1, 0]
    n = np.array([-t[1], t[0]])
    assert value(found.gap, at) == pytest.approx((p - p0) @ n - radius, abs=1e-12)
    assert [value(e, at) for e in found.normal] == pytest.approx(n, abs=1e-12)
    # the material velocity of the disc at its lowest point, and of the edge at the point through which it is given
    rim = velocity(at, Q, RATES, p) + at[OM] * radius * np.array([n[1], -n[0]])
    edge = velocity(at, MORE[0], MORE[1], p0)
    assert value(found.slip, at) == pytest.approx((rim - edge) @ t, abs=1e-12)
    assert all(found.slip.diff(w).diff(s) == 0 for w in (*RATES, *MORE[1]) for s in (*RATES, *MORE[1]))


@pytest.mark.parametrize("seed", range(6))
def test_slip_is_the_rate_of_what_rubs_on_a_circle(seed):
    """The contact point moves round both discs; the difference of the arcs it runs over is the slip."""
    one, other = two_bodies()
    R, r = 0.7, 0.2
    found = sf.mechanics.against_circle(one.point(0, 0), other.point(0, 0), R, disc=r)
    at = numbers(seed, *Q, *RATES, *MORE[0], *MORE[1], T)
    # when rolling, R (psi' - Theta') = r (theta' - psi')  with psi the angle of the line of centres
    later = [moved(at, s * 1e-6) for s in (1, -1)]
    psi = [np.arctan2(e[Y] - e[MORE[0][1]], e[X] - e[MORE[0][0]]) for e in later]
    turning = (psi[0] - psi[1]) / 2e-6
    d = np.hypot(at[X] - at[MORE[0][0]], at[Y] - at[MORE[0][1]])
    assert value(found.gap, at) == pytest.approx(d - R - r, abs=1e-12)
    slip = -d * turning + R * at[MORE[1][2]] + r * at[OM]
    assert value(found.slip, at) == pytest.approx(slip, rel=1e-8)
    gap = [value(found.gap, e) for e in later]
    rate = sum(value(found.gap.diff(a), at) * at[b] for a, b in zip((*Q, *MORE[0]), (*RATES, *MORE[1]), strict=True))
    assert (gap[0] - gap[1]) / 2e-6 == pytest.approx(rate, rel=1e-7)


def test_a_line_that_moves_with_time():
    point = sf.mechanics.Point(X, Y, q=[X, Y], u=[U, V])
    belt = sf.mechanics.against_line(point, through=(2 * T, sp.sin(T)), direction=(3, 0))
    assert belt == (Y - sp.sin(T), U - 2, (0, 1))
    wall = sf.mechanics.against_line(point, through=(1, 0), direction=(0, 1))
    assert wall[:2] == (1 - X, V)


def test_kinetic_energy_gives_the_equations_of_a_pendulum():
    phi, w = sp.symbols("phi w", real=True)
    m, J, length, g = sp.symbols("m J l g", positive=True)
    rod = sf.mechanics.Body(length * sp.sin(phi), -length * sp.cos(phi), phi, q=[phi], u=[w])
    system = sf.mechanics.lagrange(kinetic=rod.kinetic(m, J), potential=m * g * rod.y, q=[phi], u=[w])
    assert sp.simplify(system.mass[0] - (J + m * length**2)) == 0
    assert sp.simplify(system.force[0] + m * g * length * sp.sin(phi)) == 0


def test_falling_rod_slips_where_the_pinned_one_asks_for_more_friction():
    """While its tip stays the rod is pinned, with F/N in closed form; it slips first where that is mu."""
    start, mu = 0.1, 0.3
    rod = sf.mechanics.Body(X, Y, TH, q=Q, u=RATES)
    tip = sf.mechanics.against_line(rod.point(-sp.Rational(1, 2), 0))
    scene = sf.Scene(
        system=sf.System(q=Q, u=RATES, mass=sp.diag(1, 1, sp.Rational(1, 12)), force=[0, -9.81, 0]),
        contacts=[sf.Contact("tip", slip=tip.slip, normal=sf.Unilateral(tip.gap), law=sf.laws.coulomb(mu))],
        initial={X: np.sin(start) / 2, Y: np.cos(start) / 2, TH: np.pi / 2 - start, U: 0, V: 0, OM: 0},
        horizon=0.7,
    )
    run = sf.simulate(scene, tolerance=1e-12)
    event = run.events[0]
    assert event.kind == "slip"
    a = np.pi / 2 - run(event.t)[2]  # from the vertical; omega^2 = 3 g (cos a0 - cos a), alpha = 3/2 g sin a
    spin2, spinning = 3 * 9.81 * (np.cos(start) - np.cos(a)), 1.5 * 9.81 * np.sin(a)
    F = 0.5 * (spinning * np.cos(a) - spin2 * np.sin(a))
    N = 9.81 - 0.5 * (spinning * np.sin(a) + spin2 * np.cos(a))
    assert abs(F / N) == pytest.approx(mu, rel=1e-9)


@pytest.mark.long(beside="test_a_line_that_moves_with_time")
def test_an_eccentric_cam_and_its_expression_are_one():
    y, v = sp.symbols("y v", real=True)
    e, R, w = sp.Rational(1, 5), 1, 6
    tip = sf.mechanics.Point(0, y, q=[y], u=[v])
    cam = sf.mechanics.Body(0, 0, w * T, q=[y], u=[v])
    touch = sf.mechanics.against_circle(tip, cam.point(0, e), R)
    height = e * sp.cos(w * T) + sp.sqrt(R**2 - e**2 * sp.sin(w * T) ** 2)
    runs = [
        sf.simulate(
            sf.Scene(
                system=sf.System(q=[y], u=[v], mass=[[1]], force=[-1 - y]),
                contacts=[sf.Contact("cam", slip=None, normal=sf.Unilateral(gap, restitution=0.5))],
                initial={y: 1.2, v: 0.0},
                horizon=3.0,
            ),
            tolerance=1e-12,
        )
        for gap in (touch.gap, y - height)
    ]
    assert len(runs[0].events) == len(runs[1].events) >= 3
    assert runs[0].final == pytest.approx(runs[1].final, abs=1e-8)
    assert value(touch.slip.subs({y: height}), {v: 0.0, T: 0.0}) == pytest.approx(float(w * (R + e)))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sf.mechanics.Point(X, Y, q=[X, Y], u=[U]), "2 coordinates in q and 1 velocities in u"),
        (lambda: sf.mechanics.Body(X, U, TH, q=Q, u=RATES), "y of a body contains the velocity u"),
        (lambda: sf.mechanics.against_line((X, Y)), "give a sf.mechanics.Point"),
        (
            lambda: sf.mechanics.against_line(two_bodies()[0].point(0, 0), direction=(0, 0)),
            "direction of a line is zero",
        ),
        (lambda: sf.mechanics.against_line(two_bodies()[0].point(0, 0), through=(1, 2, 3)), "its two components"),
        (lambda: sf.mechanics.against_circle(two_bodies()[0], (0, 0), 1), "give a sf.mechanics.Point"),
    ],
)
def test_bad_geometry_is_one_line(make, said):
    with pytest.raises(sf.SceneError, match=said):
        make()
