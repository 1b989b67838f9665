"""Small structures for tests and examples: beams, chains, Ziegler's pendulum, a disc with a pad."""

from typing import Any, Literal

import numpy as np
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of
from symfric.model.symbols import finite, positive, shortened
from symfric.spelling import spelt
from symfric.structures.checks import positive_count
from symfric.structures.structure import Structure

End = Literal["free", "pinned", "clamped"]


@spelt
def beam(
    elements: int,
    *,
    length: float = 1.0,
    EI: float = 1.0,
    rhoA: float = 1.0,
    left: End = "clamped",
    right: End = "free",
    load: Literal["follower", "axial"] | None = None,
    damping: float = 0.0,
) -> Structure:
    """Return an Euler-Bernoulli beam of cubic elements.

    Parameters
    ----------
    elements : int
        Of equal length.
    length, EI, rhoA : float
        Length, bending stiffness, mass per length.
    left, right : {"free", "pinned", "clamped"}
    load : {"follower", "axial"}, optional
        A compression P at the right end, along its tangent or along the axis; mu stands for P.
    damping : float
        Time constant of internal damping, ``C = damping K``.

    Returns
    -------
    Structure
        Degrees of freedom ``w0, r0, w1, r1, ...``: deflections and slopes of the nodes that are free.

    Raises
    ------
    SceneError
        If a number is out of range or the end is not known.

    Notes
    -----
    Consistent matrices (Przemieniecki, Theory of Matrix Structural Analysis, 1968, 5.6, 11.4 and 15.2). A follower load
    adds the work of its transverse component, ``-P w'(L) delta w(L)``. Clamped and free with the follower load it is
    Beck's column, ``P L^2/EI = 20.0509536`` at ``omega sqrt(rhoA L^4/EI) = 11.0155576``.

    Examples
    --------
    >>> import symfric as sf
    >>> beck = sf.structures.beam(16, load="follower")
    >>> round(sf.structures.flutter(beck, mu=(0, 30), count=3).critical[0].mu, 3)
    20.051
    """
    count = positive_count(elements, 100_000, "the number of elements")
    length, EI, rhoA = (positive(v, n) for v, n in ((length, "length"), (EI, "EI"), (rhoA, "rhoA")))
    damping = finite(damping, "damping")
    h, n = length / count, 2 * (count + 1)
    bend = EI / h**3 * _hermite([12, 6, -12, 6], [4, -6, 2], [12, -6], [4], h)
    mass = rhoA * h / 420 * _hermite([156, 22, 54, -13], [4, 13, -3], [156, -22], [4], h)
    slope = _hermite([36, 3, -36, 3], [4, -3, -1], [36, -3], [4], h) / (30 * h)
    K, M, G = (_assembled(e, count, n) for e in (bend, mass, slope))
    F = None
    if load is not None:
        if not is_one_of(load, ("follower", "axial")):
            raise SceneError(f"load is {shortened(load)}; use 'follower', 'axial' or None")
        F = sps.lil_array(-G)
        if load == "follower":
            F[n - 2, n - 1] += 1.0
    kept = np.array([k for k in range(n) if k not in _held(left, 0) + _held(right, n - 2)])
    if not kept.size:
        raise SceneError("no degree of freedom of the beam is free; give more elements")
    names = [f"{'wr'[k % 2]}{k // 2}" for k in kept]
    parts = (M, K, damping * K if damping else None, F)
    m, k, c, f = (None if A is None else sps.csr_array(sps.csr_array(A)[kept][:, kept]) for A in parts)
    return Structure(m, k, c, f, names)


def _held(end: str, first: int) -> list[int]:
    held = {"free": [], "pinned": [first], "clamped": [first, first + 1]}
    if not is_one_of(end, held):
        raise SceneError(f"the end of the beam is {shortened(end)}; use 'free', 'pinned' or 'clamped'")
    return held[end]


