"""Steady sliding: equilibria at which every contact slips."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.laws import Law
from symfric.model.numeric import numeric_function
from symfric.model.results import BY_NAME, ArrayResult, Labelled
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.model.system import Contact
from symfric.model.validation import negative_load
from symfric.theory.sliding import Field, field_of
from symfric.theory.springs_with_sliders import check_held, springs_of

STARTS = 12  # number of random starts after the scene's own and zero
_SEED = 31
_ROUNDING = 1e-15  # rounding error of a slip relative to its terms
_LADDER = np.logspace(-40, 40, 161)  # speeds covering any unit, at which a law is checked to vanish smoothly at zero


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(ArrayResult):
    """Steady sliding of a scene.

    Attributes
    ----------
    x : ndarray, shape (n_x,)
        The state ``[q; u; z]``, with u = 0.
    sliding : dict of str to float
        Slip velocity of each contact, by its name.
    names : tuple of str
        Names of the states.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> found = sf.equilibrium(belt)
    >>> found.sliding
    {'belt': -0.2}
    >>> sorted(found.to_dict())
    ['sliding', 'x']
    >>> list(found.to_xarray().data_vars)
    ['x', 'sliding']
    """

    x: np.ndarray = field(metadata=BY_NAME)
    sliding: dict[str, float]
    names: tuple[str, ...]
    _told = ("x", "sliding")

    def _labelled(self) -> Labelled:
        data = {"x": ("state", self.x), "sliding": ("contact", list(self.sliding.values()))}
        return data, {"state": list(self.names), "contact": list(self.sliding)}, {}

    def __repr__(self) -> str:
        states = ", ".join(f"{k}={v:.6g}" for k, v in zip(self.names, self.x, strict=True))
        slips = ", ".join(f"{k} {v:.6g}" for k, v in self.sliding.items()) or "no contacts"
        return f"Equilibrium({states}; sliding: {slips})"


@alone(SYMBOLIC)
def equilibrium(scene: Scene) -> Equilibrium:
    """Find steady sliding: u = 0 with every contact slipping.

    Parameters
    ----------
    scene : Scene
        Any number of coordinates, contacts and first-order states; forces may have kinks, but not depend on time.

    Returns
    -------
    Equilibrium
        The one found from the scene's start; other starts are tried only where that search fails.

    Raises
    ------
    SceneError
        If the forces depend on time, or a contact does not slip while u = 0.
    NotFound
        If no position balances the forces, or only some at which a normal load is negative.

    Notes
    -----
    Solves ``force - J^T sign(w) N mu(|w|) = 0`` and ``z_rate = 0`` at u = 0; for one mass on a belt it is Thomsen (7).
    A contact whose law has no jump may also rest. Springs with sliders (Maxwell slip, Iwan, a contact behind a spring)
    stand at their limits while they slide, ``z = sign(w) limit``; at rest their sliders stick.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> sf.equilibrium(belt).x.round(6)
    array([0.3148, 0.    ])
    """
    field = field_of(scene)
    p = field.vector(scene.parameter_values())
    numbers = scene.numbers()
    x = solve(field, p, np.array([numbers[s] for s in field.states]))
    speeds = slips(field, p, x)
    states = dict(zip(field.states, x.tolist(), strict=True)) | _stretched(scene, speeds, field, p, x)
    sliding = {c.name: speeds.get(c.name, 0.0) for c in scene.contacts}
    names = tuple(s.name for s in scene.system.states)
    return Equilibrium(np.array([states[s] for s in scene.system.states]), sliding, names)


def _stretched(
    scene: Scene, sliding: Mapping[str, float], field: Field, p: np.ndarray, x: np.ndarray
) -> dict[sp.Symbol, float]:
    """Return the elongations of springs whose sliders move: at their limits, in the direction of the slip."""
    values = dict(zip((*field.states, *field.parameters), (*x, *p), strict=True))
    return {
        spring.state: float(np.sign(sliding[spring.contact])) * float(spring.limit.subs(values))
        for contact in scene.contacts_behind_springs
        for spring in springs_of(contact)
        if spring.contact in sliding
    }


def slips(field: Field, p: np.ndarray, x: np.ndarray) -> dict[str, float]:
    """Return the slip velocity of each contact by name, in the plane the speed."""
    return {c.name: w for c, w in zip(field.contacts, field.speeds(x, p), strict=True)}


def solve(field: Field, p: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return the state of steady sliding, shape (n_x,), by Newton's method from several starts.

    Parameters
    ----------
    field : Field
    p : ndarray
        Parameters, as `Field.vector` returns them.
    start : ndarray, shape (n_x,)
        First start; its velocities are ignored.
    """
    n, n_x = field.n, len(field.states)
    free = np.r_[0:n, 2 * n : n_x]
    origin = np.array(start, dtype=float)
    origin[n : 2 * n] = 0.0
    _check_slipping(field, p, origin)
    rng = np.random.default_rng(_SEED)
    sizes = _sizes(field, p, origin, free)
    starts = [origin, np.zeros(n_x)]
    starts += [origin + _scatter(rng, sizes * 3.0 ** (k - STARTS // 2), free, n_x) for k in range(STARTS)]
    lost = ""
    for guess in starts:
        x = _newton(field, p, guess, free, sizes)
        if x is None:
            continue
        _check_slipping(field, p, x)
        values = _values(field, p, x)
        if field.held:
            check_held(field.held, values)
        loads = [(load, c.name) for c in field.contacts if (load := negative_load(c, values)) is not None]
        if not loads:
            return x
        lost = lost or "where the forces balance, the normal load of contact {1!r} is {0:.6g}".format(*loads[0])
    if lost:
        raise NotFound(f"no steady sliding: {lost}, and it has let go")
    residual = field.value(origin, p, field.directions(origin, p))
    names = [s.name for s in (*field.system.u, *field.system.z)]
    worst = int(np.argmax(np.abs(residual))) if np.all(np.isfinite(residual)) else 0
    raise NotFound(
        f"no steady sliding: no position balances the forces (largest unbalance at the start: {names[worst]}' = "
        f"{residual[worst]:.6g}); a coordinate without a spring has none"
    )


def _sizes(field: Field, p: np.ndarray, origin: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return sizes of the coordinates and further states, from the start and the first Newton step."""
    with np.errstate(all="ignore"):
        signs = field.directions(origin, p)
        slopes, value = np.abs(field.jacobian(origin, p, signs)[:, free]), np.abs(field.value(origin, p, signs))
        steps = value[:, None] / slopes
    steps = np.min(np.where(steps > 0, steps, np.inf), axis=0, initial=np.inf)
    sizes = np.maximum(np.abs(origin[free]), np.where(np.isfinite(steps), steps, 0.0))
    for kind in (slice(0, field.n), slice(field.n, None)):
        sizes[kind] = np.max(sizes[kind], initial=0.0) or 1.0
    return np.asarray(sizes)


def _scatter(rng: np.random.Generator, size: np.ndarray, free: np.ndarray, n_x: int) -> np.ndarray:
    step = np.zeros(n_x)
    step[free] = size * rng.standard_normal(len(free))
    return step


def _newton(field: Field, p: np.ndarray, guess: np.ndarray, free: np.ndarray, sizes: np.ndarray) -> np.ndarray | None:
    """Run SciPy's hybrid method, then plain Newton steps down to rounding; None if the residual stays.

    Unknowns are scaled by their sizes, and the equations by the changes that these cause.
    """
    from scipy import optimize

    def place(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x = np.zeros(len(field.states))
        x[free] = y * sizes
        return x, field.directions(x, p)

    def value(y: np.ndarray) -> np.ndarray:
        x, s = place(y)
        return field.value(x, p, s) / rows

    def slope(y: np.ndarray) -> np.ndarray:
        x, s = place(y)
        return np.asarray(field.jacobian(x, p, s)[:, free] * sizes / rows[:, None])

    y, rows = guess[free] / sizes, np.ones(len(free))
    changed = np.sum(np.abs(slope(y)), axis=1)
    rows = np.where(np.isfinite(changed) & (changed > 0), changed, 1.0)
    if not np.all(np.isfinite(value(y))):
        return None
    with np.errstate(all="ignore"):
        y = optimize.root(value, y, jac=slope, method="hybr", options={"xtol": 1e-13}).x
        for _ in range(4):
            g, a = value(y), slope(y)
            if not (np.all(np.isfinite(g)) and np.all(np.isfinite(a))):
                return None
            better = y - np.linalg.lstsq(a, g, rcond=None)[0]
            if not np.sum(np.abs(value(better))) < np.sum(np.abs(g)):
                break
            y = better
        g, a = value(y), slope(y)
        scale = np.abs(a) @ np.abs(y) + np.abs(value(np.zeros_like(y)))
    if np.all(np.isfinite(g)) and np.all(np.abs(g) <= 1e-10 * scale + 1e-290):
        return place(y)[0]
    return None


def _values(field: Field, p: np.ndarray, x: np.ndarray) -> dict[sp.Symbol, float]:
    """Return the numbers of all symbols at a state."""
    values = dict(zip((*field.states, *field.parameters), (*x, *p), strict=True))
    if field.system.linear is not None:
        values |= field.system.linear.values(x[: field.n], x[field.n : 2 * field.n])
    return values


def _check_slipping(field: Field, p: np.ndarray, x: np.ndarray) -> None:
    """Raise if a contact whose law jumps at rest has no slip."""
    values = _values(field, p, x)
    for contact, w in zip(field.contacts, field.speeds(x, p), strict=True):
        if w != 0 and abs(w) > _ROUNDING * _terms(contact, values):
            continue
        if not rests_smoothly(contact.law, values):
            raise SceneError(
                f"contact {contact.name!r} does not slip while u = 0 (its slip is {contact.slip}); "
                "steady sliding needs a relative velocity, such as a belt's, or a regularised law"
            )


def _terms(contact: Contact, values: Mapping[sp.Symbol, float]) -> float:
    """Return the sum of the magnitudes of the terms of a slip, the scale of its rounding error."""
    parts = (term for slip in contact.slips for term in sp.Add.make_args(sp.expand(slip)))
    terms = sum(map(sp.Abs, parts), sp.Integer(0))
    symbols = tuple(sorted(terms.free_symbols, key=str))
    return float(numeric_function(symbols, terms)(*(values[s] for s in symbols)))


def rests_smoothly(law: Law, values: Mapping[sp.Symbol, float]) -> bool:
    """Whether the friction passes through zero slip without a jump."""
    if law.memory and law.memory.slowest is not None:
        return False  # its contacts age at rest without end, or have no force at all
    if law.smooth:
        return True
    symbols = tuple(sorted(law.free_symbols, key=str))
    numbers = [values[s] for s in symbols]
    if float(numeric_function(symbols, law.stick)(*numbers)) != 0:
        return False
    with np.errstate(all="ignore"):
        friction = np.abs(numeric_function((SPEED, *symbols), law.kinetic)(_LADDER, *numbers))
    return bool(friction[0] <= 1e-6 * np.max(friction[np.isfinite(friction)], initial=0.0))
