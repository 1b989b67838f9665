"""From which shaking on does a seat rattle in its rail, and how hard does it strike?

A slide of 2 kg with a play of +-1 mm, pressed into its rail so that friction holds F = 10 N. It rests in the rail up to
an acceleration a = F/m, and slides without striking for a while. Where it strikes twice in a period 2 T, each time with
the speed v of which e remains, momentum and way between two strikes give v in closed form, p the phase of a strike:
(2 a/Omega) cos(p) = v (1 - e) + T F/m and (2 a/Omega^2) sin(p) = 2 g - v (1 + e) T/2.
"""

from math import pi, sqrt

import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)  # of the slide in its rail
m, F, g, e, a, Omega = sp.symbols("m F g e a Omega", positive=True)
slide = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[m * a * sp.sin(Omega * sf.TIME)]),
    contacts=[
        sf.Contact("rail", slip=u, normal=F, law=sf.laws.coulomb(1)),
        sf.Contact("front", slip=None, normal=sf.Unilateral(g - x, restitution=e)),
        sf.Contact("back", slip=None, normal=sf.Unilateral(g + x, restitution=e)),
    ],
    values={m: 2.0, F: 10.0, g: 1e-3, e: 0.4, a: 4.0, Omega: 2 * pi * 30},  # kg, N, m, -, m/s2, rad/s
    initial={x: 0.0, u: 0.0},
    horizon=3.0,
)
W, T, r, f = 2 * pi * 30, 1 / 60, 0.4, 10.0 / 2.0
for shaking in (4.99, 5.01, 18.0, 22.0):
    run = sf.simulate(slide.where({a: shaking}), 1e-11).checked()
    strikes = [event for event in run.events if event.kind == "impact"]
    if strikes:  # a v^2 + b v + c = 0 from the sum of the squares
        p, q = W / (2 * shaking), W**2 / (2 * shaking)
        square = p**2 * (1 - r) ** 2 + q**2 * (1 + r) ** 2 * T**2 / 4
        half = p**2 * (1 - r) * T * f - q**2 * 2e-3 * (1 + r) * T / 2
        rest = p**2 * T**2 * f**2 + q**2 * 4e-6 - 1
        told = (-half + sqrt(half**2 - square * rest)) / square
        speed = abs(run.before(strikes[-1].t)[1])
        print(f"{shaking:g} m/s2: strikes with {speed:.7f} m/s, closed form {told:.7f} m/s")
    else:
        moves = any(event.kind == "slip" for event in run.events)
        print(f"{shaking:g} m/s2: {'slides without striking' if moves else 'rests'}")
