"""Events at known times: steps of forces, loads and belts, sampled controllers with dead time, and kicks.

Every structure is a scene and, for the same numbers, a system of the foreign reference in
`symfric_evidence.event_reference.known_instants`.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.held import Held
from symfric.model.outputs import Trajectory
from symfric.model.resets import Reset
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact, System
from symfric_evidence.event_reference.known_instants import Friction, Instant, SteppedSystem, stairs
from symfric_evidence.stress.families.family import RandomStructure, Ranges, oscillators, parameter, real
from symfric_evidence.stress.random_scenes import Draw

_HORIZON = 8.0
_LAWS = ("coulomb", "stribeck", "lorentz")
_DELAYS = (0.0, 0.3, 1.0, 1.75, 2.0)  # in periods
_SHARE = 0.3  # part of the period for which a pulse is on


@dataclass(frozen=True)
class _Controller:
    """A sampled controller in numbers: its times are those of the structure, its gains are drawn."""

    every: float
    offset: float
    delay: float
    step: float | None
    slow: bool  # a second variable, sampled at every third instant


@dataclass(frozen=True)
class InstantsStructure(RandomStructure):
    """A structure with the same system for the reference.

    Attributes
    ----------
    masses : int
    joint : bool
        One contact between two masses, instead of one for each with the ground.
    kinds : tuple of str
        Law of every contact.
    counts : dict of str to int
        Number of steps by what steps.
    pulsed : bool
    controller : _Controller, optional
    kicks : int
    """

    masses: int = 1
    joint: bool = False
    kinds: tuple[str, ...] = ()
    counts: dict[str, int] = field(default_factory=dict)
    pulsed: bool = False
    controller: _Controller | None = None
    kicks: int = 0

    def reference(self, draw: Draw) -> SteppedSystem:
        """Return the system with the numbers of a draw."""
        v, n = draw.values, self.masses
        jumps = {name: _jumps(v, name, count) for name, count in self.counts.items()}
        push = stairs(0.0, jumps["F"])
        contacts = []
        for i, kind in enumerate(self.kinds):
            row = np.array([-1.0, 1.0]) if self.joint else np.eye(n)[i]
            belt = stairs(v.get(f"v{i + 1}", 0.0), jumps["v"] if i == 0 else [])
            load = stairs(1.0, jumps["g"] if i == 0 else [])
            mu, mu_s, w, N = (
                v[f"mu{i + 1}"],
                v[f"mu{i + 1}"] * (1 + v[f"r{i + 1}"]),
                v.get(f"w{i + 1}", 1.0),
                v[f"N{i + 1}"],
            )
            contacts.append(Friction(row, belt, _times(N, load), mu_s, _kinetic(kind, mu, mu_s, w)))
        pulse_steps = []
        if self.pulsed:
            period = v["T"]
            pulse_steps = [k * period + s for k in range(int(_HORIZON / period) + 1) for s in (0.0, _SHARE * period)]

        def force(y: np.ndarray, t: float, piece: float, memory: Mapping[str, float]) -> np.ndarray:
            x, u = y[:n], y[n:]
            f = np.array([-v[f"k{i + 1}"] * x[i] - v[f"d{i + 1}"] * u[i] - v["h"] * x[i] ** 3 for i in range(n)])
            if n > 1:
                f += v["kc1"] * (x[1] - x[0]) * np.array([1.0, -1.0])
            f[0] += push(piece) + memory.get("command", 0.0) + v["A"] * math.sin(v["Omega"] * t)
            if self.pulsed and math.fmod(piece, v["T"]) < _SHARE * v["T"]:
                f[-1] += v["P"]
            return f

        steps = [time for found in jumps.values() for time, _ in found] + pulse_steps
        return SteppedSystem(np.ones(n), force, contacts, steps, self._instants(v), dict.fromkeys(_HELD, 0.0))

    def _instants(self, v: dict[str, float]) -> list[Instant]:
        n, found = self.masses, [_kick(v, k, self.masses) for k in range(self.kicks)]
        c = self.controller
        if c is None:
            return found
        computed: dict[int, float] = {}

        def sample(k: int) -> Callable[[np.ndarray, dict[str, float]], None]:
            def act(y: np.ndarray, memory: dict[str, float]) -> None:
                if c.slow and k % 3 == 0:
                    memory["slow"] = 0.5 * memory["slow"] - v["Ks"] * y[n]
                memory["integral"] += v["Ki"] * (_TARGET - y[0])
                value = v["K"] * (_TARGET - y[0]) - v["D"] * y[n] + memory["integral"] + memory["slow"]
                computed[k] = value if c.step is None else c.step * math.floor(value / c.step + 0.5)
                if c.delay == 0:
                    memory["command"] = computed[k]

            return act

        def acts(k: int) -> Callable[[np.ndarray, dict[str, float]], None]:
            def act(y: np.ndarray, memory: dict[str, float]) -> None:
                memory["command"] = computed[k]

            return act

        for k in range(int(_HORIZON / c.every) + 1):
            found.append(Instant(c.offset + k * c.every, 1, sample(k)))
            if c.delay:
                found.append(Instant(c.offset + k * c.every + c.delay, 0, acts(k)))
        return found


_HELD, _TARGET = ("command", "integral", "slow"), 1 / 3


def instants(rng: np.random.Generator) -> InstantsStructure:
    """Friction under steps in time, held commands and kicks; contacts do not feel each other's force."""
    n = 1 + int(rng.random() < 0.4)
    joint = n == 2 and rng.random() < 0.4
    kinds = tuple(_LAWS[k] for k in rng.integers(len(_LAWS), size=1 if joint else n))
    q, u, forces, ranges = oscillators(n)
    h, A, Omega = parameter("h"), parameter("A"), parameter("Omega")
    ranges |= {"h": (0.0, 1.0), "A": (0.0, 1.5), "Omega": (0.5, 5.0)}
    forces = [f - h * x**3 for f, x in zip(forces, q, strict=True)]
    forces[0] += A * sp.sin(Omega * TIME)
    counts = {"F": int(rng.integers(5)), "v": int(rng.integers(4)), "g": int(rng.integers(3))}
    forces[0] += _stairs("F", counts["F"], ranges, (-1.5, 1.5))
    pulsed = bool(rng.random() < 0.3)
    if pulsed:
        P, T = real("P"), parameter("T")
        ranges |= {"P": (-1.5, 1.5), "T": (0.4, 3.0)}
        forces[-1] += sp.Piecewise((P, sp.Mod(TIME, T) < sp.Float(_SHARE) * T), (0, True))
    contacts = []
    for i, kind in enumerate(kinds):
        mu, r, w, N, v = (parameter(f"{p}{i + 1}") for p in ("mu", "r", "w", "N", "v"))
        ranges |= {f"mu{i + 1}": (0.1, 0.6), f"r{i + 1}": (0.01, 0.8), f"w{i + 1}": (0.1, 1.0)}
        ranges |= {f"N{i + 1}": (0.2, 2.0), f"v{i + 1}": (0.0, 0.5)}
        belt = v + (_stairs("v", counts["v"], ranges, (-0.8, 0.8)) if i == 0 else 0)
        load = N * (1 + (_stairs("g", counts["g"], ranges, (-0.45, 1.5)) if i == 0 else 0))
        slip = (u[1] - u[0] if joint else u[i]) - belt
        contacts.append(Contact(f"c{i + 1}", slip, load, _law(kind, mu, mu * (1 + r), w)))
    controller: _Controller | None = None
    held: tuple[Held, ...] = ()
    if rng.random() < 0.6:
        every = round(float(rng.uniform(0.05, 0.6)), 3)
        offset = 0.0 if rng.random() < 0.4 else round(float(rng.uniform(0.01, 0.3)), 3)
        delay = round(every * float(rng.choice(_DELAYS)), 6)
        step = float(rng.choice([0.02, 0.1])) if rng.random() < 0.3 else None
        controller = _Controller(every, offset, delay, step, bool(rng.random() < 0.4))
        command, held = _held(controller, q[0], u[0], ranges)
        forces[0] += command
    kicks = int(rng.integers(4)) if rng.random() < 0.5 else 0
    return _structure(rng, (q, u, forces), contacts, ranges, (n, joint, kinds, counts, pulsed, controller, kicks), held)


