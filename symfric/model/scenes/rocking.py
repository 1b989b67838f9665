"""The ready scene of a rigid block that rocks on the shaken ground."""

import math

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.outputs import Max, Output, Trajectory
from symfric.model.planar import Body, against_line
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import check_range
from symfric.model.scenes.isolator import Record, as_signal
from symfric.model.symbols import Key, finite
from symfric.model.system import Contact, Signal, System
from symfric.model.unilateral import Unilateral

_X, _Y, _THETA, _U, _V, _OMEGA = sp.symbols("x y theta u v omega", real=True)
_RUN_OUT = 10.0  # horizon beyond the end of the record in s, in which the block comes to rest


@alone(SYMBOLIC)
def rocking_block(
    *,
    R: float,
    alpha: float,
    motion: Record | None = None,
    mu: float = 1.0,
    e: float = 0.0,
    theta0: float = 0.0,
    g: float = 9.81,
    horizon: float | None = None,
) -> Scene:
    r"""Uniform rigid block on the ground, which it may tilt on, slide on and leave, shaken by the ground or let go.

    Parameters
    ----------
    R : float
        Distance from the centre to a corner, m: half of the diagonal.
    alpha : float
        Angle of the diagonal from the vertical, rad: half width ``R sin(alpha)``, half height ``R cos(alpha)``.
    motion : Signal or Motion, optional
        Acceleration of the ground, m/s^2, linear between its samples.
    mu : float
        Coefficient of friction.
    e : float
        Restitution of the corners.
    theta0 : float
        Angle at the start, rad, counter-clockwise; the block rests on one corner, or on both for zero.
    g : float
        Gravity, m/s^2.
    horizon : float, optional
        s; unless given, 10 s longer than the record, or ten natural periods ``2 pi sqrt(4R/(3g))`` without one.

    Returns
    -------
    Scene
        With the outputs `largest_tilt` and `largest_shift`, relative to the ground, in rad and m. The factor
        `amplitude` of the motion is 1 unless changed by `where`.

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    Housner, Bull. Seism. Soc. Am. 53 (1963) 403, has the block turn about its corners without sliding and bouncing;
    there its speed after an impact is :math:`1 - \tfrac32\sin^2\alpha` times that before, its quarter period from the
    angle theta0 is :math:`\operatorname{arccosh}(1/(1 - \theta_0/\alpha))/p` for slender blocks,
    :math:`p^2 = 3g/(4R)`, and it starts to rock where the acceleration of the ground exceeds ``g tan(alpha)``. Here
    these follow from two contacts that open, as long as friction holds.

    Examples
    --------
    >>> import symfric as sf
    >>> burst = sf.motions.sine_burst(3.0, 1.0)
    >>> block = sf.scenes.rocking_block(R=1.0, alpha=0.25, motion=burst)
    >>> 0.01 < sf.simulate(block)["largest_tilt"] < 0.25
    True
    """
    check_range({"R": R, "alpha": alpha, "g": g}, {"mu": mu, "e": e})
    if not alpha < math.pi / 2:
        raise SceneError(f"alpha is {alpha:g}; the angle of the diagonal from the vertical is below pi/2")
    if not abs(finite(theta0, "theta0")) < alpha:
        raise SceneError(f"theta0 is {theta0:g}; beyond alpha = {alpha:g} the block falls over")
    R_, alpha_, mu_, e_, g_, theta0_ = sp.symbols("R alpha mu e g theta0", real=True)
    b, h = R_ * sp.sin(alpha_), R_ * sp.cos(alpha_)
    block = Body(_X, _Y, _THETA, q=(_X, _Y, _THETA), u=(_U, _V, _OMEGA))
    contacts = []
    corners = {"left": (-b, -h), "right": (b, -h), "upper left": (-b, h), "upper right": (b, h)}
    for name, (along, up) in corners.items():
        touch = against_line(block.point(along, up))
        contacts.append(Contact(name, slip=touch.slip, normal=Unilateral(touch.gap, e_), law=laws.coulomb(mu_)))
    values: dict[Key, float | None] = {R_: R, alpha_: alpha, mu_: mu, e_: e, g_: g, theta0_: theta0}
    shaking: sp.Expr = sp.S.Zero
    inputs: dict[Key, Signal] = {}
    length = 20 * math.pi * math.sqrt(4 * R / (3 * g))
    if motion is not None:
        amplitude, a_g = sp.symbols("amplitude a_g", real=True)
        inputs[a_g] = as_signal(motion)
        values[amplitude] = 1.0
        shaking, length = -amplitude * a_g, inputs[a_g].t_end + _RUN_OUT
    outputs: dict[str, Output] = {
        "path": Trajectory(),
        "largest_tilt": Max(sp.Abs(_THETA)),
        "largest_shift": Max(sp.Abs(_X)),
    }
    return Scene(
        system=System(q=[_X, _Y, _THETA], u=[_U, _V, _OMEGA], mass=sp.diag(1, 1, R_**2 / 3), force=[shaking, -g_, 0]),
        contacts=contacts,
        values=values,
        initial={
            _X: 0.0,
            _Y: h * sp.cos(theta0_) + b * sp.Abs(sp.sin(theta0_)),
            _THETA: theta0_,
            _U: 0.0,
            _V: 0.0,
            _OMEGA: 0.0,
        },
        horizon=length if horizon is None else finite(horizon, "horizon"),
        outputs=outputs,
        inputs=inputs,
    )
