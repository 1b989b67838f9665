"""Which friction law does a stick-slip rig have? Fitted to the noisy displacement that a gauge recorded.

Half a kilogram on a leaf spring is pressed on a belt by 20 N; the gauge shows millimetres, with an unknown offset.
No published value was found to compare with: the record is compared with two laws.
"""

from pathlib import Path

import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
mu_s, mu_k, v_s, v_b = sp.symbols("mu_s mu_k v_s v_b", positive=True)
system = sf.System(q=[x], u=[u], mass=[[0.5]], force=[-200 * x - 0.4 * u])


def rig(law, **values):
    belt = sf.Contact("belt", slip=u - v_b, normal=20, law=law)
    return sf.Scene(system, [belt], {"v_b": 0.05, "mu_s": 0.5, "mu_k": 0.3, **values}, {x: 0.0, u: 0.0}, 3.0)


laws = {
    "Stribeck": rig(sf.laws.stribeck(mu_s, mu_k, v_s), v_s=0.1),
    "Coulomb": rig(sf.laws.coulomb(mu_s, mu_k)),
}
record = Path(__file__).with_name("rig_record.csv")
bounds = {"mu_s": (0.1, 1.0), "mu_k": (0.05, 0.6), "v_s": (0.01, 1.0), "gauge.offset": (-5.0, 5.0)}
found = sf.compare_laws(laws, str(record), bounds, observed={"gauge": 1000 * x})
print(found)
fit = found.best.fit
print(fit)
low, high = fit.profile("v_s").interval
print(f"The belt's law is {found.best.name}'s, with v_s between {1e3 * low:.0f} and {1e3 * high:.0f} mm/s.")
best = sf.test_design(fit, {"v_b": [0.01, 0.02, 0.05, 0.1, 0.2]})
speed, error = best.chosen[0]["v_b"], best.standard_errors[0]["v_s"]
print(f"A second record at {1e3 * speed:.0f} mm/s would fix v_s to {1e3 * error:.1f} mm/s.")
