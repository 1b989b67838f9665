"""Thirty calls of a user, as a type checker sees them: see ``tests/test_types.py``, which also runs them."""

import tempfile
from pathlib import Path

import numpy as np
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
k, v_b = sp.symbols("k v_b", positive=True)

law = sf.laws.stribeck(0.5, 0.3, 0.1)
contact = sf.Contact("belt", slip=u - v_b, normal=1, law=law)
system = sf.System(q=[x], u=[u], mass=[[1]], force=[-k * x])
lagrangian = sf.mechanics.lagrange(kinetic=u**2 / 2, potential=k * x**2 / 2, q=[x], u=[u])
own = sf.Scene(
    system,
    contacts=[contact],
    values={k: 1.0, "v_b": 0.2},
    initial={x: 0.0, u: 0.0},
    horizon=10.0,
    outputs={"size": sf.HalfRange(x), "end": sf.End()},
)
changes = {"v_b": 0.3}
faster = own.where(changes).until(5.0).wanting({"size": sf.HalfRange(x)})
latex = own.equations()

belt = sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0)
size = belt.wanting({"size": sf.HalfRange(belt.system.q[0])})
motion = sf.motions.sine_burst(3.0, 2.0, cycles=5)
isolator = sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motion, profile=0.02)

run = sf.simulate(belt, tolerance=1e-9)
at_two = run(2.0)
residual = run.energy_residual()
slopes = sf.simulate(size, sensitivities=["v_b"]).output_sensitivities
program = sf.prepare(size)
again = program.run({"v_b": 0.1})
batch = program.map({"v_b": np.linspace(0.1, 0.2, 3)})
why = sf.explain(belt)
function = sf.as_function(size, ["v_b"], ["size"])

steady = sf.equilibrium(belt)
stable = sf.stability(belt)
onset = sf.hopf(belt, "v_b", bracket=(0.3, 0.6))
slow = sf.average(belt)
speed = sf.theory.belt.onset_speed(belt)
formula = sf.theory.belt.onset_speed(symbolic=True)
limit = sf.theory.drive.threshold(-0.3, 0.3, -0.2)
orbit = sf.limit_cycle(belt)
branch = sf.continue_cycle(belt, "v_b", (0.19, 0.21))
table = sf.sweep(size, {"v_b": [0.1, 0.2]})

damper = sf.design.absorber(0.1, "hinf")
quench = sf.design.quench(belt, speeds=(0.1, 0.4), Omega=(20, 60), a=(0, 0.02))
structure = sf.structures.chain(4)
modes = structure.modes(2)
kept = structure.reduced([0, 3], modes=1)

with tempfile.TemporaryDirectory() as folder:
    steps = sf.export.stepper(size, 0.05)
    path = Path(folder) / "belt.toml"
    path.write_text('[scene]\nmodel = "mass_on_belt"\nhorizon = 5\n[values]\nv_b = 0.2\n')
    read = sf.read(path)
page = belt.until(5.0).study()
