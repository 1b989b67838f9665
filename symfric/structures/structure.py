"""A structure given by its matrices, as a finite element program leaves them."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sps
import sympy as sp

from symfric.errors import SceneError
from symfric.long_calls import logged
from symfric.model.outputs import Output
from symfric.model.results import Result
from symfric.model.scene import Scene
from symfric.model.symbols import Key, finite, listed
from symfric.model.system import Signal
from symfric.spelling import spelt
from symfric.structures.checks import matrix, names_of, positive_definite, symmetric
from symfric.structures.complex_modes import ComplexModes, Pencil, complex_modes, shift_of
from symfric.structures.contacts import RowContact
from symfric.structures.definiteness import Verdict, verdict_of
from symfric.structures.real_modes import Modes, real_modes
from symfric.structures.reduction import ReductionError, errors_of, reduce
from symfric.structures.rows import kept_rows, row_in
from symfric.structures.scenes import doubt_of_friction, scene_of

_ROUNDING = 1e-13  # entry beside its row and column that is rounding of a projection
_FRICTION = "give what friction or a follower load adds as `friction`, which mu multiplies"


@spelt
@dataclass(frozen=True, eq=False, repr=False)
class Structure(Result):
    """``M q'' + C q' + (K + mu F) q = f`` with sparse matrices; units are those of the matrices.

    Parameters
    ----------
    M, K : array_like or sparse, shape (n, n)
        Symmetric, M positive definite. Both are kept sparse.
    C : array_like or sparse, shape (n, n), optional
        Damping, gyroscopic forces.
    friction : array_like or sparse, shape (n, n), optional
        F, what mu multiplies in the stiffness; not symmetric: the forces of steady sliding under loads that move, or of
        a follower load (then mu is the load).
    names : sequence of str, optional
        Of the degrees of freedom; ``q1, q2, ...`` unless given.

    Attributes
    ----------
    M, K : scipy.sparse.csr_array
    C, friction : scipy.sparse.csr_array or None
        None also where all entries given are zero.
    names : tuple of str
    basis : ndarray, shape (n_full, n), or None
        Of a reduced structure, how all degrees of freedom follow from its own.
    error : ReductionError or None
        Of a reduced structure, estimates of what the reduction costs.
    full_names : tuple of str
        Of a reduced structure, the names of all degrees of freedom; `names` of any other.

    Raises
    ------
    SceneError
        If a matrix has the wrong shape, an entry that is not finite, lacks symmetry, or M is not positive definite.

    Examples
    --------
    >>> import symfric as sf
    >>> s = sf.structures.Structure([[1, 0], [0, 1]], [[2, -1], [-1, 2]])
    >>> s.modes(2).frequency.round(6).tolist()
    [1.0, 1.732051]
    """

    M: sps.csr_array
    K: sps.csr_array
    C: sps.csr_array | None = None
    friction: sps.csr_array | None = None
    names: tuple[str, ...] = ()
    basis: np.ndarray | None = None
    error: ReductionError | None = field(default=None, init=False)
    full_names: tuple[str, ...] = field(default=(), init=False)

    def __init__(
        self,
        M: Any,
        K: Any,
        C: Any = None,
        friction: Any = None,
        names: Sequence[str] | None = None,
        *,
        basis: np.ndarray | None = None,
    ) -> None:
        mass = matrix(M, "M")
        n = mass.shape[0]
        labels = names_of(names, n)
        mass = symmetric(mass, "M", "a mass matrix must be")
        positive_definite(mass, labels)
        stiffness = symmetric(matrix(K, "K", n), "K", _FRICTION)
        others = {
            name: None if given is None else matrix(given, name, n)
            for name, given in (("C", C), ("friction", friction))
        }
        kept = {name: None if e is None or not e.nnz else e for name, e in others.items()}
        for name, value in {
            "M": mass,
            "K": stiffness,
            **kept,
            "names": labels,
            "basis": basis,
            "error": None,
            "full_names": labels,
        }.items():
            object.__setattr__(self, name, value)  # the class is frozen for everybody else

    @property
    def n(self) -> int:
        """Number of degrees of freedom."""
        return len(self.names)

    @property
    def symbols(self) -> tuple[tuple[sp.Symbol, ...], tuple[sp.Symbol, ...]]:
        """Coordinates and velocities as they are called in a scene: ``tip`` and ``d_tip``; for outputs and forces."""
        q = tuple(sp.Symbol(name, real=True) for name in self.names)
        return q, tuple(sp.Symbol(f"d_{name}", real=True) for name in self.names)

    def stiffness(self, mu: float = 0.0) -> sps.csr_array:
        """Return ``K + mu F``, shape (n, n).

        Parameters
        ----------
        mu : float
            Coefficient of friction.

        Returns
        -------
        csr_array

        Raises
        ------
        SceneError
            If mu is not zero and the structure has no friction matrix.

        Examples
        --------
        >>> import symfric as sf
        >>> chain = sf.structures.chain(20, damping=0.02)
        >>> chain.stiffness().shape
        (20, 20)
        """
        value = finite(mu, "mu")
        if value == 0:
            return self.K
        if self.friction is None:
            raise SceneError(f"mu is {value:g} and the structure has no friction matrix; give it as `friction`")
        return sps.csr_array(self.K + value * self.friction)

    @logged
    def modes(self, count: int, near: float = 0.0) -> Modes:
        """Return the undamped modes nearest to a frequency, without friction.

        Parameters
        ----------
        count : int
        near : float
            In rad/time.

        Returns
        -------
        Modes

        Raises
        ------
        SceneError
            If there are not so many modes.
        NotFound
            If the iteration does not converge, or K has a negative eigenvalue.

        Notes
        -----
        Shift-invert Lanczos; that no mode is missing is proved by counting the eigenvalues between two shifts, see
        `symfric.structures.real_modes`.

        Examples
        --------
        >>> import symfric as sf
        >>> s = sf.structures.chain(40, ends="free")
        >>> s.modes(3).rigid
        1
        """
        return real_modes(self.K, self.M, count, finite(near, "near"), self.names)

    @logged
    def complex_modes(self, count: int, mu: float = 0.0, near: complex | float = 0.0) -> ComplexModes:
        """Return the modes of the damped structure with friction nearest to a point.

        Parameters
        ----------
        count : int
        mu : float
        near : float or complex
            A frequency in rad/time, or a point of the complex plane of lambda.

        Returns
        -------
        ComplexModes

        Raises
        ------
        SceneError
            If there are not so many modes, or mu is given without a friction matrix.
        NotFound
            If the iteration does not converge.

        Examples
        --------
        >>> import symfric as sf
        >>> round(float(sf.structures.ziegler().complex_modes(2, mu=2.5).eigenvalues.real.max()), 3)
        0.322
        """
        return complex_modes(self.pencil(mu), count, shift_of(near), float(mu), self.names)

    def pencil(self, mu: float) -> Pencil:
        """Return the matrices of the eigenvalue problem.

        Parameters
        ----------
        mu : float
            Coefficient of friction.

        Returns
        -------
        Pencil

        Examples
        --------
        >>> import symfric as sf
        >>> chain = sf.structures.chain(20, damping=0.02)
        >>> chain.pencil(0.0).M.shape
        (20, 20)
        """
        return Pencil(self.M, self.C, self.stiffness(mu))

    def definiteness(self, mu: float = 0.0) -> Verdict:
        """Return what the definiteness of symmetric parts proves of the stability, by sparse factors.

        Parameters
        ----------
        mu : float

        Returns
        -------
        Verdict
            (definiteness, reason); see `symfric.structures.definiteness`.

        Examples
        --------
        >>> import symfric as sf
        >>> sf.structures.chain(100, damping=0.1).definiteness().definiteness
        'stable'
        """
        return verdict_of(self.pencil(mu))

    def row(self, entries: Any) -> np.ndarray:
        """Return a row over the degrees of freedom, shape (n,).

        Parameters
        ----------
        entries : array_like, sparse, mapping of name to number, or name
            Of a reduced structure, a row over all degrees of freedom is taken, too.

        Returns
        -------
        ndarray

        Examples
        --------
        >>> import symfric as sf
        >>> chain = sf.structures.chain(20, damping=0.02)
        >>> chain.row({"x5": 1.0}).shape
        (20,)
        """
        return row_in(self, entries)

    @logged
    def reduced(self, keep: Any = (), modes: int = 20) -> "Structure":
        """Return a smaller structure with some rows kept as coordinates, by the method of Craig and Bampton.

        Parameters
        ----------
        keep : sequence
            What contacts, forces and outputs act on: numbers or names of degrees of freedom, rows (n,) over all of
            them, mappings of names to weights, or `RowContact`, of which the slip row and the row of the load are kept.
            Rows that follow from those before them are left out. None for modal truncation.
        modes : int
            Number of modes with these rows held.

        Returns
        -------
        Structure
            Its degrees of freedom are the kept rows (by their names, or ``row1, row2, ...``), then ``p1, p2, ...``. It
            has `basis` and `error`, and takes rows over all degrees of freedom of this one.

        Raises
        ------
        SceneError
            If a row or the number of modes is wrong.
        NotFound
            If the iteration does not converge.

        Examples
        --------
        >>> import symfric as sf
        >>> full = sf.structures.chain(200)
        >>> small = full.reduced(keep=["x50", "x150"], modes=10)
        >>> small.n, small.names[:3], bool(small.error.frequency_error[0] < 1e-4)
        (12, ('x50', 'x150', 'p1'), True)
        """
        labels, rows = kept_rows(self, keep)
        basis, cut = reduce(self.K, self.M, rows, modes)
        small = self._projected(basis, [*labels, *(f"p{i + 1}" for i in range(basis.shape[1] - len(labels)))])
        object.__setattr__(small, "error", errors_of(self, basis, small, rows, cut))
        return small

    def diagonal(self) -> "Structure":
        """Return the same in the coordinates of its own undamped modes: M is 1, K diagonal.

        Every entry of the matrices then costs no more than one product, whatever was kept before; for structures of
        some hundred degrees of freedom, as `reduced` leaves them.

        Returns
        -------
        Structure
            With `basis`; its degrees of freedom are ``p1, p2, ...``.

        Examples
        --------
        >>> import symfric as sf
        >>> sf.structures.chain(30).reduced(["x15"], modes=5).diagonal().K.nnz
        6
        """
        values, shapes = sla.eigh(self.K.toarray(), self.M.toarray())
        terms = np.sum(np.abs(shapes) * (abs(self.K) @ np.abs(shapes)), axis=0)
        values = np.where(np.abs(values) <= 1e-14 * terms, 0.0, values)
        diagonal = self._projected(shapes, [f"p{i + 1}" for i in range(self.n)])
        object.__setattr__(diagonal, "M", sps.csr_array(sps.eye_array(self.n)))
        object.__setattr__(diagonal, "K", sps.csr_array(sps.diags_array(values)))
        object.__setattr__(diagonal, "error", self.error)
        return diagonal

    def _projected(self, basis: np.ndarray, names: Sequence[str]) -> "Structure":
        """Return the structure with ``q = basis @ y``."""
        M, K, C, F = (
            None if e is None else _clean(basis.T @ (e @ basis)) for e in (self.M, self.K, self.C, self.friction)
        )
        projected = Structure(M, K, C, F, names, basis=basis if self.basis is None else self.basis @ basis)
        object.__setattr__(projected, "full_names", self.full_names)
        return projected

    def scene(
        self,
        contacts: Sequence[RowContact] = (),
        force: Any = None,
        values: Mapping[Key, float | None] = MappingProxyType({}),
        initial: Any = None,
        outputs: Mapping[str, Output] | None = None,
        horizon: float = 100.0,
        *,
        mu: Any = None,
        observe: Mapping[str, object] = MappingProxyType({}),
        inputs: Mapping[Key, Signal] = MappingProxyType({}),
    ) -> Scene:
        """Return a scene of this structure; its matrices stay numbers.

        Parameters
        ----------
        contacts : sequence of RowContact
        force : mapping, or sequence of pairs (row, expression), or of n expressions, optional
            Forces, by the name of a degree of freedom or along rows: expressions of time, parameters, the coordinates
            and velocities in `symbols`, and the names in `observe`.
        values : mapping of parameter to number
        initial : mapping of state to number, or array (n,) or (2 n,), optional
            Velocities are called ``d_<name>``; what is not given is zero.
        outputs : mapping of name to Output, optional
        horizon : float
        mu : number, Symbol or Expr, optional
            Factor of the friction matrix, which is added to K. Without it the matrix is left out, because contacts
            bring friction of their own; 0 says that this is meant. A warning follows if the matrix is not what the
            loads of the contacts bring and is left out, or if it is and counts twice.
        observe : mapping of name to row
            Names for combinations of the degrees of freedom, ``<name>`` and ``d_<name>``, which outputs and forces may
            contain; of a reduced structure also rows over all degrees of freedom.
        inputs : mapping of parameter to Signal
            Sampled forces, by the symbols that stand for them in `force`.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            If a row, a name or a number is wrong, or a structure with a friction matrix gets neither contacts nor `mu`.

        Examples
        --------
        >>> import symfric as sf
        >>> s = sf.structures.chain(6, ends="fixed-free")
        >>> pad = sf.structures.RowContact("pad", {"x6": 1.0}, 1.0, sf.laws.coulomb(0.4, 0.3), speed=0.2)
        >>> sf.simulate(s.scene([pad], horizon=50.0)).status.name
        'OK'
        """
        contacts = listed(contacts, "contacts")
        scene = scene_of(self, contacts, force, values, initial, outputs, horizon, mu, observe, inputs)
        if doubt := doubt_of_friction(self, contacts, mu):
            warnings.warn(doubt, stacklevel=2)
        return scene

    def expand(self, q: np.ndarray) -> np.ndarray:
        """Return the motion of all degrees of freedom of which this structure is a reduction.

        Parameters
        ----------
        q : ndarray, shape (n,) or (n, n_t)

        Returns
        -------
        ndarray, shape (n_full,) or (n_full, n_t)
            `q` itself if the structure is not reduced.

        Raises
        ------
        SceneError
            If q has another length than the reduced structure.

        Examples
        --------
        >>> import numpy as np
        >>> import symfric as sf
        >>> chain = sf.structures.chain(20, damping=0.02)
        >>> small = chain.reduced(["x5"], modes=3)
        >>> small.expand(np.ones(small.n)).shape
        (20,)
        """
        q = np.asarray(q)
        if q.shape[:1] != (self.n,):
            raise SceneError(f"q has shape {q.shape}; its first axis needs {self.n} entries")
        return q if self.basis is None else self.basis @ q

    def to_dict(self) -> dict[str, Any]:
        parts = {name: getattr(self, name) for name in ("M", "K", "C", "friction")}
        return {"degrees_of_freedom": self.n, "entries": {k: 0 if e is None else e.nnz for k, e in parts.items()}}

    def __repr__(self) -> str:
        parts = [name for name in ("C", "friction") if getattr(self, name) is not None]
        words = f", with {' and '.join(parts)}" if parts else ""
        full = f" of {len(self.basis)}" if self.basis is not None else ""
        error = f", reduced to {self.error.worst:.2g}" if self.error is not None else ""
        return f"Structure({self.n}{full} degrees of freedom, {self.K.nnz} entries in K{words}{error})"


def _clean(A: np.ndarray) -> np.ndarray:
    """Return a projected matrix without the entries that are rounding beside their row and column."""
    size = np.sqrt(np.maximum(np.abs(np.diag(A)), np.finfo(float).tiny))
    return np.where(np.abs(A) <= _ROUNDING * np.maximum(np.outer(size, size), np.max(np.abs(A)) * 1e-6), 0.0, A)