def _structure(
    rng: np.random.Generator,
    equations: tuple[Sequence[sp.Symbol], Sequence[sp.Symbol], list[sp.Expr]],
    contacts: list[Contact],
    ranges: Ranges,
    plan: tuple[int, bool, tuple[str, ...], dict[str, int], bool, _Controller | None, int],
    held: tuple[Held, ...],
) -> InstantsStructure:
    (q, u, forces), kicks = equations, plan[-1]
    resets = []
    for k in range(kicks):  # the first two strike one mass, a third turns the last
        time, size = parameter(f"tk{k + 1}"), real(f"b{k + 1}")
        ranges |= {time.name: (0.3, 7.5), size.name: (-1.0, 1.0)}
        resets.append(Reset(at=[time], set={u[0]: u[0] + size} if k < 2 else {u[-1]: -size * u[-1]}))
    states = {s.name for s in (*q, *u)}
    system = System(q, u, sp.eye(len(q)).tolist(), forces)
    used = set().union(*(e.free_symbols for e in system.expressions), *(c.free_symbols for c in contacts))
    timed: list[Held | Reset] = [*held, *resets]
    used = used.union(*(e.free_symbols for part in timed for e in part.expressions))
    names = {s.name for s in used}
    values = {n: 0.5 * (low + high) for n, (low, high) in ranges.items() if n in names - states}
    start = dict.fromkeys((*q, *u), 0.1)
    scene = Scene(system, contacts, values, start, _HORIZON, {"path": Trajectory()}, held=list(held), resets=resets)
    known = {s.name for s in scene.parameters} | states
    kept = {name: r for name, r in ranges.items() if name in known}
    return InstantsStructure(scene, kept, {}, None, 1.0, (), None, *plan)


