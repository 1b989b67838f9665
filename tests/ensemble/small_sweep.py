"""A small sweep that several tests compare with, and a shaken mass."""

import numpy as np
import sympy as sp

import symfric as sf

X = sp.Symbol("x", real=True)


def small_scene():
    return sf.scenes.mass_on_belt(v_b=0.2, horizon=30.0).wanting(
        {"x_max": sf.Max(X), "half": sf.HalfRange(X), "end": sf.End(), "stop": sf.StopTime()}
    )


def small_grid():
    return {"v_b": np.linspace(0.05, 0.45, 9), sp.Symbol("beta"): [0.0, 0.03, 0.05], "a": [0.0, 0.001]}


def shaken(horizon=3.0):
    x, u, a_g = sp.symbols("x u a_g", real=True)
    k = sp.Symbol("k", positive=True)
    return sf.Scene(
        system=sf.System(q=[x], u=[u], mass=[[1]], force=[-k * x - a_g]),
        contacts=[sf.Contact("floor", slip=u, normal=1, law=sf.laws.coulomb(0.5))],
        values={k: 20.0},
        inputs={a_g: sf.Signal([0.0, 0.0], 1.0)},
        initial={x: 0.0, u: 0.0},
        horizon=horizon,
        outputs={"high": sf.Max(x)},
    )