def _hermite(first: Any, second: Any, third: Any, fourth: Any, h: float) -> np.ndarray:
    """Return a symmetric element matrix from its upper rows, lengths multiplied in where slopes are meant."""
    full = np.zeros((4, 4))
    for i, row in enumerate((first, second, third, fourth)):
        full[i, i:] = row
    full = full + np.triu(full, 1).T
    scale = np.array([1.0, h, 1.0, h])
    return full * np.outer(scale, scale)


def _assembled(element: np.ndarray, count: int, n: int) -> sps.csr_array:
    places = 2 * np.arange(count)[:, None] + np.arange(4)
    rows, columns = np.repeat(places, 4, axis=1), np.tile(places, (1, 4))
    data = np.tile(element.ravel(), (count, 1))
    return sps.csr_array(sps.coo_array((data.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n)))


@spelt
def chain(
    n: int,
    *,
    mass: float = 1.0,
    stiffness: float = 1.0,
    damping: float = 0.0,
    ground: float = 0.0,
    ends: Literal["fixed", "free", "fixed-free"] = "fixed",
) -> Structure:
    """Return equal masses in a row, with springs between neighbours.

    Parameters
    ----------
    n : int
    mass, stiffness, damping : float
        Of each mass and of each spring with its damper.
    ground : float
        Stiffness of a spring from each mass to the ground.
    ends : {"fixed", "free", "fixed-free"}
        Whether springs hold the first and the last mass, neither, or the first only.

    Returns
    -------
    Structure
        Degrees of freedom ``x1, x2, ...``.

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    Fixed ends give ``omega_j = 2 sqrt(k/m) sin(j pi/(2 (n + 1)))``.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.structures.chain(2).modes(2).frequency.round(6).tolist()
    [1.0, 1.732051]
    """
    n = positive_count(n, 10_000_000, "the number of masses")
    positive(mass, "mass"), positive(stiffness, "stiffness")
    damping, ground = finite(damping, "damping"), finite(ground, "ground")
    if not is_one_of(ends, ("fixed", "free", "fixed-free")):
        raise SceneError(f"ends is {shortened(ends)}; use 'fixed', 'free' or 'fixed-free'")
    diagonal = np.full(n, 2.0)
    diagonal[0] -= ends == "free"
    diagonal[-1] -= ends != "fixed"
    off = -np.ones(n - 1)
    shape = sps.diags_array([diagonal, off, off], offsets=[0, 1, -1], shape=(n, n))
    K = stiffness * shape + ground * sps.eye_array(n)
    C = damping * shape if damping else None
    return Structure(mass * sps.eye_array(n), K, C, None, [f"x{i + 1}" for i in range(n)])


@spelt
def ziegler(*, damping: float = 0.0, m: float = 1.0, k: float = 1.0, l: float = 1.0) -> Structure:
    """Return Ziegler's double pendulum under a follower load; mu stands for the load P.

    Parameters
    ----------
    damping : float
        Of both joints.
    m, k, l : float
        Masses 2m and m at the ends of rods of length l, stiffness of both joints.

    Returns
    -------
    Structure
        Degrees of freedom ``phi1, phi2``.

    Notes
    -----
    Ziegler, Ingenieur-Archiv 20 (1952) 49. Without damping flutter begins at ``P l/k = 7/2 - sqrt(2)``; with damping c
    of both joints at ``41/28 + c^2/(2 k m l^2)`` (Herrmann and Jong, Journal of Applied Mechanics 32, 1965, 592).

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.structures.flutter(sf.structures.ziegler(damping=0.1), mu=(0, 3), count=2).critical[0].mu, 9)
    1.469285714
    """
    M = positive(m, "m") * positive(l, "l") ** 2 * np.array([[3.0, 1.0], [1.0, 1.0]])
    joints = np.array([[2.0, -1.0], [-1.0, 1.0]])
    C = finite(damping, "damping") * joints if damping else None
    return Structure(M, positive(k, "k") * joints, C, l * np.array([[-1.0, 1.0], [0.0, 0.0]]), ["phi1", "phi2"])
