"""Eigenvalues of steady sliding against a parameter, and a damper as the gain of a feedback loop."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from symfric.axes import Axes, axes_for
from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import items
from symfric.model.results import COMPLEX, ArrayResult, Drawable, Labelled
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, finite
from symfric.theory.equilibrium import solve
from symfric.theory.sliding import field_of
from symfric.theory.stability import linearise

ROUNDING = 1e-10  # rounding error of a change of the state matrix, relative to the change


@dataclass(frozen=True, eq=False, repr=False)
class RootLocus(ArrayResult, Drawable):
    """Eigenvalues of steady sliding along a parameter.

    `plot` draws the eigenvalues in the complex plane, a circle at the first value.

    Attributes
    ----------
    parameter : str
    values : ndarray, shape (n,)
    poles : ndarray of complex, shape (n_x, n)
        Each row holds one eigenvalue along the parameter.

    Examples
    --------
    >>> import symfric as sf
    >>> slides = sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=1, fs1=7.8)
    >>> locus = sf.theory.root_locus(slides, "s2", [0, 0.5, 1])
    >>> sorted(locus.to_dict())
    ['parameter', 'poles', 'values']
    >>> len(locus.to_xarray().data_vars) > 0
    True
    >>> ax = locus.plot()
    """

    parameter: str
    values: np.ndarray
    poles: np.ndarray = field(metadata=COMPLEX)

    def _labelled(self) -> Labelled:
        return {"poles": (("mode", self.parameter), self.poles)}, {self.parameter: self.values}, {}

    @property
    def stable(self) -> np.ndarray:
        """Whether every eigenvalue has a negative real part, shape (n,)."""
        return np.asarray(np.max(self.poles.real, axis=0) < 0)

    def __repr__(self) -> str:
        ends = f"{self.values[0]:g} to {self.values[-1]:g}"
        return f"RootLocus({self.parameter} {ends}: {len(self.poles)} poles, stable at {np.sum(self.stable)} values)"

    def _draw(self, ax: Axes | None) -> Axes:
        ax = axes_for(ax)
        ax.axvline(0.0, color="0.6", linewidth=0.8)
        for row in self.poles:
            (line,) = ax.plot(row.real, row.imag)
            ax.plot(row[0].real, row[0].imag, "o", color=line.get_color(), fillstyle="none")
        ax.set_xlabel("real part")
        ax.set_ylabel("imaginary part")
        return ax


@alone(SYMBOLIC)
def root_locus(scene: Scene, parameter: Key, values: Sequence[float]) -> RootLocus:
    """Compute the eigenvalues of steady sliding along a parameter, for example a damping.

    Parameters
    ----------
    scene : Scene
        As `stability` takes it.
    parameter : Symbol or str
        The value to vary; the one stored in the scene is ignored.
    values : sequence of float
        Close enough for eigenvalues to be told apart from one to the next.

    Returns
    -------
    RootLocus

    Raises
    ------
    SceneError, NotFound
        As `equilibrium` does.

    Examples
    --------
    >>> import symfric as sf
    >>> slides = sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=1, fs1=7.8)
    >>> sf.theory.root_locus(slides, "s2", [0, 0.5, 1]).poles.shape
    (4, 3)
    """
    from scipy.optimize import linear_sum_assignment

    check_scene(scene)
    symbol = scene.parameter(parameter)
    grid = np.array([finite(v, f"a value of {symbol.name}") for v in items(values, "values")])
    if not grid.size:
        raise SceneError(f"no values of {symbol.name} to follow the eigenvalues along")
    rows: list[np.ndarray] = []
    for matrix in _state_matrices(scene, symbol, grid.tolist()):
        poles = np.linalg.eigvals(matrix).astype(complex)
        poles = poles[np.lexsort((-poles.imag, -poles.real))]
        if rows:
            ahead = rows[-1] if len(rows) < 2 else 2 * rows[-1] - rows[-2]
            poles = poles[linear_sum_assignment(np.abs(ahead[:, None] - poles[None, :]))[1]]
        rows.append(poles)
    return RootLocus(symbol.name, grid, np.array(rows).T)


@alone(SYMBOLIC)
def damper_loop(scene: Scene, parameter: Key) -> Any:
    """Return the linearised scene without a damper, as an open loop whose feedback gain is the damping.

    Parameters
    ----------
    scene : Scene
        As `stability` takes it.
    parameter : Symbol or str
        The damper; steady sliding must not depend on it, and its force be one force times one speed.

    Returns
    -------
    control.StateSpace
        One input, the damper's force, and one output, the speed it works on, with the damper at zero. Negative
        feedback with the gain k is the scene with the damper k: so `control.root_locus_map` and `control.rlocus` draw
        its root locus, and the margins of the loop are those of the damper.

    Raises
    ------
    SceneError
        If the parameter enters otherwise.

    Examples
    --------
    >>> import symfric as sf
    >>> slides = sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=1, fs1=7.8)
    >>> loop = sf.theory.damper_loop(slides, "s2")
    >>> loop.nstates
    4
    """
    import control

    check_scene(scene)
    symbol = scene.parameter(parameter)
    here = scene.values[symbol] or 0.0
    matrix, one, two = _state_matrices(scene, symbol, (here, here + 1, here + 2))
    change = matrix - one
    _, sizes, right = np.linalg.svd(change)
    linear = np.max(np.abs(matrix - two - 2 * change)) <= ROUNDING * np.max(np.abs(change))
    if sizes[0] == 0 or not linear or (len(sizes) > 1 and sizes[1] > ROUNDING * sizes[0]):
        raise SceneError(
            f"{symbol.name} is no damper: the state matrix does not change by a multiple of one force times one speed"
        )
    names = [s.name for s in scene.system.states]
    speed = right[0] / right[0][np.argmax(np.abs(right[0]))]
    push = change @ speed / (speed @ speed)
    output, force = f"speed_of_{symbol.name}", f"force_of_{symbol.name}"
    none = matrix + here * change
    none[np.abs(none) < 1e-14 * np.max(np.abs(matrix))] = 0.0
    return control.ss(none, push[:, None], speed[None, :], 0.0, states=names, inputs=[force], outputs=[output])


def _state_matrices(scene: Scene, symbol: sp.Symbol, values: Sequence[float]) -> list[np.ndarray]:
    """Return the state matrix of steady sliding at each value of a parameter."""
    field = field_of(scene, vary=(symbol,))
    some = scene.where({symbol: 1.0})
    numbers, others = some.numbers(), some.parameter_values()
    x = np.array([numbers[s] for s in field.states])
    matrices = []
    for value in values:
        p = field.vector({**others, symbol: value})
        x = solve(field, p, x)
        matrices.append(linearise(field, p, x)[3])
    return matrices
