"""While a car starts to move, when does its clutch begin to judder?

A disc of 0.15 kg m^2 on a shaft of 6000 N m/rad; two faces, each pressed on with 2500 N at a radius of 0.1 m. The
coefficient of friction falls from 0.14 at rest to 0.10 over v_s = 0.5 m/s. Slip at the speed v = R Omega feeds small
vibration by 2 N R^2 |mu'(v)|, and the shaft takes c: it grows below Omega = (v_s/R) ln(2 N R^2 0.04/(v_s c)).
"""

from math import log

import sympy as sp

import symfric as sf

phi, w = sp.symbols("phi w", real=True)
J, k, c, N, R, Omega, T = sp.symbols("J k c N R Omega T", positive=True)
shaft = sf.System(q=[phi], u=[w], mass=[[J]], force=[-k * phi - c * w])
law = sf.laws.stribeck(0.14, 0.10, 0.5)
values = {J: 0.15, k: 6000.0, c: 1.0, N: 2500.0, R: 0.1, Omega: 12.0}  # kg m2, N m/rad, N m s/rad, N, m, rad/s
faces = sf.Contact("faces", slip=R * (w - Omega), normal=2 * N, law=law)
steady = sf.Scene(shaft, [faces], values, {phi: 0.0, w: 0.0}, horizon=1.0)
for damping in (0.5, 1.0, 2.0):
    onset = sf.hopf(steady.where({c: damping}), Omega, bracket=(0.1, 50.0)).value
    told = 0.5 / 0.1 * log(2 * 2500 * 0.1**2 * 0.04 / (0.5 * damping))
    print(f"c = {damping:g} N m s/rad: steady slip judders below {onset:.6f} rad/s, closed form {told:.6f}")

begin = 1.01 * sf.equilibrium(steady).x[0]  # a little off
slowing = Omega * (1 - sf.TIME / T)  # the car takes T to catch up with the engine
faces = sf.Contact("faces", slip=R * (w - slowing), normal=2 * N, law=law)
for lasts in (0.5, 2.0, 4.0):
    engaging = sf.Scene(shaft, [faces], values | {T: lasts}, {phi: begin, w: 0.0}, horizon=0.999 * lasts)
    run = sf.simulate(engaging).checked()
    sticks = [event.t for event in run.events if event.kind == "stick"]
    print(f"engaged within {lasts:g} s: sticks first at a slip of {12 * (1 - sticks[0] / lasts):.2f} rad/s", end=", ")
    print(f"{len(sticks)} times until it has caught up" if len(sticks) > 1 else "and stays")
