"""When does a bouncing ball come to rest, and which impact oscillator stays on its one-impact orbit?

A ball with restitution e bounces infinitely often within the time sqrt(2 h/g) (1 + e)/(1 - e); the run ends its
bounces at that limit. A mass that a force drives against a stop once in a period has an orbit in closed form; its
multipliers have the product e^2 exp(-2 zeta T), whatever the rest, by the impact and the damping alone.
"""

from math import exp, pi, prod, sqrt

import sympy as sp

import symfric as sf

y, v = sp.symbols("y v", real=True)
ball = sf.System(q=[y], u=[v], mass=[[1]], force=[-9.81])
for e in (0.5, 0.8):
    floor = sf.Contact("floor", slip=None, normal=sf.Unilateral(y, e))
    run = sf.simulate(sf.Scene(ball, [floor], values={}, initial={y: 1.0, v: 0.0}, horizon=6.0)).checked()
    rest = [event for event in run.events if event.kind == "close"][-1].t
    hits = sum(event.kind == "impact" for event in run.events)
    told = sqrt(2 / 9.81) * (1 + e) / (1 - e)
    print(f"e = {e:g}: rests after {rest:.7f} s and {hits} impacts, closed form {told:.7f} s")

zeta, Omega, e = 0.05, 2.2, 0.7
driven = sf.scenes.impact_oscillator(e=e, zeta=zeta, Omega=Omega, F=1.0, gap=0.0)
orbit = sf.limit_cycle(driven)
told = e**2 * exp(-2 * zeta * 2 * pi / Omega)
print(f"multipliers {orbit.multipliers[0]:.6f}, {orbit.multipliers[1]:.6f}")
print(f"product {abs(prod(orbit.multipliers)):.9f}, closed form {told:.9f}")
