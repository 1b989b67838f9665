"""Random scenes for the stress run: structures of one to five masses and contacts, and awkward numbers for each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.numeric import numeric
from symfric.model.outputs import Trajectory
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, System

HORIZON = 4.0  # horizon of every scene, some radians of its vibrations
SIZES = (0.3, 0.25, 0.2, 0.15, 0.1)  # probabilities of one to five masses, and of one to five contacts
COUPLING = 0.2  # coupling relative to the smaller of two masses, so that the mass matrix is positive definite

# laws by name, from mu, the drop r >= 0 from rest to slip, a speed v and a slope b
LAWS: dict[str, Callable[[sp.Expr, sp.Expr, sp.Expr, sp.Expr], laws.Law]] = {
    "coulomb": lambda mu, r, v, b: laws.coulomb(mu),
    "coulomb with a drop": lambda mu, r, v, b: laws.coulomb(mu * (1 + r), mu),
    "piecewise linear": lambda mu, r, v, b: laws.piecewise_linear(
        mu * (1 + r), [0, v, 2 * v], [mu * (1 + r), mu, mu * (1 + r / 2)]
    ),
    "lorentz": lambda mu, r, v, b: laws.lorentz(mu, v, mu * (1 + r), b),
    "gauss": lambda mu, r, v, b: laws.gauss(mu, v, mu * (1 + r), b),
    "square root": lambda mu, r, v, b: laws.square_root(mu, -b, mu * (1 + r), b),
    "stribeck": lambda mu, r, v, b: laws.stribeck(mu * (1 + r), mu, v, b),
    "cubic": lambda mu, r, v, b: laws.cubic(mu * (1 + r), mu, v),
    "exponential": lambda mu, r, v, b: laws.exponential(mu, v),
    "custom": lambda mu, r, v, b: laws.custom(mu * (1 + r / (1 + SPEED / v) ** 3), mu * (1 + r)),
    "linear instead of a jump": lambda mu, r, v, b: laws.coulomb(mu * (1 + r), mu).regularised(v / 4),
    "arctan instead of a jump": lambda mu, r, v, b: laws.stribeck(mu * (1 + r), mu, v).regularised(v / 4, "arctan"),
    "tanh instead of a jump": lambda mu, r, v, b: laws.coulomb(mu).regularised(v / 4, "tanh"),
    "averaged": lambda mu, r, v, b: laws.cubic(mu * (1 + r), mu, v).averaged(v / 4),
}
OF_LINES = ("coulomb", "coulomb with a drop", "piecewise linear")

SPRINGS: dict[
    str, Callable[[sp.Expr, sp.Expr, sp.Expr], sp.Expr]
] = {  # nonlinear forces, from coordinate, velocity and a factor
    "cubic spring": lambda q, u, h: -h * q**3,
    "pendulum": lambda q, u, h: -h * sp.sin(q),
    "soft spring": lambda q, u, h: -h * sp.tanh(2 * q),
    "stop": lambda q, u, h: -4 * h * sp.Max(q - sp.Rational(1, 5), 0),
    "play": lambda q, u, h: -h * sp.Piecewise((q - sp.Rational(1, 4), q > 0.25), (q + 0.25, q < -0.25), (0, True)),
    "fluid": lambda q, u, h: -h * u * sp.Abs(u),
    "van der Pol": lambda q, u, h: h * u * (1 - q**2) / 4,
}


@dataclass(frozen=True)
class Draw:
    """Numbers for one run of a structure.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    values, initial : dict of str to float
    """

    kind: str
    values: dict[str, float]
    initial: dict[str, float]


def structure(seed: int) -> Scene:
    """Return equations with parameters: one to five masses on springs, one to five contacts, drawn by the seed.

    Returns
    -------
    Scene
        With moderate values, none of them zero, over `HORIZON`; every law, spring and way of contact occurs as the seed
        goes on. Two of five are linear between events.
    """
    rng = np.random.default_rng([seed, 0])
    n, n_c = (1 + int(rng.choice(5, p=SIZES)) for _ in range(2))
    straight = seed % 5 < 2
    q, u = (sp.symbols(f"{name}1:{n + 1}", real=True) for name in ("q", "u"))
    forces = [_force(rng, q, u, i, straight) for i in range(n)]
    laws = OF_LINES if straight else tuple(LAWS)
    contacts = [_contact(rng, q, u, i, laws[(seed // 5 * 3 + i) % len(laws)], straight) for i in range(n_c)]
    system = System(q=q, u=u, mass=_masses(rng, n), force=forces)
    symbols = set().union(*(e.free_symbols for e in (*system.expressions, *contacts))) - {*q, *u, TIME}
    names = sorted(s.name for s in symbols)  # sorted, since the order of a set differs between processes
    values = {name: 0.1 if name[0] in "rbe" else 0.5 for name in names}
    initial = {s.name: 0.1 for s in (*q, *u)}
    return Scene(system, contacts, values, initial, HORIZON, {"path": Trajectory()})


def _parameter(name: str) -> sp.Symbol:
    return sp.Symbol(name, positive=True)


def _masses(rng: np.random.Generator, n: int) -> sp.Matrix:
    mass = sp.diag(*(_parameter(f"m{i + 1}") for i in range(n)))
    if n > 1 and rng.random() < 0.4:
        for i in range(n - 1):
            mass[i, i + 1] = mass[i + 1, i] = sp.Symbol(f"e{i + 1}", real=True)
    return mass


def _force(rng: np.random.Generator, q: Sequence[sp.Symbol], u: Sequence[sp.Symbol], i: int, straight: bool) -> sp.Expr:
    """Return the force on mass i: a constant, springs, dampers, and perhaps a drive."""
    name = str(i + 1)
    force = sp.Symbol(f"c{name}", real=True) - _parameter(f"k{name}") * q[i] - _parameter(f"d{name}") * u[i]
    for j, shared in ((i - 1, i), (i + 1, i + 1)):  # the spring between two masses has the number of the first
        if 0 <= j < len(q):
            force -= _parameter(f"k{shared}{shared + 1}") * (q[i] - q[j])
    if not straight and rng.random() < 0.5:
        force += list(SPRINGS.values())[rng.integers(len(SPRINGS))](q[i], u[i], _parameter(f"h{name}"))
    if rng.random() < (0.1 if straight else 0.4):
        force += sp.Symbol(f"F{name}", real=True) * sp.sin(_parameter(f"Omega{name}") * TIME)
    return force


def _contact(
    rng: np.random.Generator, q: Sequence[sp.Symbol], u: Sequence[sp.Symbol], i: int, law: str, straight: bool
) -> Contact:
    name, n = str(i + 1), len(q)
    a, b = (int(k) for k in rng.permutation(n)[:2]) if n > 1 else (0, 0)
    way = rng.random()
    slip = u[a]
    if n > 1 and way < 0.35:
        slip = u[a] - u[b]
    elif n > 1 and way < 0.45:
        slip = u[a] + u[b] / 2
    if rng.random() < 0.7:
        slip -= sp.Symbol(f"v{name}", real=True)
    load, profile = _parameter(f"N{name}"), sp.Integer(1)
    if not straight and rng.random() < 0.2:
        load *= 1 + sp.sin(q[a]) / 4
    if not straight and rng.random() < 0.15:
        load *= 1 + sp.cos(3 * TIME) / 2
    if not straight and rng.random() < 0.15:
        profile += sp.cos(2 * q[a]) / 5
    numbers = [_parameter(f"{p}{name}") for p in ("mu", "r", "w", "b")]
    return Contact(f"contact{name}", slip, load, LAWS[law](*numbers), profile)


class Dice:
    """Generator of the numbers of a structure, with compiled equations for starts on a switching surface."""

    def __init__(self, scene: Scene):
        self.names = tuple(sorted(s.name for s in scene.parameters))
        self.states = tuple(s.name for s in scene.system.states)
        system, contacts = scene.system, scene.contacts
        slips = sp.Matrix([c.slip for c in contacts])
        self._n, self._n_c = len(system.q), len(contacts)
        bounds = [c.normal * c.profile * c.law.stick for c in contacts]
        entries = [*slips, *slips.jacobian(system.u), *bounds, *system.force]
        symbols = sorted(scene.parameters, key=str)
        self._at = numeric((*system.states, *symbols), [sp.sympify(e).subs(TIME, 0) for e in entries])

    def draw(self, seed: int, number: int) -> Draw:
        """Return the numbers of one run; the same for the same seed of the structure and number of the run."""
        rng = np.random.default_rng([seed, number, 1])
        kind = KINDS[number % len(KINDS)]
        values = {name: _moderate(rng, name) for name in self.names}
        start = rng.uniform(-1, 1, 2 * self._n)
        if kind == "ties":
            values = {name: _tied(rng, name) for name in self.names}
            start = rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0], 2 * self._n)
        elif kind == "equal":
            same = {name[0]: value for name, value in values.items() if name[0] not in "Omega"}
            values = {name: same.get(name[0], value) for name, value in values.items()}
            start = np.repeat(start[:: self._n], self._n)
        elif kind == "decades":
            values = {name: value * _decades(rng, name) for name, value in values.items()}
            start *= 10.0 ** rng.uniform(-6, 1)
        elif kind == "unloaded":
            values = {name: 0.0 if name[0] in "Nkdrc" and rng.random() < 0.4 else v for name, v in values.items()}
        _bounded_coupling(values)
        self._keep_apart(values)
        if kind in ("surface", "edge", "near"):
            start = self._on_surface(rng, values, start, kind)
        return Draw(kind, values, dict(zip(self.states, start.tolist(), strict=True)))

    def _keep_apart(self, values: dict[str, float]) -> None:
        """Give different speeds to belts whose slips differ only by their speeds.

        Contacts whose slips coincide only for particular values do not share load; where friction drops after rest, the
        end of their sticking is then not determined.
        """
        slip, slopes, _, _ = self._look(values, np.zeros(2 * self._n))
        for i in range(self._n_c):
            for j in range(i):
                first = np.flatnonzero(slopes[j])[0]
                factor = slopes[i][first] / slopes[j][first]
                alike = np.array_equal(slopes[i], factor * slopes[j]) and slip[i] == factor * slip[j]
                if alike and f"v{i + 1}" in values:
                    values[f"v{i + 1}"] += 0.0625 * (i + 1)
                    slip = self._look(values, np.zeros(2 * self._n))[0]

    def _look(
        self, values: dict[str, float], start: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return slips, dw/du, static bounds and forces at the start."""
        n, n_c = self._n, self._n_c
        e = np.array([float(x) for x in self._at(*start, *values.values())])
        slip, slopes, bounds, force = np.split(e, np.cumsum([n_c, n * n_c, n_c]))
        return slip, slopes.reshape(n_c, n), bounds, force

    def _on_surface(
        self, rng: np.random.Generator, values: dict[str, float], start: np.ndarray, kind: str
    ) -> np.ndarray:
        """Return a start at which some slips are zero; at the "edge" constant forces bring them to their bounds too."""
        chosen = rng.random(self._n_c) < 0.6
        chosen[rng.integers(self._n_c)] = True
        start = start.copy()
        for _ in range(2):  # once more, since other speeds may be larger: zero to the rounding of the slip itself
            slip, slopes, _, _ = self._look(values, start)
            start[self._n :] -= np.linalg.lstsq(slopes[chosen], slip[chosen], rcond=None)[0]
        if kind == "surface":
            return start
        _, _, bounds, force = self._look(values, start)
        held = slopes[chosen].T @ (bounds[chosen] * rng.choice([-1.0, 1.0], int(chosen.sum())))
        for i in range(self._n):
            values[f"c{i + 1}"] += held[i] - force[i]
        if kind == "near":
            part = 10.0 ** rng.uniform(-15, -3)
            values["c1"] += part * rng.choice([-1.0, 1.0])
            start[self._n] += 0.1 * part * rng.choice([-1.0, 0.0, 1.0])
        return start


