"""Stability of steady sliding: linearised equations, stability theorems and eigenvalues."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from symfric.axes import Axes, axes_for
from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.notebook import html_table
from symfric.model.results import COMPLEX, ArrayResult, Drawable, Labelled
from symfric.model.scene import Scene
from symfric.theory.equilibrium import solve
from symfric.theory.hurwitz import Hurwitz, characteristic_coefficients, routh_hurwitz
from symfric.theory.sliding import Field, field_of

ROUNDING = 1e-12  # size of a matrix entry relative to the matrix below which it is zero
_NOTHING = 1e-30  # eigenvalue relative to the largest that is the rounding of a zero one
PARTS = ("damping", "gyroscopic", "stiffness", "circulatory")


@dataclass(frozen=True, eq=False, repr=False)
class Stability(ArrayResult, Drawable):
    """Linearised motion about steady sliding, ``M q'' + B q' + K q = 0``, friction included.

    `plot` draws the eigenvalues in the complex plane.

    Attributes
    ----------
    M, B, K : ndarray, shape (n, n)
        Mass, damping and gyroscopic, stiffness and circulatory matrix; the parts are `damping`, `gyroscopic`,
        `stiffness` and `circulatory`.
    definiteness : {"stable", "unstable", "undecided"}
        What the matrices alone prove; `stable` is the exact verdict beside it.
    reason : str
        The theorem, or what is missing for one.
    stable : bool
        As `definiteness`; where that is undecided, whether every eigenvalue has a negative real part beyond rounding.
    margin : float
        ``-max Re``, the decay rate of the slowest motion, 1/time.
    eigenvalues : ndarray of complex, shape (n_x,)
        Of the state matrix, largest real part first.
    state_matrix : ndarray, shape (n_x, n_x)
    names : tuple of str
        Names of the states.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> found = sf.stability(belt)
    >>> found.stable, round(found.margin, 6)
    (False, -0.139)
    >>> found.eigenvalues.round(4).round(6)
    array([0.139+0.9903j, 0.139-0.9903j])
    >>> sorted(found.to_dict())[:3]
    ['B', 'K', 'M']
    >>> len(found.to_xarray().data_vars) > 0
    True
    >>> ax = found.plot()
    """

    M: np.ndarray
    B: np.ndarray
    K: np.ndarray
    definiteness: str
    reason: str
    stable: bool
    margin: float
    eigenvalues: np.ndarray = field(metadata=COMPLEX)
    state_matrix: np.ndarray
    names: tuple[str, ...]
    _told = ("M", "B", "K", *PARTS, "definiteness", "reason", "stable", "margin", "eigenvalues")

    def _labelled(self) -> Labelled:
        q = list(self.names[: len(self.M)])
        matrices = {name: (("row", "column"), getattr(self, name)) for name in ("M", "B", "K", *PARTS)}
        data = {**matrices, "eigenvalues": ("mode", self.eigenvalues)}
        attributes = {"definiteness": self.definiteness, "reason": self.reason, "margin": self.margin}
        return data, {"row": q, "column": q}, attributes

    @property
    def damping(self) -> np.ndarray:
        """Damping matrix ``(B + B^T)/2``, (n, n): dissipative if it is positive definite."""
        return np.asarray((self.B + self.B.T) / 2)

    @property
    def gyroscopic(self) -> np.ndarray:
        """Gyroscopic matrix ``(B - B^T)/2``, (n, n): does no work."""
        return np.asarray((self.B - self.B.T) / 2)

    @property
    def stiffness(self) -> np.ndarray:
        """Stiffness matrix ``(K + K^T)/2``, (n, n): forces with a potential."""
        return np.asarray((self.K + self.K.T) / 2)

    @property
    def circulatory(self) -> np.ndarray:
        """Circulatory matrix ``(K - K^T)/2``, (n, n): forces without a potential, such as friction."""
        return np.asarray((self.K - self.K.T) / 2)

    @cached_property
    def hurwitz(self) -> Hurwitz:
        """The Routh-Hurwitz criterion on the characteristic polynomial of `state_matrix`."""
        return routh_hurwitz(characteristic_coefficients(self.state_matrix))

    @property
    def statespace(self) -> Any:
        """A `control.StateSpace` from one generalised force per coordinate to the coordinates."""
        import control

        n, n_x = len(self.M), len(self.state_matrix)
        push = np.zeros((n_x, n))
        push[n : 2 * n] = np.linalg.inv(self.M)
        q = list(self.names[:n])
        return control.ss(
            self.state_matrix,
            push,
            np.eye(n, n_x),
            np.zeros((n, n)),
            states=list(self.names),
            inputs=[f"force_{name}" for name in q],
            outputs=q,
        )

    def _draw(self, ax: Axes | None) -> Axes:
        ax = axes_for(ax)
        ax.axvline(0.0, color="0.6", linewidth=0.8)
        ax.plot(self.eigenvalues.real, self.eigenvalues.imag, "x")
        ax.set_xlabel("real part")
        ax.set_ylabel("imaginary part")
        return ax

    def __repr__(self) -> str:
        word = "stable" if self.stable else "not stable"
        return f"Stability({word}, margin {self.margin:.6g}; matrices: {self.definiteness}, {self.reason})"

    def _repr_html_(self) -> str:
        return html_table("Stability", {**self.to_dict(), "eigenvalues": self.eigenvalues.astype(complex).tolist()})


@logged
@alone(SYMBOLIC)
def stability(scene: Scene) -> Stability:
    """Determine the stability of steady sliding from the definiteness of its matrices and from its eigenvalues.

    Parameters
    ----------
    scene : Scene
        Every contact slips at u = 0, and no force depends on time.

    Returns
    -------
    Stability

    Raises
    ------
    SceneError, NotFound
        As `equilibrium` does.

    Notes
    -----
    ``B = -dG/du`` and ``K = -dG/dq`` of the forces G with friction; for one mass on a belt B is
    ``2 beta + gamma2 mu'(v_b)``, Thomsen (17). Of springs with sliders (Maxwell slip, Iwan, a contact behind a spring)
    the elongations are no states while they slide: they stay at their limits as long as the slip keeps its direction.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> sf.stability(belt)
    Stability(not stable, margin -0.139; matrices: unstable, tr(M^-1 B) < 0: the eigenvalues sum to a positive number)
    """
    field = field_of(scene)
    p = field.vector(scene.parameter_values())
    numbers = scene.numbers()
    x = solve(field, p, np.array([numbers[s] for s in field.states]))
    M, B, K, matrix = linearise(field, p, x)
    judged = judge(M, B, K) if not field.n_z else ("undecided", _STATES)
    return _verdict(M, B, K, judged, matrix, tuple(s.name for s in field.states))


@alone(SYMBOLIC)
def stability_of_matrices(M: Any, B: Any, K: Any) -> Stability:
    """Determine the stability of ``M q'' + B q' + K q = 0`` from its matrices and eigenvalues.

    Parameters
    ----------
    M, B, K : array_like, shape (n, n)
        M symmetric and positive definite; B may have a gyroscopic, K a circulatory part.

    Returns
    -------
    Stability
        With states q1 ... qn, u1 ... un.

    Raises
    ------
    SceneError
        If a matrix is no such matrix.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.stability_of_matrices([[1]], [[0.1]], [[1]]).stable
    True
    """
    given = [_square(matrix, name) for matrix, name in ((M, "M"), (B, "B"), (K, "K"))]
    M, B, K = given
    n = len(M)
    if not len(B) == len(K) == n:
        raise SceneError(f"M, B and K have {n}, {len(B)} and {len(K)} rows; give matrices of one size")
    if np.max(np.abs(M - M.T)) > ROUNDING * np.max(np.abs(M)) or np.min(np.linalg.eigvalsh(M)) <= 0:
        raise SceneError("M is not symmetric and positive definite; it is the matrix of the kinetic energy")
    matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, B)]])
    names = tuple(f"{letter}{i + 1}" for letter in "qu" for i in range(n))
    return _verdict(M, B, K, judge(M, B, K), matrix, names)


def _square(matrix: Any, name: str) -> np.ndarray:
    try:
        square = np.array(matrix, dtype=float)
    except (TypeError, ValueError):
        raise SceneError(f"{name} is no matrix of numbers") from None
    if square.ndim != 2 or square.shape[0] != square.shape[1] or not square.size:
        raise SceneError(f"{name} has shape {square.shape}; give a square matrix")
    if not np.all(np.isfinite(square)):
        raise SceneError(f"{name} has an entry that is not finite")
    return square


def _verdict(
    M: np.ndarray, B: np.ndarray, K: np.ndarray, judged: tuple[str, str], matrix: np.ndarray, names: tuple[str, ...]
) -> Stability:
    """Return the result of the definiteness criteria together with that of the eigenvalues."""
    definiteness, reason = judged
    eigenvalues = _eigenvalues(matrix)
    growth = float(eigenvalues[0].real)
    beyond = 1e-13 * float(np.max(np.abs(eigenvalues)))
    stable = definiteness == "stable" if definiteness != "undecided" else growth < -beyond
    return Stability(M, B, K, definiteness, reason, stable, -growth, eigenvalues, matrix, names)


def _eigenvalues(matrix: np.ndarray) -> np.ndarray:
    """Return the eigenvalues, largest real part first; with more digits if their magnitudes differ widely."""
    values = np.linalg.eigvals(matrix).astype(complex)
    sizes = np.abs(values)
    if np.min(sizes) < 1e-4 * np.max(sizes):
        import mpmath

        with mpmath.workdps(40):
            exact = mpmath.eig(mpmath.matrix(matrix.tolist()), left=False, right=False)
            values = np.array([complex(v) for v in exact])
        values = np.where(np.abs(values) <= _NOTHING * np.max(np.abs(values)), 0.0, values)
    return values[np.lexsort((-values.imag, -values.real))]


def linearise(field: Field, p: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return M, B, K, each (n, n), and the state matrix (n_x, n_x) about the steady sliding x."""
    n, n_x = field.n, len(field.states)
    s = field.directions(x, p)
    mass, slopes = field.mass(x, p, s), field.jacobian(x, p, s)
    _check_sides(field, p, x, s, slopes)
    matrix = np.zeros((n_x, n_x))
    matrix[:n, n : 2 * n] = np.eye(n)
    matrix[n : 2 * n] = np.linalg.solve(mass, slopes[:n])
    matrix[2 * n :] = slopes[n:]
    return mass, 0.0 - slopes[:n, n : 2 * n], 0.0 - slopes[:n, :n], matrix