def _stairs(name: str, count: int, ranges: Ranges, sizes: tuple[float, float]) -> sp.Expr:
    """Return a sum of steps at random times."""
    total = sp.S.Zero
    for k in range(count):
        time, size = parameter(f"t{name}{k + 1}"), real(f"{name}s{k + 1}")
        ranges |= {time.name: (0.2, 7.8), size.name: sizes}
        total += size * sp.Heaviside(TIME - time)
    return total


def _jumps(values: dict[str, float], name: str, count: int) -> list[tuple[float, float]]:
    return [(values[f"t{name}{k + 1}"], values[f"{name}s{k + 1}"]) for k in range(count)]


def _held(c: _Controller, x: sp.Symbol, u: sp.Symbol, ranges: Ranges) -> tuple[sp.Symbol, tuple[Held, ...]]:
    """Return the command and the held variables of a controller."""
    K, D, Ki, Ks = (parameter(name) for name in ("K", "D", "Ki", "Ks"))
    ranges |= {"K": (0.2, 2.0), "D": (0.0, 0.8), "Ki": (0.0, 0.1)}
    before = {name: real(f"{name}.previous") for name in _HELD}
    target = sp.Float(_TARGET)
    integral = Held("integral", before["integral"] + Ki * (target - x), c.every, c.offset)
    total, held = K * (target - x) - D * u + integral.symbol, [integral]
    if c.slow:
        ranges["Ks"] = (0.1, 1.0)
        slow = Held("slow", before["slow"] / 2 - Ks * u, 3 * c.every, c.offset)
        total, held = total + slow.symbol, [*held, slow]
    command = Held("command", total, c.every, c.offset, c.delay, step=c.step)
    return command.symbol, (*held, command)


def _kick(values: dict[str, float], k: int, n: int) -> Instant:
    size = values[f"b{k + 1}"]

    def act(y: np.ndarray, memory: dict[str, float]) -> None:
        if k < 2:
            y[n] += size
        else:
            y[-1] *= -size

    return Instant(values[f"tk{k + 1}"], 2, act)


def _law(kind: str, mu: sp.Expr, mu_s: sp.Expr, w: sp.Expr) -> laws.Law:
    if kind == "coulomb":
        return laws.coulomb(mu_s, mu)
    return laws.stribeck(mu_s, mu, w) if kind == "stribeck" else laws.lorentz(mu, w, mu_s)


def _kinetic(kind: str, mu: float, mu_s: float, w: float) -> Callable[[float], float]:
    """Return the coefficient at a speed, written out."""
    if kind == "coulomb":
        return lambda v: mu
    if kind == "stribeck":
        return lambda v: mu + (mu_s - mu) * math.exp(-v / w)
    return lambda v: mu / (1 + (v / w) ** 2)


def _times(factor: float, function: Callable[[float], float]) -> Callable[[float], float]:
    return lambda t: factor * function(t)
