"""A disc with a pad in plane strain: a small finite element model of a brake that squeals."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.model.laws import Law
from symfric.model.symbols import finite, positive
from symfric.spelling import spelt
from symfric.structures.checks import positive_count
from symfric.structures.contacts import RowContact, RowLoad
from symfric.structures.structure import Structure

_POISSON = 0.3


@dataclass(frozen=True, eq=False, repr=False)
class Brake:
    """A disc and a pad, with the rows of their contacts.

    Attributes
    ----------
    structure : Structure
        With all contacts closed and sliding: its stiffness holds the springs of the contacts, its friction matrix what
        mu multiplies; its names are ``d<column>_<row>x`` and ``...y``
        of the nodes of the disc, ``p...`` of those of the pad.
    apart : Structure
        Without the springs of the contacts and without friction, for scenes: `contacts` brings both.
    slips, loads : ndarray, shape (n_c, n)
        Of every pair of nodes in contact: velocity of the pad over the disc, and normal force beyond the preload.
    places : ndarray, shape (n, 2)
        Of the node of every degree of freedom, along the disc and across.

    Examples
    --------
    >>> import symfric as sf
    >>> brake = sf.structures.disc_and_pad(damping=0.3)
    >>> len(brake.contacts(preload=0.01, law=sf.laws.coulomb(0.5), speed=0.02))
    7
    """

    structure: Structure
    apart: Structure
    slips: np.ndarray
    loads: np.ndarray
    places: np.ndarray

    def contacts(self, preload: float, law: Law, speed: float) -> list[RowContact]:
        """Return one contact for each pair of nodes, which opens where its load is zero; for scenes of `apart`.

        Parameters
        ----------
        preload : float or Symbol
            Normal force of each pair.
        law : Law
        speed : float or Symbol
            Of the disc.

        Returns
        -------
        list[RowContact]
        """
        contacts = []
        for i, (slip, load) in enumerate(zip(self.slips, self.loads, strict=True)):
            push = -load / np.max(np.abs(load))
            contacts.append(RowContact(f"pair{i + 1}", slip, RowLoad(preload, load, push), law, speed))
        return contacts

    def __repr__(self) -> str:
        return f"Brake({self.structure.n} degrees of freedom, {len(self.slips)} pairs of nodes in contact)"


@spelt
def disc_and_pad(
    columns: int = 40,
    *,
    width: int = 6,
    height: int = 3,
    E_disc: float = 1.0,
    E_pad: float = 0.1,
    contact: float = 0.05,
    backing: float = 0.005,
    hub: float = 0.05,
    damping: float = 0.0,
) -> Brake:
    """Return the unrolled rim of a disc with a pad pressed on it.

    Parameters
    ----------
    columns : int
        Elements around the disc, each 1 long; it is 2 elements of 1 thick.
    width, height : int
        Elements of the pad.
    E_disc, E_pad : float
        Moduli of elasticity; the density of both is 1.
    contact, backing, hub : float
        Stiffness of the springs between each pair of nodes, behind each node of the back of the pad, and under each
        node of the disc.
    damping : float
        Time constant, ``C = damping K``.

    Returns
    -------
    Brake

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    Four-node elements in plane strain with 2 x 2 Gauss points and lumped mass (Bathe, Finite Element Procedures, 5.3).
    The disc moves in the direction x under the pad; friction ``mu N`` drags the pad along and holds the disc back, and
    ``N = N0 + k_c (y_disc - y_pad)`` couples it with the motion across: the friction matrix is not symmetric, and two
    modes merge (North 1976; Hoffmann et al., Journal of Sound and Vibration 2002).

    Examples
    --------
    >>> import symfric as sf
    >>> sf.structures.disc_and_pad()
    Brake(296 degrees of freedom, 7 pairs of nodes in contact)
    """
    columns = positive_count(columns, 100_000, "the number of columns")
    width, height = positive_count(width, 1000, "the width"), positive_count(height, 1000, "the height")
    if columns < width + 2:
        raise SceneError(f"a disc of {columns} columns has no room for a pad of {width}; give at least {width + 2}")
    for name, value in (("E_disc", E_disc), ("E_pad", E_pad), ("contact", contact), ("backing", backing), ("hub", hub)):
        positive(value, name)
    disc = [[(c, r) for r in range(3)] for c in range(columns)]
    node = {("d", *p): i for i, p in enumerate(p for line in disc for p in line)}
    first = len(node)
    node |= {
        ("p", c, r): first + i for i, (c, r) in enumerate((c, r) for c in range(width + 1) for r in range(height + 1))
    }
    n = 2 * len(node)
    K, mass = sps.lil_array((n, n)), np.zeros(n)
    blocks = [("d", c, r, columns, E_disc) for c in range(columns) for r in range(2)]
    blocks += [("p", c, r, width + 1, E_pad) for c in range(width) for r in range(height)]
    for part, c, r, around, E in blocks:
        corners = [
            node[part, i % around if part == "d" else i, j] for i, j in ((c, r), (c + 1, r), (c + 1, r + 1), (c, r + 1))
        ]
        dofs = np.array([2 * k + e for k in corners for e in (0, 1)])
        K[np.ix_(dofs, dofs)] += _element(E)
        mass[dofs] += 0.25
    for c in range(columns):
        for e in (0, 1):
            K[2 * node["d", c, 0] + e, 2 * node["d", c, 0] + e] += hub
    for c in range(width + 1):
        for e in (0, 1):
            K[2 * node["p", c, height] + e, 2 * node["p", c, height] + e] += backing
    begin = (columns - width) // 2
    pairs = [(node["p", c, 0], node["d", begin + c, 2]) for c in range(width + 1)]
    free = sps.csr_array(K)
    slips, loads = np.zeros((len(pairs), n)), np.zeros((len(pairs), n))
    F = sps.lil_array((n, n))
    for i, (above, below) in enumerate(pairs):
        slips[i, [2 * above, 2 * below]] = 1.0, -1.0
        loads[i, [2 * above + 1, 2 * below + 1]] = -contact, contact
        across = np.array([2 * above + 1, 2 * below + 1])
        K[np.ix_(across, across)] += contact * np.array([[1.0, -1.0], [-1.0, 1.0]])
        F[2 * above, across], F[2 * below, across] = [contact, -contact], [-contact, contact]
    names = [f"{part}{c}_{r}{'xy'[e]}" for part, c, r in node for e in (0, 1)]
    where = [(c + (begin if part == "p" else 0), r + (2 if part == "p" else 0)) for part, c, r in node]
    stiff = sps.csr_array(K)
    M = sps.diags_array(mass)
    damping = finite(damping, "damping")
    structure = Structure(M, stiff, damping * stiff if damping else None, F, names)
    apart = Structure(M, free, damping * stiff if damping else None, None, names)
    return Brake(structure, apart, slips, loads, np.repeat(np.array(where, dtype=float), 2, axis=0))


def _element(E: float) -> np.ndarray:
    """Return the stiffness of a square of side 1 in plane strain, shape (8, 8)."""
    a = E / ((1 + _POISSON) * (1 - 2 * _POISSON))
    D = a * np.array([[1 - _POISSON, _POISSON, 0], [_POISSON, 1 - _POISSON, 0], [0, 0, 0.5 - _POISSON]])
    total, at = np.zeros((8, 8)), 0.5 / np.sqrt(3)
    for x in (-at, at):
        for y in (-at, at):
            by_x, by_y = [y - 0.5, 0.5 - y, 0.5 + y, -0.5 - y], [x - 0.5, -0.5 - x, 0.5 + x, 0.5 - x]
            B = np.zeros((3, 8))
            B[0, 0::2], B[1, 1::2], B[2, 0::2], B[2, 1::2] = by_x, by_y, by_y, by_x
            total += 0.25 * B.T @ D @ B
    return total
