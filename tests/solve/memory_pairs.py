"""Scenes of two bodies with two contacts: a law with memory on one of them, and another contact beside it."""

import sympy as sp

import symfric as sf

X, Y, U, W = sp.symbols("x y u w", real=True)
T, SPEED = sf.TIME, 0.3

LAWS = {
    "dahl": sf.laws.dahl(0.3, 200.0),
    "dahl, stiff": sf.laws.dahl(0.3, 1e6),
    "lugre": sf.laws.lugre(0.4, 0.3, 0.1, 200.0, 5.0, 0.1),
    "lugre, stiff": sf.laws.lugre(0.4, 0.3, 0.1, 1e6, 1e3, 0.1),
    "elasto-plastic": sf.laws.elasto_plastic(0.4, 0.3, 0.1, 200.0, 5.0, 0.1, z_ba=1e-3),
    "elasto-plastic, stiff": sf.laws.elasto_plastic(0.4, 0.3, 0.1, 1e6, 1e3, 0.1, z_ba=2e-7),
    "maxwell slip": sf.laws.maxwell_slip([50.0, 20.0], [0.1, 0.2]),
    "iwan": sf.laws.iwan(0.3, -0.5, 0.05, elements=4),
    "bouc-wen": sf.laws.bouc_wen(20.0, 30.0, 20.0, 1.5),
    "bouc-wen, stiff": sf.laws.bouc_wen(1e5, 2e5, 1e5, 1.5),
    "aging": sf.laws.rate_and_state(0.6, 0.01, 0.015, 0.05, 0.1),
    "slip": sf.laws.rate_and_state(0.6, 0.01, 0.015, 0.05, 0.1, "slip"),
    "aging, soft": sf.laws.rate_and_state(0.3, 0.05, 0.06, 0.1, 0.1),
    "aging, not smooth": sf.laws.rate_and_state(0.3, 0.01, 0.015, 0.05, 0.1, smooth=False),
    "slip, not smooth": sf.laws.rate_and_state(0.3, 0.01, 0.015, 0.05, 0.1, "slip", smooth=False),
}

# slip, normal load, profile of the contact with memory
SLIPS = {
    "belt": (U - SPEED, 1, 1),
    "ground": (U, 1, 1),
    "bodies": (U - W, 1, 1),
    "moving belt": (U - SPEED * sp.cos(2 * T), 1, 1),
    "load over time": (U - SPEED, sp.Max(0, 1 + sp.sin(3 * T) / 2), 1),
    "load over place": (U - SPEED, sp.Max(0, 1 + sp.sin(X) / 2), 1),
    "profile": (U - SPEED, 1, 1 + sp.Abs(X) / 3),
}

OTHERS = {
    "alone": None,
    "coulomb": {"law": sf.laws.coulomb(0.2)},
    "cubic": {"law": sf.laws.cubic(0.4, 0.25, 0.5)},
    "regularised": {"law": sf.laws.coulomb(0.2).regularised(0.05, "tanh")},
    "spring": {"law": sf.laws.coulomb(0.2), "stiffness": 10.0},
} | {name: {"law": LAWS[name]} for name in ("lugre", "elasto-plastic", "maxwell slip", "aging", "lugre, stiff")}


def scene_of(law, slip, other, horizon=2.0, **outputs):
    """Return one scene of the family."""
    w, normal, profile = SLIPS[slip]
    contacts = [sf.Contact("a", w, normal, LAWS[law], profile=profile)]
    if OTHERS[other] is not None:
        contacts.append(sf.Contact("b", W, 1, **OTHERS[other]))
    system = sf.System([X, Y], [U, W], sp.eye(2), [-2 * X + Y - U / 10, X - 2 * Y + sp.sin(2 * T) / 3])
    start = {X: 0.5, Y: 0.4, U: 0.1, W: 0}
    return sf.Scene(system, contacts, {}, start, horizon, outputs or {"end": sf.End()})
