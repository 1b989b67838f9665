"""Parameters that are built into the equations of a scene as numbers."""

import sympy as sp

from symfric.model.scene import Scene


def constants(scene: Scene, varied: frozenset[str] = frozenset()) -> dict[sp.Symbol, sp.Expr]:
    """Return the parameters that are built into the equations as numbers, except those in `varied`.

    They are those that are exactly zero, and those inside an integral of a law, whose series holds for one value each.
    """
    return {**averaged_over(scene, varied), **vanishing(scene, varied)}


def averaged_over(scene: Scene, varied: frozenset[str] = frozenset()) -> dict[sp.Symbol, sp.Float]:
    """Return the parameters inside an integral of a law, except those in `varied`."""
    integrals = [e for c in scene.contacts for e in c.law.kinetic.atoms(sp.Integral)]
    inside = set().union(*(e.free_symbols for e in integrals))
    return {s: sp.Float(v) for s, v in scene.values.items() if s in inside and v and s.name not in varied}


def vanishing(scene: Scene, varied: frozenset[str] = frozenset()) -> dict[sp.Symbol, sp.Integer]:
    """Return the parameters that are exactly zero and may be dropped from the equations, except those in `varied`."""
    zero = {s: sp.Integer(0) for s, v in scene.values.items() if v == 0 and s.name not in varied}
    kept = dict(zero)
    for symbol in zero:
        changed = [e.xreplace({symbol: sp.Integer(0)}) for e in _expressions(scene) if symbol in e.free_symbols]
        if any(e.has(sp.nan, sp.zoo, sp.oo, -sp.oo) for e in changed):
            del kept[symbol]
    return kept


def _expressions(scene: Scene) -> list[sp.Expr]:
    parts = [*scene.system.expressions, *scene.clocked]
    for c in scene.contacts:
        parts += c.expressions
    return parts
