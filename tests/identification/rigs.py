"""A mass on a belt with Stribeck friction, as a rig whose records are fitted, and the bounds of its unknowns."""

import numpy as np
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
MU_S, MU_K, V_S, V_B = sp.symbols("mu_s mu_k v_s v_b", positive=True)
T = np.linspace(0.0, 96.0, 301)[1:]
BOUNDS = {"mu_s": (0.1, 0.8), "mu_k": (0.05, 0.6), "v_s": (1e-3, 1.0)}


def rig(**values):
    belt = sf.Contact("belt", U - V_B, 1, sf.laws.stribeck(MU_S, MU_K, V_S))
    numbers = {MU_S: 0.4, MU_K: 0.25, V_S: 0.1, V_B: 0.2}
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X - U / 20]), [belt], numbers, {X: 0.0, U: 0.0}, 96.0)
    return scene.where(values) if values else scene
