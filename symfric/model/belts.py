"""Belt speeds: parameters that drive the contacts of a scene."""

import sympy as sp

from symfric.locks import SYMBOLIC, alone
from symfric.model.scene import Scene


@alone(SYMBOLIC)
def belt_speeds(scene: Scene) -> tuple[sp.Symbol, ...]:
    """Return the belt speeds: parameters that occur in a slip besides the velocities."""
    speeds: list[sp.Symbol] = []
    for contact in scene.contacts:
        drive = contact.slip.subs(dict.fromkeys(scene.system.u, 0))
        speeds += sorted(drive.free_symbols & set(scene.parameters), key=str)
    return tuple(dict.fromkeys(speeds))
