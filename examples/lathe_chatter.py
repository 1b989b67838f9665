"""How wide may a chip be before a lathe chatters? The tool cuts into the waves that it left a turn ago.

The force on the tool is K times the thickness of the chip: the feed, less the way of the tool now, plus that of one
turn ago, which is sampled 60 times a turn, held and delayed: semi-discretization. At the border the tool vibrates with
w, where tan(w tau/2) = -(m w^2 - k)/(c w) and K = (m w^2 - k)/(1 - cos(w tau)): the lobes of Tobias and Tlusty, none of
which falls below K = 2 k zeta (1 + zeta).
"""

from math import atan, cos, pi

import numpy as np
import sympy as sp
from scipy.optimize import brentq

import symfric as sf

x, u = sp.symbols("x u", real=True)  # of the tool, from where it cuts evenly
K, tau = sp.symbols("K tau", positive=True)  # stiffness of the cut, time of a turn; m = k = feed = 1
zeta = 0.05
turn_ago = sp.Symbol("before", real=True)
thick = 1 + turn_ago - x  # of the chip; none where the tool has left the work, which then keeps its surface
before = sf.Held("before", update=sp.Min(x, 1 + turn_ago), every=tau / 60, delay=tau * sp.Rational(119, 120))
lathe = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[1]], force=[-x - 2 * zeta * u + K * (sp.Max(0, thick) - 1)]),
    values={K: 0.2, tau: 5.0},
    initial={x: 1e-6, u: 0.0},
    horizon=300.0,
    outputs={"energy": sf.Samples(x**2 + u**2, np.linspace(100, 299, 400))},
    held=[before],
)
program = sf.prepare(lathe)


def growth(stiffness, turn):
    """Growth of a small vibration, from the middle of the run to its end."""
    early, late = np.split(program.run({K: stiffness, tau: turn})["energy"], 2)
    return np.log(late.sum() / early.sum())


for turn in (4.0, 5.0, 9.0):
    found = brentq(growth, 0.05, 0.25, args=(turn,), xtol=1e-7)
    n = 1 + turn // (2 * pi)  # of the lobe
    w = brentq(lambda w, t=turn, n=n: w * t / 2 + atan((w**2 - 1) / (2 * zeta * w)) - n * pi, 1.0, 2.0)
    print(f"a turn of {turn:g}: chatters from K = {found:.5f}, closed form {(w**2 - 1) / (1 - cos(w * turn)):.5f}")
print(f"at no speed below K = {2 * zeta * (1 + zeta):.5f}")

deep = lathe.wanting({"moves": sf.HalfRange(x, after=250.0), "least": sf.Min(thick)}).starting({x: 0.1})
for stiffness in (0.1, 0.12, 0.3):
    run = sf.simulate(deep.where({K: stiffness}).until(600.0)).checked()
    print(f"K = {stiffness:g}: the tool moves by +-{run['moves']:.3f} of the feed", end=", ")
    print("leaves the work" if run["least"] < 0 else "stays in the work")
