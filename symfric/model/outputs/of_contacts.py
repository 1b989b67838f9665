"""Symbols that stand for what happens in a contact, for use inside output expressions."""

import sympy as sp

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of
from symfric.model.symbols import shortened
from symfric.spelling import spelt


@spelt
def friction_force(contact: str, component: int | None = None) -> sp.Symbol:
    """Return the friction force of a contact (on the body, along its slip) for use inside output expressions.

    Parameters
    ----------
    contact : str
        Its name.
    component : {0, 1}, optional
        Of the force of a contact in the plane, along the first or the second of its slips.

    Returns
    -------
    Symbol

    Raises
    ------
    SceneError
        If the component is neither 0 nor 1.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> v_b = belt.parameter("v_b")
    >>> run = sf.simulate(belt.wanting({"work": sf.Integral(sf.friction_force("belt") * v_b)}))
    >>> round(run["work"], 6)
    5.793097
    """
    if not is_one_of(component, (None, 0, 1)):
        raise SceneError(f"the component of a friction force is {shortened(component)}; in the plane there are 0 and 1")
    return sp.Symbol(f"friction_force({contact}{'' if component is None else f', {component}'})", real=True)


@spelt
def slip(contact: str) -> sp.Symbol:
    """Return the slip velocity of a contact for use inside output expressions; in the plane the speed, zero in flight.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.simulate(belt.wanting({"fastest": sf.Max(sf.slip("belt"))}))["fastest"], 6)
    0.0
    """
    return sp.Symbol(f"slip({contact})", real=True)


@spelt
def normal_force(contact: str) -> sp.Symbol:
    """Return the normal force of a contact, for use inside output expressions.

    That of a contact that opens may also stand in forces, loads and profiles, such as the load of another contact;
    they must be linear in it.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol

    Notes
    -----
    That of a contact that opens is the force between impacts. Over the last bounces of a body that comes to rest, which
    are lower than the tolerance, it is that of the closed contact: an integral of it is right to the root of the
    tolerance only.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> y, v = sp.symbols("y v", real=True)
    >>> block = sf.Scene(
    ...     system=sf.System(q=[y], u=[v], mass=[[2]], force=[-20 - sp.sin(sf.TIME)]),
    ...     contacts=[sf.Contact("floor", slip=None, normal=sf.Unilateral(y))],
    ...     initial={y: 0.0, v: 0.0},
    ...     horizon=3.0,
    ...     outputs={"largest": sf.Max(sf.normal_force("floor"))},
    ... )
    >>> round(sf.simulate(block)["largest"], 9)
    21.0
    """
    return sp.Symbol(f"normal_force({contact})", nonnegative=True)


@spelt
def stored_energy(contact: str) -> sp.Symbol:
    """Return the energy stored in a contact, for use inside output expressions; zero unless its law has memory.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol
        Normal load times ``law.memory.stored``: force times length.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.stored_energy("belt")
    stored_energy(belt)
    """
    return sp.Symbol(f"stored_energy({contact})", real=True)


@spelt
def dissipated_power(contact: str) -> sp.Symbol:
    """Return the power that becomes heat in a contact, for use inside output expressions.

    Parameters
    ----------
    contact : str
        Its name.

    Returns
    -------
    Symbol
        Power of the slip against friction less what the contact stores at the present load: force times velocity.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.Integral(sf.dissipated_power("belt"))
    Integral(expr=dissipated_power(belt))
    """
    return sp.Symbol(f"dissipated_power({contact})", real=True)


OF_CONTACTS = {f.__name__: f for f in (friction_force, slip, normal_force, stored_energy, dissipated_power)}