def _check_sides(field: Field, p: np.ndarray, x: np.ndarray, s: np.ndarray, slopes: np.ndarray) -> None:
    """Raise if a contact rests where its law has one slope for slip forward and another one backward."""
    still = field.slip(x, p, s) == 0.0
    for k in np.flatnonzero(still):
        other = s.copy()
        other[k] = -s[k]
        if np.max(np.abs(field.jacobian(x, p, other) - slopes)) > ROUNDING * np.max(np.abs(slopes)):
            raise SceneError(
                f"contact {field.contacts[k].name!r} rests with bent bristles, and yields one way more than the other: "
                "no linearisation holds; start the scene where friction carries no load at rest, or let the contact "
                "slip (a belt that moves)"
            )


_STATES = "first-order states stand beside the coordinates, and the theorems speak of M, B and K alone"


def judge(M: np.ndarray, B: np.ndarray, K: np.ndarray) -> tuple[str, str]:
    """Apply definiteness criteria to ``M q'' + B q' + K q = 0``; return the result, and the theorem or what is missing.

    Notes
    -----
    M is symmetric and positive definite. With V = (q'^T M q' + q^T K q)/2 as Lyapunov function a symmetric positive
    K and a damping with positive symmetric part make rest asymptotically stable (Thomson, Tait and Chetaev), and a
    symmetric K with a negative eigenvalue makes it unstable under such a damping. The eigenvalues sum to
    -tr(M^-1 B), and their product is det K / det M; a wrong sign of either leaves one in the right half plane.
    """
    trace = np.trace(np.linalg.solve(M, B))
    if trace < -ROUNDING * np.sum(np.abs(np.linalg.solve(M, B))):
        return "unstable", "tr(M^-1 B) < 0: the eigenvalues sum to a positive number"
    scale_k = np.linalg.norm(K)
    if _nonsingular(K) and np.linalg.det(K / scale_k) < 0:
        return "unstable", "det K < 0: an eigenvalue is real and positive"
    skew = np.linalg.norm(K - K.T) / 2
    if skew > ROUNDING * scale_k:
        share = skew / scale_k
        return "undecided", f"K has a circulatory (skew-symmetric) part, {share:.2g} of its norm, that can feed motion"
    damping, stiffness = np.linalg.eigvalsh((B + B.T) / 2), np.linalg.eigvalsh((K + K.T) / 2)
    edge_b, edge_k = ROUNDING * np.linalg.norm(B), ROUNDING * scale_k
    damped = damping[0] > edge_b
    if damped and stiffness[0] > edge_k:
        return "stable", "K is symmetric and positive definite, and so is the symmetric part of B"
    if damped and stiffness[0] < -edge_k and _nonsingular(K):
        return "unstable", "K is symmetric with a negative eigenvalue, and the symmetric part of B is positive definite"
    if stiffness[0] <= edge_k:
        return "undecided", f"K is not positive definite (smallest eigenvalue {stiffness[0]:.3g})"
    if damping[0] >= -edge_b:
        return "undecided", "the symmetric part of B is only positive semidefinite: some motion may be undamped"
    return "undecided", f"the symmetric part of B is indefinite ({damping[0]:.3g} to {damping[-1]:.3g})"


def _nonsingular(K: np.ndarray) -> bool:
    values = np.linalg.svd(K, compute_uv=False)
    return bool(values[-1] > ROUNDING * values[0] * len(K) and values[0] > 0)
