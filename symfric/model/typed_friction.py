"""Find friction in the plane that is typed as a force, ``-mu*N*u/sqrt(u**2 + w**2)``."""

from collections.abc import Collection, Sequence

import sympy as sp

from symfric.errors import SceneError


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
    if not any(e.exp == -sp.S.Half for e in force.atoms(sp.Pow)):
        return None
    for product in sorted(force.atoms(sp.Mul), key=str):
        powers = dict(factor.as_base_exp() for factor in product.args)
        for base, exponent in powers.items():
            if exponent != -sp.S.Half or not base.is_Add or len(base.args) < 2:
                continue
            slips = tuple(sorted((e.base for e in base.args if e.is_Pow and e.exp == 2), key=str))
            moving = all(s.free_symbols & set(velocities) for s in slips)
            if len(slips) == len(base.args) and moving and any(s in powers or -s in powers for s in slips):
                return slips
    return None
