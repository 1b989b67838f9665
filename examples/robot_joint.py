"""How much friction has a robot joint, and how stiff is it before it slips? LuGre's law from torque and encoder.

The joint swings back and forth under a motor torque of 1.2 N m; its encoder resolves 0.1 mrad.
No published value was found to compare with: the values are those that the record was made with.
"""

import numpy as np
import sympy as sp

import symfric as sf

q, u = sp.symbols("q u", real=True)
tau = sp.Symbol("tau", real=True)  # motor torque, recorded
J, mu_s, mu_c, v_s, sigma0, sigma1 = sp.symbols("J mu_s mu_c v_s sigma0 sigma1", positive=True)
true = {J: 0.1, mu_s: 0.5, mu_c: 0.35, v_s: 0.1, sigma0: 400.0, sigma1: 3.0}
t = np.linspace(0, 6, 301)
torque = 1.2 * np.sin(np.pi * t) * (0.6 + 0.4 * np.sin(0.8 * t))
gear = sf.Contact("gear", slip=u, normal=1, law=sf.laws.lugre(mu_s, mu_c, v_s, sigma0, sigma1, 0.05))  # torques in N m
system = sf.System(q=[q], u=[u], mass=[[J]], force=[tau])
joint = sf.Scene(system, [gear], true, {q: 0.0, u: 0.0}, 6.0, inputs={tau: sf.Signal(torque, t[1])})
angle = sf.simulate(joint)(t[1:])[0] + 1e-4 * np.random.default_rng(2).standard_normal(300)

guess = joint.where({J: 0.15, mu_s: 0.6, mu_c: 0.3, v_s: 0.2, sigma0: 200.0, sigma1: 1.0})
bounds = {"J": (0.03, 0.3), "mu_s": (0.2, 1.0), "mu_c": (0.1, 0.6), "v_s": (0.02, 0.5)}
bounds |= {"sigma0": (50.0, 5000.0), "sigma1": (0.1, 20.0)}
fit = sf.identify(guess, {"q": (t[1:], angle)}, bounds, sigma=1e-4, starts=1)
print(fit)
for name, value in true.items():
    off = abs(fit.values[name.name] - value) / fit.standard_errors[name.name]
    print(f"{name}: {fit.values[name.name]:.4g}, true {value:g}, {off:.1f} standard errors off")
print(
    f"The joint needs {fit.values['mu_s']:.2f} N m to break away and yields 1 mrad under "
    f"{1e-3 * fit.values['sigma0']:.2f} N m before."
)
