"""Sprung foundation mass: the mount with which it stabilises the most self-excitation of what stands on it."""

import numpy as np

from symfric.design.absorber.classic import COINCIDENT, rate_of_runs, stable_up_to
from symfric.design.comparison import Compared, Comparison
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.long_calls import logged
from symfric.model import scenes
from symfric.model.scene import Scene
from symfric.theory import absorber as absorber_theory
from symfric.theory import foundation as theory

BESIDE = 0.02  # distance from the bound, relative to it, at which the event-driven model is run
STEPS = (0.1, 0.01)  # of stiffness and damping to the neighbours that are compared
SOFT = 1e-3  # stiffness from which the search for a stable mount starts where the best one has none
DURATION = 20.0  # of the runs, in units of 1/omega1


@logged
def sprung_foundation(mass_ratio: float, *, least_stiffness: float = 0.0) -> Design:
    """Find the mount of a foundation mass that stabilises the most self-excitation of the main mass on it.

    Parameters
    ----------
    mass_ratio : float
        Mass of the foundation over the main mass, > 0.
    least_stiffness : float
        Smallest stiffness of the mount over that of the main spring, >= 0: what stands on it must not sag.

    Returns
    -------
    Design
        With values "stiffness", ``k2/k1``, and "damping", ``c2/(2 m1 omega1)``. The objective is the largest
        ``-c1/(2 m1 omega1)`` of a main mass that excites itself and is still stabilised, as the criterion
        "self-excited" of `absorber` has it, whose objective at equal mass stands among `active`. Status "infimum":
        mounts as near to this one as one likes stabilise what lies as little below the objective. Near equal masses
        such a mount may leave weaker self-excitation unstable; `active` says which.

    Raises
    ------
    SceneError
        If an argument is wrong.

    Notes
    -----
    `symfric.theory.foundation.widest_stability`, exact and proved in derivations/foundation.py; verified on the
    event-driven model a little below and above the bound.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.design.sprung_foundation(0.1)
    >>> round(found.objective, 4), round(sf.design.absorber(0.1, "self-excited").objective, 4)
    (0.5244, 0.16)
    """
    mount = theory.widest_stability(mass_ratio, least_stiffness=least_stiffness)
    rows = []
    for share, word in ((1 - BESIDE, "less"), (1 + BESIDE, "more")):
        beta = share * mount.value
        kappa, gamma, rate = _most_stable(mass_ratio, beta, mount, least_stiffness)
        scene = _scene(mass_ratio, kappa, gamma, -beta)
        name = (
            f"decay rate with {100 * BESIDE:.2g} % {word} self-excitation, stiffness {kappa:.5g}, damping {gamma:.5g}"
        )
        rows.append(Compared(name, rate, rate_of_runs(scene, DURATION), COINCIDENT, 1.0))
        rows.append(Compared(f"stable with {word}", float(word == "less"), float(rate > 0), 0.0, 1.0))
        if word == "less":
            gap = _gap(mass_ratio, kappa, gamma, beta)
    other = absorber_theory.widest_stability(mass_ratio).value
    active = [f"an absorber of equal mass stabilises {other:.6g}"]
    if mount.stiffness == least_stiffness:
        active.append("stiffness at its lower bound")
    if gap:
        active.append(
            f"a mount that stabilises {(1 - BESIDE) * mount.value:.6g} leaves {gap[0]:.4g} to {gap[1]:.4g} unstable"
        )
    values = {"stiffness": mount.stiffness, "damping": mount.damping}
    scene = _scene(mass_ratio, mount.stiffness, mount.damping, -mount.value)
    around = _beside(mass_ratio, mount, least_stiffness)
    return design(
        values,
        mount.value,
        active,
        scene,
        Comparison(tuple(rows)),
        _curve(mass_ratio, mount, least_stiffness),
        claim="infimum",
        neighbours=around,
        sense=-1,
    )


def _scene(mass_ratio: float, stiffness: float, damping: float, main_damping: float) -> Scene:
    return scenes.sprung_foundation(
        mass_ratio=mass_ratio, stiffness=stiffness, damping=damping, main_damping=main_damping
    )


def bound(mass_ratio: float, stiffness: float, damping: float) -> float:
    """Return the largest self-excitation at which a mount is stable, 0 if it is not stable without any."""
    return stable_up_to(lambda beta: theory.decay_rate(mass_ratio, stiffness, damping, -beta), 2.0)


def _most_stable(mass_ratio: float, beta: float, mount: theory.Mount, least: float) -> tuple[float, float, float]:
    """Return stiffness, damping and decay rate of the fastest decay near a mount, for a given self-excitation."""
    from scipy.optimize import minimize

    def rate(p: np.ndarray) -> float:
        kappa, gamma = max(least, float(np.exp(p[0]))), float(np.exp(p[1]))
        return -theory.decay_rate(mass_ratio, kappa, gamma, -beta)

    # logarithms keep both positive, and the best stiffness may be smaller by decades
    start = np.log([max(mount.stiffness, SOFT), mount.damping])
    simplex = start + np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.02]])
    options = {"xatol": 1e-8, "fatol": 1e-12, "initial_simplex": simplex, "maxiter": 2000}
    fastest = minimize(rate, start, method="Nelder-Mead", options=options)
    return max(least, float(np.exp(fastest.x[0]))), float(np.exp(fastest.x[1])), -float(fastest.fun)


def _gap(mass_ratio: float, stiffness: float, damping: float, beta: float) -> tuple[float, float] | None:
    """Return the weaker self-excitations that a mount leaves unstable although it stabilises a stronger one."""
    weaker = np.linspace(0.0, beta, 201)
    rates = np.array([theory.decay_rate(mass_ratio, stiffness, damping, -e) for e in weaker])
    bad = weaker[rates < 0]
    return (float(bad[0]), float(bad[-1])) if bad.size else None


def _beside(mass_ratio: float, mount: theory.Mount, least: float) -> list[Neighbour]:
    """Return mounts around the best one and how much each stabilises."""
    neighbours = []
    for step in STEPS:
        for f, z in ((-1, 0), (1, 0), (0, -1), (0, 1), (1, 1), (-1, -1)):
            kappa = mount.stiffness + f * step * max(mount.stiffness, 1.0)
            gamma = mount.damping * (1 + z * step)
            if kappa >= least:
                words = f"stiffness {kappa:.6g}, damping {gamma:.6g}"
                neighbours.append(Neighbour(words, bound(mass_ratio, kappa, gamma), 0.0))
    return neighbours


def _curve(mass_ratio: float, mount: theory.Mount, least: float) -> Curve:
    """Return how much the best damping of each stiffness stabilises."""
    top = 2 * max(mount.stiffness, least, 1.0)
    kappa = np.unique(np.append(np.linspace(least, top, 121), mount.stiffness))
    y = np.array([theory.at_stiffness(mass_ratio, k).value for k in kappa])
    y[kappa == mount.stiffness] = mount.value  # in tune the least upper bound is that of the mounts beside it
    return Curve(
        kappa, y, mount.value, "stiffness of the mount k2/k1", "self-excitation stabilised", (mount.stiffness,)
    )
