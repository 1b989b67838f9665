"""A structure with its contacts closed and sliding, for stability: their springs in K, their friction as a matrix."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.sparse as sps
import scipy.sparse.linalg as spla
import sympy as sp

from symfric.errors import SceneError
from symfric.long_calls import logged
from symfric.model.arguments import items
from symfric.model.symbols import Key, expression, mapped, name_of, shortened
from symfric.structures.contacts import RowContact, RowLoad
from symfric.structures.rows import row_in
from symfric.structures.structure import Structure

_ALIKE = 1e-9  # relative asymmetry of a contact's spring that is rounding


@logged
def sliding(
    structure: Structure,
    contacts: Sequence[RowContact],
    values: Mapping[Key, float | None] = MappingProxyType({}),
) -> Structure:
    """Return the structure on which all contacts slide with the same coefficient of friction, for `flutter`.

    Parameters
    ----------
    structure : Structure
        As given to `Structure.scene`. Its friction matrix is kept if it has one.
    contacts : sequence of RowContact
    values : mapping of parameter to number
        Of the speeds, whose sign is the direction of the friction.

    Returns
    -------
    Structure
        K with the springs of contacts whose load pushes, and the friction matrix of loads that follow the structure.

    Raises
    ------
    SceneError
        If the speed of a contact is zero or no number, a push is not along its load, or no load follows the structure.

    Notes
    -----
    Under the load ``N = N0 + l q`` a contact with the slip row s and the speed v pulls with ``sign(v) mu N s``, and
    the spring of its load pushes with ``(l q) p``: ``K - p l + mu (-sign(v) s l)`` is the stiffness of small motions
    about steady sliding. The slope of a coefficient that depends on the speed adds damping and is left out.

    Examples
    --------
    The structure that `disc_and_pad` has for its stability, from its contacts:

    >>> import symfric as sf
    >>> brake = sf.structures.disc_and_pad(12, width=2)
    >>> contacts = brake.contacts(preload=0.01, law=sf.laws.coulomb(0.4), speed=0.02)
    >>> found = sf.structures.sliding(brake.apart, contacts)
    >>> bool(abs(found.K - brake.structure.K).max() < 1e-15), found.friction.nnz == brake.structure.friction.nnz
    (True, True)
    """
    if not isinstance(structure, Structure):
        raise SceneError(f"{shortened(structure)} is no sf.structures.Structure")
    numbers = {name_of(key): value for key, value in mapped(values, "values", "{'name': 1.0}").items()}
    stiffness, friction = structure.K, sps.csr_array((structure.n, structure.n))
    for contact in items(contacts, "contacts"):
        if not isinstance(contact.normal, RowLoad):
            continue
        what = f"contact {contact.name!r}"
        load = row_in(structure, contact.normal.row, f"the row of the load of {what}")
        slip = row_in(structure, contact.row, f"the row of {what}")
        factor = _number(contact.profile, numbers, f"the profile of {what}")
        way = np.sign(_number(contact.speed, numbers, f"the speed of {what}"))
        if way == 0:
            raise SceneError(f"the speed of {what} is zero: it does not slide; give another")
        friction = friction - way * factor * _outer(slip, load)
        if contact.normal.push is not None:
            spring = _outer(row_in(structure, contact.normal.push, f"push of {what}"), load)
            if abs(spring - spring.T).max() > _ALIKE * abs(spring).max():
                raise SceneError(f"push of {what} is not along the row of its load: no spring has such a stiffness")
            stiffness = stiffness - 0.5 * (spring + spring.T)
    if structure.friction is not None:
        friction = structure.friction
    elif not friction.nnz:
        raise SceneError("no load of a contact follows the structure, and there is no friction matrix")
    return Structure(structure.M, stiffness, structure.C, friction, structure.names)


def steady_loads(
    structure: Structure,
    contacts: Sequence[RowContact],
    values: Mapping[Key, float | None],
    mu: float,
) -> dict[str, float]:
    """Return the normal loads in steady sliding if all contacts were closed; one that is negative opens instead.

    Parameters
    ----------
    structure : Structure
    contacts : sequence of RowContact
    values : mapping of parameter to number
    mu : float
        Coefficient of friction of all contacts.

    Returns
    -------
    dict of str to float
        Of the contacts whose load follows the structure.
    """
    numbers = {name_of(key): value for key, value in mapped(values, "values", "{'name': 1.0}").items()}
    closed = sliding(structure, contacts, values)
    pull, loads = np.zeros(structure.n), {}
    for contact in contacts:
        normal, what = contact.normal, f"contact {contact.name!r}"
        start = normal.N0 if isinstance(normal, RowLoad) else normal
        preload = _number(start, numbers, f"the load of {what}")
        way = np.sign(_number(contact.speed, numbers, f"the speed of {what}"))
        factor = _number(contact.profile, numbers, f"the profile of {what}")
        pull += way * mu * factor * preload * row_in(structure, contact.row)
        if isinstance(normal, RowLoad):
            loads[contact.name] = preload, row_in(structure, normal.row)
    q = spla.spsolve(sps.csc_matrix(closed.stiffness(mu)), pull)
    return {name: float(preload + row @ q) for name, (preload, row) in loads.items()}


def _outer(column: np.ndarray, row: np.ndarray) -> sps.csr_array:
    return sps.csr_array(sps.csr_array(column[:, None]) @ sps.csr_array(row[None, :]))


def _number(given: Any, numbers: Mapping[str, float | None], what: str) -> float:
    """Return the number that an expression of parameters is."""
    e = expression(given, what)
    known = {s: numbers[s.name] for s in e.free_symbols if numbers.get(s.name) is not None}
    value = sp.sympify(e.subs(known))
    if not value.is_number:
        raise SceneError(f"{what} is {e}; give values of what is in it, or a constant")
    return float(value)
