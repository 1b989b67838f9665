"""Ten calls from one to forty masses that take a user's time: orbits, branches, responses, designs and a sweep."""

from collections.abc import Callable

import numpy as np
import sympy as sp

from symfric.design.damper.design import damper
from symfric.design.quench.design import quench
from symfric.ensemble.sweep import sweep
from symfric.model import laws, scenes
from symfric.model.outputs import HalfRange
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME
from symfric.orbits.continuation.branch import continue_cycle
from symfric.orbits.cycle import limit_cycle
from symfric.orbits.frequency_response import frequency_response
from symfric.structures.brake import disc_and_pad
from symfric.structures.contacts import RowContact
from symfric.structures.makers import beam, chain
from symfric.structures.structure import Structure
from symfric_evidence.bench import larger

_W, _N, _MU, _V = sp.symbols("W N mu v_b", positive=True)


def cycle_of_two_masses() -> object:
    """Return the limit cycle of two masses on one belt."""
    return limit_cycle(larger.chain(2))


def branch_of_two_masses() -> object:
    """Return its branch over the belt's speed, with folds, flips and jumps."""
    return continue_cycle(larger.chain(2), "v_b", (0.05, 0.4))


def branch_with_bristles() -> object:
    """Return the branch of a mass on a belt with stiff bristles (LuGre)."""
    law = laws.lugre(0.4, 0.25, 0.1, 1e5, 300.0)
    return continue_cycle(scenes.mass_on_belt(law, v_b=0.1), "v_b", (0.05, 0.3))


def response_of_three_masses() -> object:
    """Return the forced response of three masses, the last with a joint that slips and sticks."""
    structure = chain(3, damping=0.02)
    joint = RowContact("joint", {"x3": 1.0}, _N, laws.coulomb(0.4))
    force = {"x1": 0.3 * sp.cos(_W * TIME)}
    scene = structure.scene([joint], force=force, values={_W: 0.7, _N: 0.2}, horizon=60.0)
    return frequency_response(scene, "W", (0.4, 1.1), tolerance=1e-10)


def damper_of_a_blade() -> object:
    """Return the load of a friction damper under a blade's platform with the smallest resonance."""
    platform = RowContact("platform", {"w3": 1.0}, _N, laws.coulomb(0.4), stiffness=60.0)
    small = beam(12, damping=2e-3).reduced([platform, "w12"], modes=1)
    force, values = {"w12": 0.02 * sp.cos(_W * TIME)}, {_W: 3.6, _N: 0.6}
    forced = small.scene([platform], force=force, values=values, initial={"w12": 0.1}, horizon=40.0)
    return damper(forced, "N", bounds=(0.3, 1.5), speeds=(3.5, 3.9), speed="W", coordinate="w12")


def cycle_of_a_disc_brake() -> object:
    """Return the cycle of a reduced disc brake, seven pairs of nodes that stick, slip and open."""
    brake = disc_and_pad(damping=0.3)
    contacts = brake.contacts(preload=0.01, law=laws.coulomb(_MU), speed=_V)
    small = brake.apart.reduced([*contacts, "p0_3x"], modes=20)
    scene = small.scene(contacts, values={_MU: 0.5, _V: 0.02}, initial={"p0_3x": 0.02}, horizon=1500.0)
    return limit_cycle(scene, tolerance=1e-9)


def quench_of_a_narrow_law() -> object:
    """Return the excitation that quenches a law with a step of the width .005."""
    law = laws.custom(0.4 - 0.05 * sp.tanh((SPEED - 0.2713) / 0.005), 0.46)
    scene = scenes.mass_on_belt(law, v_b=0.3, a=0.0, Omega=20.0)
    return quench(scene, (0.05, 0.6), Omega=(20, 60), a=(0, 0.05))


def sweep_of_belts() -> object:
    """Return the half ranges of a thousand belts."""
    x = sp.Symbol("x", real=True)
    scene = scenes.mass_on_belt(v_b=0.2, horizon=200.0).wanting({"half": HalfRange(x)})
    return sweep(scene, {"v_b": np.linspace(0.02, 0.45, 1000)}, tolerance=1e-6)


def _rubbed(n: int) -> Scene:
    """Return a chain whose first mode alone is not damped enough, rubbed by a belt at three places."""
    plain = chain(n, ends="fixed-free")
    shape = plain.modes(1).shapes[:, 0]
    shape = shape / np.sqrt(shape @ (plain.M @ shape))
    own = plain.M @ shape
    damping = 0.15 * plain.M.toarray() - 0.147 * np.outer(own, own)
    full = Structure(plain.M, plain.K, damping, names=plain.names)
    law, places = laws.stribeck(0.5, 0.3, 0.2), [f"x{int(share * n)}" for share in (0.75, 0.85, 0.95)]
    pads = [RowContact(place, {place: 1.0}, 0.2, law, speed=0.1) for place in places]
    return full.scene(pads, initial=3.5 * n / 60 * shape / shape[-1], horizon=4000.0 * n / 60)


def cycle_of_ten_masses() -> object:
    """Return the limit cycle of ten masses rubbed at three places."""
    return limit_cycle(_rubbed(10))


def cycle_of_forty_masses() -> object:
    """Return the limit cycle of forty masses rubbed at three places."""
    return limit_cycle(_rubbed(40))


CALLS: dict[str, Callable[[], object]] = {
    "limit cycle, two masses": cycle_of_two_masses,
    "branch, two masses": branch_of_two_masses,
    "branch, bristles": branch_with_bristles,
    "response, three masses": response_of_three_masses,
    "damper of a forced blade": damper_of_a_blade,
    "limit cycle, disc brake": cycle_of_a_disc_brake,
    "quench, narrow law": quench_of_a_narrow_law,
    "sweep, 1000 belts": sweep_of_belts,
    "limit cycle, ten masses": cycle_of_ten_masses,
    "limit cycle, forty masses": cycle_of_forty_masses,
}
