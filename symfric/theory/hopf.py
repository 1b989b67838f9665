"""Hopf points of steady sliding, and whether they are supercritical or subcritical."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.results import Result
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, finite, pair
from symfric.search import ROUNDING, zero
from symfric.theory.equilibrium import solve
from symfric.theory.sliding import Field, field_of
from symfric.theory.stability import linearise

_HALVINGS = 50  # of a bracket within which an equilibrium ends
_BEYOND = 1e-4  # distance beyond, relative to the bracket, at which the equilibrium is sought once more
_SMALL = 0.05  # eigenvalue of the last equilibrium found before a fold, relative to the largest
_ASIDE = 1e-9  # distance from a crossing, relative to the bracket, at which a jump of the growth rate is looked for
_JUMP = 1e-3  # change of the growth rate over it, relative to the largest eigenvalue, that is a jump
_REAL = 1e-6  # imaginary part of the crossing eigenvalue, relative to the largest, below which it counts as real
_TOGETHER = 1e-9  # growth rate, relative to the largest eigenvalue, above which a further pair crosses as well
_ELSEWHERE = 0.1  # distance of two equilibria, relative to their size, that are not the same one moved a little
_ABSENT = 1e-10  # share of the first coordinate in the oscillation, by energy, that is rounding
DEGENERATE = 1e-9  # cubic coefficient relative to the sum of its terms' magnitudes that counts as zero
NEUTRAL = 1e-12  # growth rate relative to the largest eigenvalue that counts as zero
# distances from a zero of the growth rate, relative to the bracket, at which its sign is read
SIDES = (1e-6, 1e-4, 1e-2)
_SURVEY = 32  # places at which a growth rate of one sign at both ends is looked at between them
Leading: TypeAlias = Callable[..., tuple[complex, float, np.ndarray, np.ndarray]]


@dataclass(frozen=True, repr=False)
class HopfPoint(Result):
    """A Hopf point: a pair of eigenvalues on the imaginary axis.

    Attributes
    ----------
    value : float
        Of the parameter.
    omega : float
        Frequency of the oscillation that starts there, rad/time.
    first_lyapunov : float
        Coefficient a of ``r' = sigma r + a r^3``, r the amplitude of the first coordinate; 1/(time length^2).
    kind : {"supercritical", "subcritical", "degenerate"}
        Small stable cycles on the unstable side, small unstable ones on the stable side, or undecided: the cubic
        coefficient vanishes, or several pairs cross together.
    parameter : str

    Examples
    --------
    >>> import symfric as sf
    >>> point = sf.hopf(sf.scenes.mass_on_belt(v_b=0.2), "v_b", (0.3, 0.6))
    >>> round(point.omega, 6)
    1.0
    >>> sorted(point.to_dict())[:2]
    ['first_lyapunov', 'kind']
    """

    value: float
    omega: float
    first_lyapunov: float
    kind: Literal["supercritical", "subcritical", "degenerate"]
    parameter: str
    _told = ("parameter", "value", "omega", "first_lyapunov", "kind")

    def __repr__(self) -> str:
        return (
            f"HopfPoint({self.parameter}={self.value:.15g}, omega={self.omega:.6g}, {self.kind}, "
            f"first_lyapunov={self.first_lyapunov:.6g})"
        )


@logged
@alone(SYMBOLIC)
def hopf(scene: Scene, parameter: Key, bracket: tuple[float, float]) -> HopfPoint:
    """Find where steady sliding starts to oscillate.

    Parameters
    ----------
    scene : Scene
        Every contact slips at the equilibrium, and no force depends on time.
    parameter : Symbol or str
        The value to vary; the one stored in the scene is ignored.
    bracket : (float, float)
        Ends of the search interval; steady sliding is stable at one and unstable at the other. The point may be an end;
        of several points in the bracket one is found.

    Returns
    -------
    HopfPoint

    Raises
    ------
    NotFound
        If the growth rate keeps its sign on the bracket, is zero on a part of it (a neutral system), touches zero
        without a change of sign, jumps, or a real eigenvalue crosses instead of a pair: at a branch point of the
        equilibria, where steady sliding goes on, or at a fold, where it ends.
    SceneError
        As `equilibrium` does, or if the bracket is empty.

    Notes
    -----
    Solves ``max Re eig J = 0`` with ``J = d rhs / d x``, shape (n_x, n_x). For one mass on a belt the answer is closed:
    Thomsen (19). The cubic coefficient is that of the normal form on the centre manifold (Kuznetsov, Elements of
    Applied Bifurcation Theory, section 5.4, the projection method), with the amplitude of the first coordinate as r.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> point = sf.hopf(belt, "v_b", bracket=(0.3, 0.6))
    >>> round(point.value, 6)
    0.440959
    >>> point.kind
    'supercritical'
    """
    check_scene(scene)
    symbol = scene.parameter(parameter)
    low, high = (finite(v, f"an end of the bracket of {symbol.name}") for v in pair(bracket, "bracket"))
    if not low < high:
        raise SceneError(f"the bracket of {symbol.name} is ({low:g}, {high:g}); give (low, high) with low < high")
    field, leading = _tracker(scene, symbol, low, high)
    value = _crossing(leading, symbol.name, low, high)
    step = _ASIDE * (high - low)
    (before, size_1, *_), (after, size_2, *_) = (leading(float(np.clip(value + d, low, high))) for d in (-step, step))
    eigenvalue, size, x, p = leading(value)
    _check_sides(leading, symbol.name, value, (low, high))
    if abs(after.real - before.real) > _JUMP * min(size_1, size_2):
        raise NotFound(
            f"the growth rate jumps at {symbol.name} = {value:.12g}, from {before.real:.3g} to {after.real:.3g}: "
            "a law or a force has a kink there, or another equilibrium takes over"
        )
    if abs(eigenvalue.imag) < _REAL * size:
        raise NotFound(
            f"a real eigenvalue crosses zero at {symbol.name} = {value:.12g}: a branch point, where another "
            "equilibrium crosses and steady sliding is lost without oscillation; this is no Hopf point"
        )
    a, terms = cubic_coefficient(field, p, x)
    together = np.sum(np.linalg.eigvals(linearise(field, p, x)[3]).real > -_TOGETHER * size) > 2
    flat = together or abs(a) <= DEGENERATE * terms
    kind: Literal["supercritical", "subcritical", "degenerate"]
    kind = "degenerate" if flat else ("supercritical" if a < 0 else "subcritical")
    return HopfPoint(value, abs(eigenvalue.imag), a, kind, symbol.name)


def _tracker(scene: Scene, symbol: sp.Symbol, low: float, high: float) -> tuple[Field, Leading]:
    """Return the sliding equations and a function from a parameter value to the leading eigenvalue."""
    ends = [scene.where({symbol: v}) for v in (low, high)]
    field = field_of(ends[1 if low == 0 else 0], vary=(symbol,))
    numbers, others = ends[0].numbers(), ends[0].parameter_values()
    last = [np.array([numbers[s] for s in field.states])]

    def leading(value: float, start: np.ndarray | None = None) -> tuple[complex, float, np.ndarray, np.ndarray]:
        p = field.vector({**others, symbol: value})
        x = solve(field, p, last[0] if start is None else start)
        last[0] = x
        eigenvalues = np.linalg.eigvals(linearise(field, p, x)[3])
        k = int(np.argmax(eigenvalues.real))
        return complex(eigenvalues[k]), float(np.max(np.abs(eigenvalues))), x, p

    return field, leading


def _crossing(leading: Callable[..., Any], name: str, low: float, high: float) -> float:
    """Return the parameter value at which the growth rate changes its sign, to rounding."""

    def growth(value: float) -> float:
        return float(leading(value)[0].real)

    first = leading(low)
    at_low, begins = first[0].real * _sign(first) ** 2, first[2]
    at_high = growth(high) * _sign(leading(high)) ** 2
    if at_low * at_high > 0:
        word = "unstable" if at_low > 0 else "stable"
        between = [v for v in np.linspace(low, high, _SURVEY + 2)[1:-1].tolist() if at_low * _sign(leading(v)) < 0]
        cure = "widen or move the bracket"
        if between:
            cure = f"between them, at {between[0]:g}, it is not: end the bracket there"
        raise NotFound(
            f"steady sliding is {word} at both ends of the bracket of {name}: the growth rate is {at_low:.6g} at "
            f"{low:g} and {at_high:.6g} at {high:g}; {cure}"
        )
    if at_low == 0 or at_high == 0:
        return low if at_low == 0 else high
    if growth(low) * at_low < 0:  # another equilibrium, found from the one at the other end
        return _followed(leading, name, (low, high), at_low, begins)
    return zero(growth, low, high, rtol=ROUNDING, most=300)


def _sign(leading: tuple[Any, ...]) -> int:
    """Return the sign of the growth rate, 0 if it is zero to rounding."""
    eigenvalue, size, *_ = leading
    return 0 if abs(eigenvalue.real) <= NEUTRAL * size else (1 if eigenvalue.real > 0 else -1)


def _check_sides(leading: Callable[..., Any], name: str, value: float, ends: tuple[float, float]) -> None:
    """Raise unless the growth rate changes its sign at a zero; beside an end of the bracket, as far as it exists."""
    low, high = ends
    for share in SIDES:
        before, after = (_side(leading, value + way * share * (high - low), ends) for way in (-1, 1))
        if before is None or after is None:
            if before or after:
                return
        elif before * after < 0:
            return
        elif before and after:
            raise NotFound(
                f"the growth rate touches zero at {name} = {value:.12g} and is "
                f"{'positive' if after > 0 else 'negative'} on both sides; no oscillation starts there"
            )
    raise NotFound(
        f"the growth rate is zero beside {name} = {value:.12g} too: steady sliding is neutral there, since an "
        "eigenvalue stays on the imaginary axis, and no pair crosses it; add damping, or fix a coordinate that nothing "
        "holds"
    )


def _side(leading: Callable[..., Any], value: float, ends: tuple[float, float]) -> int | None:
    """Return the sign of the growth rate; None if there is no steady sliding at a value outside the bracket."""
    try:
        return _sign(leading(value))
    except (SceneError, NotFound):
        if ends[0] <= value <= ends[1]:
            raise
        return None


def _followed(
    leading: Callable[..., Any], name: str, bracket: tuple[float, float], at_low: float, x: np.ndarray
) -> float:
    """Return where the growth rate of the equilibrium x at the lower end changes its sign; raise if it ends before."""
    low, high = bracket
    eigenvalue, size, *_ = leading(low, x)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        growth, scale, there, _ = leading(middle, x)
        if growth.real * at_low > 0:
            low, x, eigenvalue, size = middle, there, growth, scale
        else:
            high = middle
    beyond = leading(min(high + _BEYOND * (bracket[1] - bracket[0]), bracket[1]), x)[2]
    ends = np.linalg.norm(beyond - x) > _ELSEWHERE * max(np.linalg.norm(beyond), np.linalg.norm(x))
    if ends and eigenvalue.imag == 0 and abs(eigenvalue) < _SMALL * size:
        raise NotFound(
            f"steady sliding ends at a fold at {name} = {high:.9g}, where a real eigenvalue reaches zero and beyond "
            "which another equilibrium takes over; this is no Hopf point"
        )
    leading(low, x)  # from here on the eigenvalues are those of this equilibrium
    return low


def cubic_coefficient(field: Field, p: np.ndarray, x: np.ndarray) -> tuple[float, float]:
    """Return the coefficient a of ``r' = a r^3`` at a Hopf point, and the sum of the magnitudes of its terms.

    Notes
    -----
    On the centre manifold ``x = z q + conj(z q) + ...`` obeys ``z' = i omega z + c z |z|^2`` with
    ``c = <p, C(q, q, q*) + B(q*, (2 i omega - A)^-1 B(q, q)) - 2 B(q, A^-1 B(q, q*))>/2``; the amplitude of the first
    coordinate is ``r = 2 |z| |q_1|``, so that ``a = Re c/(4 |q_1|^2)``.
    """
    n_x = len(field.states)
    M, _, _, A = linearise(field, p, x)
    B, C = multilinear(field, p, x, M, A)
    values, right = np.linalg.eig(A)
    # of the leading pair the eigenvalue with the positive imaginary part, which rounding of the real parts may hide
    k = int(np.argmax(values.real + (values.imag > 0) * 1e-6 * np.max(np.abs(values))))
    omega, q = abs(values[k].imag), right[:, k] if values[k].imag > 0 else right[:, k].conj()
    duals, left = np.linalg.eig(A.T)
    w = left[:, int(np.argmin(np.abs(duals + 1j * omega)))]
    w = w / np.conj(np.vdot(w, q))
    weighed = np.sqrt(np.abs(np.diag(M))) * np.abs(q[: len(M)])  # energies compare coordinates of different units
    if weighed[0] < _ABSENT * np.linalg.norm(weighed):
        raise NotFound(
            f"coordinate {field.states[0].name} takes no part in the oscillation; first_lyapunov measures its "
            "amplitude, so write one that does as the first coordinate"
        )
    bent = np.linalg.solve(2j * omega * np.eye(n_x) - A, B(q, q))
    shift = np.linalg.solve(A, B(q, q.conj()))
    terms = [
        np.vdot(w, t).real / (8 * abs(q[0]) ** 2) for t in (C(q, q, q.conj()), B(q.conj(), bent), -2 * B(q, shift))
    ]
    return float(sum(terms)), float(sum(abs(t) for t in terms))


def multilinear(
    field: Field, p: np.ndarray, x: np.ndarray, M: np.ndarray, A: np.ndarray
) -> tuple[Callable[..., np.ndarray], Callable[..., np.ndarray]]:
    """Return the second and third derivatives of the state's rate as symmetric multilinear functions.

    Notes
    -----
    From ``M(q) a(x) = G(x)`` differentiated two and three times at a = 0.
    """
    n, n_x = field.n, len(field.states)
    G2, G3, M1, M2 = field.curvature(x, p, field.directions(x, p))
    rows = slice(n, 2 * n)

    def place(accelerations: np.ndarray, rates: np.ndarray) -> np.ndarray:
        result = np.zeros(n_x, dtype=complex)
        result[rows] = np.linalg.solve(M, accelerations)
        result[2 * n :] = rates
        return result

    def B(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        g = G2 @ v @ u
        bend = (M1 @ u) @ (A[rows] @ v) + (M1 @ v) @ (A[rows] @ u)
        return place(g[:n] - bend, g[n:])

    def C(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> np.ndarray:
        g = G3 @ w @ v @ u
        bend = np.zeros(n, dtype=complex)
        for one, two, three in ((u, v, w), (v, w, u), (w, u, v)):
            bend += (M1 @ one) @ B(two, three)[rows] + (M2 @ two @ one) @ (A[rows] @ three)
        return place(g[:n] - bend, g[n:])

    return B, C
