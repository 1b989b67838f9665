"""How fast does the bit of a drill string turn after it was stuck, and how long does it stick?

A bit of 374 kg m^2 at the end of pipes of 473 N m/rad, turned at the top with a constant speed; the rock takes 2 kN m
more torque at rest than in motion. The pendulum of Kyllingstad and Halsey (SPE Drilling Engineering 3, 1988, 369): with
a = dT/sqrt(k J) the bit reaches Omega + sqrt(Omega^2 + a^2), sticks for 2 dT/(k Omega) and slips for
2 (pi - atan(a/Omega))/sqrt(k/J).
"""

from math import atan, pi, sqrt

import sympy as sp

import symfric as sf

theta, w = sp.symbols("theta w", real=True)  # of the bit, relative to the top
J, k, c, Omega = sp.symbols("J k c Omega", positive=True)
T_s, T_k = 8000.0, 6000.0  # N m
rock = sf.Contact("rock", slip=w + Omega, normal=1, law=sf.laws.coulomb(T_s, T_k))  # a torque
string = sf.Scene(
    system=sf.System(q=[theta], u=[w], mass=[[J]], force=[-k * theta - c * w]),
    contacts=[rock],
    values={J: 374.0, k: 473.0, c: 0.0, Omega: 10.0},  # kg m2, N m/rad, N m s/rad, rad/s
    initial={theta: -T_s / 473.0, w: -10.0},
    horizon=60.0,
    outputs={"path": sf.Trajectory(), "fastest": sf.Max(w + Omega)},
)
rate, a = sqrt(473.0 / 374.0), (T_s - T_k) / sqrt(473.0 * 374.0)
for rpm in (30, 60, 120):
    top = rpm * 2 * pi / 60
    orbit = sf.limit_cycle(string.where({Omega: top}).starting({w: -top}))
    print(f"{rpm} rpm: the bit reaches {(orbit.x_max[1] + top) * 30 / pi:.4f} rpm", end="; ")
    print(f"closed form {(top + sqrt(top**2 + a**2)) * 30 / pi:.4f}")
    stick = 2 * (T_s - T_k) / (473.0 * top)
    slip = 2 * (pi - atan(a / top)) / rate
    print(f"   sticks {orbit.stick_time:.5f} of {orbit.period:.5f} s; closed form {stick:.5f} of {stick + slip:.5f} s")