def _moderate(rng: np.random.Generator, name: str) -> float:
    """Return a value of order one, by the kind of parameter that the first letter of its name denotes."""
    kind = name[0]
    if kind in "cvFe":
        return float(rng.uniform(-0.5, 0.5))
    if kind in "rb":
        return float(rng.uniform(0.0, 0.5 if kind == "r" else 0.1))
    if kind == "d":
        return float(rng.uniform(0.0, 0.2))
    if kind == "O":
        return float(rng.uniform(0.5, 8.0))
    return float(rng.uniform(0.1, 0.6) if name.startswith("mu") else rng.uniform(0.3, 2.0))


def _tied(rng: np.random.Generator, name: str) -> float:
    """Return one of few values, so that events coincide and forces lie on their bounds."""
    if name[0] in "cvFe":
        return float(rng.choice([-0.25, 0.0, 0.25]))
    if name[0] in "rdb":
        return float(rng.choice([0.0, 0.0, 0.125]))
    return 0.25 if name.startswith("mu") else 1.0


def _decades(rng: np.random.Generator, name: str) -> float:
    """Return a factor over up to twelve decades; laws keep their coefficients, and drives are no faster than 1e3."""
    if name.startswith("mu") or name[0] in "rbe":
        return 1.0
    width = {"O": 2.0, "N": 6.0, "c": 6.0, "F": 6.0, "v": 6.0, "w": 4.0}.get(name[0], 2.0)
    return float(10.0 ** rng.uniform(-width, width if name[0] not in "cNFw" else 0.5 * width))


def _bounded_coupling(values: dict[str, float]) -> None:
    """Limit the couplings of the masses so that the mass matrix is positive definite."""
    for name in [n for n in values if n[0] == "e"]:
        i = int(name[1:])
        values[name] *= 2 * COUPLING * min(values[f"m{i}"], values[f"m{i + 1}"])


KINDS = ("moderate", "ties", "surface", "edge", "near", "equal", "unloaded", "decades")
