"""Larger problems: many contacts, a record, two bodies in contact, dynamic friction."""

import sympy as sp

from symfric.model import laws, scenes
from symfric.model.outputs import End
from symfric.model.scene import Scene
from symfric.model.system import Contact, Signal, System
from symfric.motions.synthetic import synthetic

RECORD_SEED = 7


def chain(masses: int = 10, *, horizon: float = 30.0, moving: int | None = None) -> Scene:
    """Masses on one belt, each held by a spring and tied to its neighbours.

    Parameters
    ----------
    masses : int
    horizon : float
    moving : int, optional
        How many of them rub on the belt; all unless given.

    Notes
    -----
    Loads rise by 5 % from mass to mass, so that no two contacts act at one time.
    """
    q, u = (sp.symbols(f"{letter}0:{masses}", real=True) for letter in "qu")
    speed, beta = sp.symbols("v_b beta", real=True)
    force = [-q[i] / 2 - 2 * beta * u[i] for i in range(masses)]
    for i in range(masses - 1):
        force[i] += q[i + 1] - q[i]
        force[i + 1] += q[i] - q[i + 1]
    rubbing = range(masses if moving is None else moving)
    law = laws.coulomb(0.5, 0.3)
    contacts = [Contact(f"c{i}", slip=u[i] - speed, normal=sp.Rational(20 + i, 20), law=law) for i in rubbing]
    system = System(q=q, u=u, mass=sp.eye(masses), force=force)
    start = dict.fromkeys([*q, *u], 0.0)
    return Scene(system, contacts, {speed: 0.2, beta: 0.025}, start, horizon, {"end": End()})


def isolator() -> Scene:
    """Return a mass on rolling bearings under a synthetic earthquake, until it is at rest."""
    record = synthetic(seed=RECORD_SEED, pga=3.0, duration=15.0, dt=0.01)
    samples = record.samples.round(4)  # so that the record is the same decimal numbers on every machine
    scene = scenes.rolling_isolator(C=300.0, m=1000.0, motion=Signal(samples, record.dt), profile=0.05, horizon=18.0)
    return scene.wanting({"end": End()})


def slides() -> Scene:
    """Return two slides in contact with stick-slip vibration."""
    scene = scenes.two_slides(r=1.0, zeta=2.0, s1=0.05, s2=0.1, fc1=3.0, fs1=4.0, horizon=100.0)
    return scene.wanting({"end": End()})


def bristles() -> Scene:
    r"""Mass on a belt with the friction of Canudas de Wit, Olsson, Astrom and Lischinsky (LuGre).

    Notes
    -----
    :math:`F = \sigma_0 z + \sigma_1 z' + \sigma_2 w`, :math:`z' = w - \sigma_0 |w| z/g(w)`,
    :math:`g = F_c + (F_s - F_c) e^{-(w/v_s)^2}`, IEEE Transactions on Automatic Control 40 (1995) 419.
    """
    x, u, z = sp.symbols("x u z", real=True)
    speed, beta, s0, s1, s2, fc, fs, vs = sp.symbols("v_b beta sigma0 sigma1 sigma2 F_c F_s v_s", real=True)
    w = u - speed
    level = fc + (fs - fc) * sp.exp(-((w / vs) ** 2))
    rate = w - s0 * sp.Abs(w) * z / level
    friction = s0 * z + s1 * rate + s2 * w
    system = System(q=[x], u=[u], mass=[[1]], force=[-x - 2 * beta * u - friction], z=[z], z_rate=[rate])
    values = {speed: 0.2, beta: 0.05, s0: 1000.0, s1: 10.0, s2: 0.0, fc: 0.25, fs: 0.4, vs: 0.1}
    return Scene(system, [], values, {x: 0.0, u: 0.0, z: 0.0}, 50.0, {"end": End()})
