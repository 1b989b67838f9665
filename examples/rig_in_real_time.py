"""Can a controller that samples every 2 ms quieten a groaning brake, tried on the model in real time?

On a test rig the controller is hardware and the brake a model in steps of fixed length: the load on the pad is a
parameter that may change between two steps. Here the controller is a few lines of Python; with the C code that
`sf.export.write_c` writes, the same steps take about a microsecond each.
No published value was found to compare with; the steps are compared with the event-driven motion.
"""

import tempfile
from pathlib import Path

import numpy as np
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
m, c, k, N, v_b = sp.symbols("m c k N v_b", positive=True)
disc = sf.Contact("disc", slip=u - v_b, normal=N, law=sf.laws.stribeck(0.55, 0.38, 0.12))
pad = sf.Scene(
    sf.System([x], [u], [[m]], [-k * x - c * u]),
    [disc],
    {m: 0.6, c: 60.0, k: 6e5, N: 300.0, v_b: 0.1},
    {x: 0.0, u: 0.0},
    0.1,
)
step = 2e-5
print(f"steps of {1e6 * step:.0f} us: wrong by {sf.export.stepper(pad, step).error():.0e} of the vibration in 100 ms")

model = sf.export.stepper(pad, step, outputs={})
p, load = model.values, model.parameters.index("N")
y, memory = model.start(model.initial, 0.0, p, [], [])
times, places, loads, heard = [], [], [], []
for n in range(20_000):
    y, memory, status = model.advance(y, memory, n * step, p, [], [], step)
    heard.append(float(y[0]))
    if n % 100 == 99:  # the controller, every 2 ms: less load while the pad vibrates, more when it is quiet
        vibrates = np.ptp(heard) > 20e-6
        p[load] = np.clip(p[load] * (0.97 if vibrates else 1.004), 50.0, 300.0)
        heard.clear()
    times.append(1e3 * (n + 1) * step)
    places.append(1e6 * float(y[0]))
    loads.append(p[load])
first, last = (np.ptp(places[i : i + 2000]) / 2 for i in (0, len(places) - 2000))
print(f"the pad groans by +-{first:.0f} um under 300 N, and by +-{last:.0f} um under {loads[-1]:.0f} N at the end")

with tempfile.TemporaryDirectory() as folder:
    print("for the rig:", sf.export.write_c(pad, Path(folder) / "pad.c", step))
