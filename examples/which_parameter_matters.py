"""Which uncertain value of a brake pad decides how strongly it vibrates? Sobol indices of a thousand runs by SALib.

The static and the kinetic coefficient, the damping and the speed of the disc are known to a few percent only.
No published value was found to compare with.
"""

import numpy as np
import scipy.stats
import sympy as sp
from SALib.analyze import sobol
from SALib.sample import sobol as points

import symfric as sf

mu_s, mu_k = sp.symbols("mu_s mu_k", positive=True)
law = sf.laws.stribeck(mu_s, mu_k, 0.5)
pad = sf.scenes.mass_on_belt(law, v_b=0.3, beta=0.05, horizon=150.0).where({mu_s: 0.4, mu_k: 0.25})
(q,) = pad.system.q
pad = pad.wanting({"half_range": sf.HalfRange(q)})
known = {
    "mu_s": scipy.stats.norm(0.40, 0.02),
    "mu_k": scipy.stats.norm(0.25, 0.02),
    "beta": scipy.stats.uniform(0.03, 0.04),
    "v_b": scipy.stats.norm(0.30, 0.01),
}

drawn = sf.sweep(pad, sf.draw(known, 512, seed=1, repeats=4))
told = sf.spread(drawn["half_range"])
low, middle, high = told["quantiles"].values
print(f"half range: {middle:.3f}, nine of ten between {low:.3f} and {high:.3f}; {int(told['lost'])} runs failed")
share = sf.probability(drawn["half_range"], above=0.36)
print(f"above 0.36 with probability {float(share.probability):.3f} +- {float(share.standard_error):.3f}")

names = list(known)
problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
unit = points.sample(problem, 256, calc_second_order=False, seed=1)
columns = {n: known[n].ppf(np.clip(u, 1e-9, 1 - 1e-9)) for n, u in zip(names, unit.T, strict=True)}
found = sf.sweep(pad, sf.CaseTable(columns))["half_range"].values
indices = sobol.analyze(problem, found, calc_second_order=False, seed=1)
for name, first, error, total in zip(names, indices["S1"], indices["S1_conf"], indices["ST"], strict=True):
    print(f"{name}: first-order index {first:.2f} +- {error:.2f}, total {total:.2f}")
print(f"Most of the scatter comes from {names[int(np.argmax(indices['S1']))]}.")
