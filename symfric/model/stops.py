"""End stops and backlash: two contacts that open, on one line."""

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.symbols import expression, legible
from symfric.model.system import Contact
from symfric.model.unilateral import Unilateral


@alone(SYMBOLIC)
def stops(
    x: sp.Expr,
    low: float | sp.Expr,
    high: float | sp.Expr,
    restitution: float | sp.Expr = 0.0,
    *,
    name: str = "stop",
) -> tuple[Contact, Contact]:
    """Return the two contacts that keep a coordinate between two ends: end stops, or the backlash of a joint.

    Parameters
    ----------
    x : Expr
        Of coordinates; the difference of two for backlash between two bodies.
    low, high : float or Expr
        ``low <= x <= high``; may depend on coordinates, time and parameters.
    restitution : float or Expr
        Of both ends, from 0 to 1.
    name : str
        The contacts are called ``<name>_low`` and ``<name>_high``.

    Returns
    -------
    tuple of Contact
        Without friction. The normal force of the lower one pushes x up, that of the upper one down.

    Raises
    ------
    SceneError
        If the ends are numbers in the wrong order.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> scene = sf.Scene(
    ...     system=sf.System(q=[x], u=[u], mass=[[1]], force=[0]),
    ...     contacts=sf.stops(x, -1, 1, restitution=0.5),
    ...     initial={x: 0.0, u: 2.0},
    ...     horizon=3.0,
    ... )
    >>> [(e.t, e.contact, e.kind) for e in sf.simulate(scene).events]
    [(0.5, 'stop_high', 'impact'), (2.5, 'stop_low', 'impact')]
    """
    legible(name, "a pair of stops")
    x, low, high = expression(x, "x of stops"), expression(low, "low of stops"), expression(high, "high of stops")
    if (high - low).is_nonpositive:
        raise SceneError(f"the ends of the stops {name!r} are {low} and {high}; the lower one comes first")
    return (
        Contact(f"{name}_low", slip=None, normal=Unilateral(x - low, restitution)),
        Contact(f"{name}_high", slip=None, normal=Unilateral(high - x, restitution)),
    )
