"""Find friction in the plane that is typed as a force, ``-mu*N*u/sqrt(u**2 + w**2)``."""

from collections.abc import Collection, Sequence

import sympy as sp

from symfric.errors import SceneError
from symfric.model.tree import parts_of


def refuse_typed_friction(forces: Sequence[sp.Expr], velocities: Collection[sp.Symbol]) -> None:
    """Raise if a force has the direction of a slip vector, which is that of friction in the plane."""
    for i, force in enumerate(forces):
        slips = _slips_of(force, velocities)
        if slips is not None:
            shown = ", ".join(map(str, slips))
            raise SceneError(
                f"force[{i}] has the direction of ({shown}), which has no value at rest; friction in the plane is a "
                f"contact: leave it out of all forces and add sf.Contact(name, slip=({shown}), normal=..., law=...)"
            )


def _slips_of(force: sp.Expr, velocities: Collection[sp.Symbol]) -> tuple[sp.Expr, ...] | None:
    """Return the components of a slip vector by whose length one of them is divided; None if there is no such quotient.

    It has no value where the vector is zero. A length with a constant beside it, which never is zero, is none.
    """
    candidates = []
    for product in parts_of(force, sp.Mul):
        powers = dict(factor.as_base_exp() for factor in product.args)
        for base, exponent in powers.items():
            if exponent != -sp.S.Half or not base.is_Add or not all(e.is_Pow and e.exp == 2 for e in base.args):
                continue
            slips = tuple(sorted((e.base for e in base.args), key=str))
            moving = all(s.free_symbols & set(velocities) for s in slips)
            if moving and any(s in powers or -s in powers for s in slips):
                candidates.append(slips)
    return min(candidates, key=str, default=None)
