"""Contacts of a structure: rows of numbers in place of expressions."""

from dataclasses import dataclass
from typing import Any

from symfric.errors import SceneError
from symfric.model.laws import Law


@dataclass(frozen=True, eq=False)
class RowLoad:
    """A normal load that follows the structure, ``max(0, N0 + row @ q)``: where it is zero the contact is open.

    Parameters
    ----------
    N0 : number, Symbol or Expr
        The load where q = 0; may depend on parameters and time.
    row : array_like or sparse, shape (n,), or mapping of name to weight
        Minus the stiffness of the contact times what changes its gap.
    push : like `row`, optional
        How the load moves the structure: what it has more than N0 acts along it, ``(max(0, N0 + row @ q) - N0) push``.
        Without it the stiffness of the contact is part of K, also where the contact is open.

    Examples
    --------
    >>> import symfric as sf
    >>> load = sf.structures.RowLoad(1.0, {"y": 2.0}, push={"y": -1.0})
    """

    N0: Any
    row: Any
    push: Any = None

    @property
    def kept(self) -> tuple[Any, ...]:
        """What a reduction must keep for it."""
        return (self.row,) if self.push is None else (self.row, self.push)


@dataclass(frozen=True, eq=False)
class RowContact:
    """A dry contact of a structure; its slip is ``row @ u - speed``.

    Parameters
    ----------
    name : str
    row : array_like or sparse, shape (n,), or mapping of name to weight
        Of a reduced structure also a row over all degrees of freedom.
    normal : number, Symbol, Expr or RowLoad
    law : Law
    speed : number, Symbol or Expr
        Of what the structure slides on; may depend on parameters and time.
    profile : number or Expr
        Factor of the coefficient of friction.
    stiffness : number, Symbol or Expr, optional
        Of a spring in series: the slider has no mass and sticks and slips exactly (Jenkins element). The elongation is
        the first-order state ``<name>.z``; the law must be ``sf.laws.coulomb(mu)``.

    Raises
    ------
    SceneError
        If the name or the law is none.

    Notes
    -----
    See `symfric.model.springs` for the equations of a contact with a stiffness.

    Examples
    --------
    >>> import symfric as sf
    >>> contact = sf.structures.RowContact("pad", {"x3": 1.0}, 1.0, sf.laws.coulomb(0.3), speed=0.1)

    A joint that gives before it slips: the largest force is 0.3, that of a displacement of 0.6.

    >>> joint = sf.structures.RowContact("joint", {"x3": 1.0}, 1.0, sf.laws.coulomb(0.3), stiffness=0.5)
    >>> scene = sf.structures.chain(3).scene([joint], {"x3": 0.5 * sf.TIME}, horizon=4.0)
    >>> run = sf.simulate(scene)
    >>> [(e.before, e.after) for e in run.events], round(float(0.5 * run["joint.z"][-1]), 12)
    ([(0, 1)], 0.3)
    """

    name: str
    row: Any
    normal: Any
    law: Law
    speed: Any = 0.0
    profile: Any = 1
    stiffness: Any = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError(f"the name of a contact is {self.name!r}; it must be a string")
        if not isinstance(self.law, Law):
            raise SceneError(f"the law of contact {self.name!r} is {self.law!r}; use one of sf.laws")

    @property
    def kept(self) -> tuple[Any, ...]:
        """What a reduction must keep for it."""
        return (self.row, *self.normal.kept) if isinstance(self.normal, RowLoad) else (self.row,)
