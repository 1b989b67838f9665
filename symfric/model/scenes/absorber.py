"""A tuned mass damper on a main mass, with an optional dry contact in the absorber or at the main mass."""

from typing import Literal

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.arguments import is_one_of
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import check_range
from symfric.model.symbols import TIME, finite, shortened
from symfric.model.system import Contact, System

_X1, _X2, _U1, _U2 = sp.symbols("x1 x2 u1 u2", real=True)
PLACES = ("absorber", "main")


@alone(SYMBOLIC)
def absorber(
    *,
    mass_ratio: float,
    tuning: float,
    damping: float,
    main_damping: float = 0.0,
    F: float = 1.0,
    Omega: float = 1.0,
    friction: float = 0.0,
    static_friction: float | None = None,
    contact: Literal["absorber", "main"] | None = None,
    horizon: float = 200.0,
) -> Scene:
    r"""Main mass on a spring, shaken by a harmonic force, with a smaller mass on a spring and a damper upon it.

    Parameters
    ----------
    mass_ratio : float
        ``m2/m1`` > 0.
    tuning : float
        ``omega2/omega1`` > 0, each mass on its own spring.
    damping : float
        ``c2/(2 m2 omega2)``.
    main_damping : float
        ``c1/(2 m1 omega1)``; negative for a self-excited main mass.
    F, Omega : float
        Amplitude and frequency of the force ``F cos(Omega t)`` on the main mass.
    friction, static_friction : float
        Kinetic and static friction of the contact; the static one is the kinetic one unless given.
    contact : {None, "absorber", "main"}
        Between the two masses, or between the main mass and the ground; no contact unless given.
    horizon : float

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Notes
    -----
    ``x1'' + 2 zeta1 x1' + x1 = F cos(Omega t) + mu r`` and ``x2'' = -r`` with ``r = 2 zeta f (x2' - x1') + f^2 (x2 -
    x1)``: time in units of 1/omega1, forces over ``k1`` times the unit of length, which F = 1 makes the static
    displacement; Den Hartog, *Mechanical Vibrations*, chapter 3. Starts at rest.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.absorber(mass_ratio=0.1, tuning=0.909, damping=0.185)
    >>> run = sf.simulate(scene)
    >>> run.names
    ('x1', 'x2', 'u1', 'u2')
    """
    check_range({"mass_ratio": mass_ratio, "tuning": tuning})
    mu, f, zeta, zeta1, F_, Omega_ = sp.symbols("mass_ratio tuning damping main_damping F Omega", real=True)
    pull = mu * (2 * zeta * f * (_U2 - _U1) + f**2 * (_X2 - _X1))
    values = {mu: mass_ratio, f: tuning, zeta: damping, zeta1: main_damping, F_: F, Omega_: Omega}
    contacts, more = _contacts(contact, friction, static_friction)
    return Scene(
        system=System(
            q=[_X1, _X2],
            u=[_U1, _U2],
            mass=sp.diag(1, mu),
            force=[F_ * sp.cos(Omega_ * TIME) - 2 * zeta1 * _U1 - _X1 + pull, -pull],
        ),
        contacts=contacts,
        values=values | more,
        initial=dict.fromkeys((_X1, _X2, _U1, _U2), 0.0),
        horizon=horizon,
    )


def _contacts(
    place: str | None, friction: float, static_friction: float | None
) -> tuple[list[Contact], dict[sp.Symbol, float]]:
    """Return the contact and its values."""
    if place is None:
        if finite(friction, "friction") != 0 or static_friction is not None:
            raise SceneError("friction is given without a contact; say contact='absorber' or contact='main'")
        return [], {}
    if not is_one_of(place, PLACES):
        raise SceneError(f"contact is {shortened(place)}; it is in the 'absorber', at the 'main' mass, or None")
    kinetic, static = sp.symbols("friction static_friction", real=True)
    slip = _U2 - _U1 if place == "absorber" else _U1
    law = laws.coulomb(static, kinetic)
    static_friction = friction if static_friction is None else static_friction
    return [Contact(place, slip=slip, normal=1, law=law)], {kinetic: friction, static: static_friction}
