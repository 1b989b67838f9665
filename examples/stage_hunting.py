"""Why does a positioning stage under PID control never come to rest, and which force or sampling changes that?

A stage of 1 kg on a guide with 1.5 N of static and 1 N of Coulomb friction. The integrator pulls until the stage breaks
away, it slips past the target, and everything begins again on the other side.
"""

import sympy as sp

import symfric as sf

gains = {"k_p": 4.0, "k_d": 1.0, "k_i": 1.0}
told = sf.theory.hunting(**gains, F_s=1.5, F_c=1.0)
cycle = sf.limit_cycle(sf.scenes.positioning_stage(**gains))
print(f"hunts {1e3 * told.offset:.3f} mm about the target every {told.period:.3f} s; ", end="")
print(f"computed {1e3 * cycle.half_range[0]:.3f} mm, {cycle.period:.3f} s")

for compensation in (0.5, 0.9):  # of the Coulomb friction, towards the target
    scene = sf.scenes.positioning_stage(**gains, compensation=compensation, x0=told.offset, horizon=400.0)
    x = scene.system.q[0]
    late = sf.simulate(scene.wanting({"x": sf.Samples(x, [200.0 + i for i in range(200)])}))["x"]
    print(f"with {compensation:.0%} of the friction compensated: {1e3 * max(abs(late)):.3f} mm")

# Sampled control: the force and the sum of the errors are held between the samples.
x, u = sp.symbols("x u", real=True)
guide = sf.Contact("guide", slip=u, normal=1, law=sf.laws.coulomb(1.5, 1.0))
for dt in (0.05, 0.4):
    summed = sf.Held("sum", update=sp.Symbol("sum.previous", real=True) + x * dt, every=dt)
    command = -gains["k_p"] * x - gains["k_d"] * u - gains["k_i"] * summed.symbol
    force = sf.Held("force", update=command, every=dt)
    stage = sf.System(q=[x], u=[u], mass=[[1]], force=[force.symbol])
    late = {"high": sf.Max(x, after=150.0), "low": sf.Min(x, after=150.0)}
    scene = sf.Scene(stage, [guide], {}, {x: told.offset, u: 0.0}, 300.0, late, held=[summed, force])
    run = sf.simulate(scene).checked()
    print(f"sampled every {dt:g} s: {1e3 * max(run['high'], -run['low']):.2f} mm")
