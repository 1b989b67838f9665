"""Threshold of stick-slip of one driven slide: least difference of static and kinetic friction."""

import math

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of
from symfric.model.symbols import finite, shortened
from symfric.spelling import spelt
from symfric.theory.drive.excursion import excursion, slope


@spelt
def threshold(mu1: float, mu2: float, p_star: float, *, scaling: str = "v*") -> float:
    """Return the friction difference eps_crit above which a driven slide has a stick-slip cycle.

    Parameters
    ----------
    mu1, mu2 : float
        Slopes of the force on the slide over its speed, below and above the corner v*, damper included:
        ``2 mu_i = tan(alpha_i) + 2 sigma`` with ``tan(alpha_i) = (dF_a/dX')/(m omega_n)``. Any numbers up to 1e12 in
        size; the source has mu1 < 0 < mu2.
    p_star : float
        ``v*/v - 1`` > -1, the corner's place for the drive's speed v; negative where v > v*.
    scaling : {"v*", "v"}
        With "v*" the answer is ``eps = (F_as - F_ac)/(m omega_n v*)``, the abscissa of the source's maps; with "v" it
        is ``eps1 = f_1s - f_1c = (F_as - F_ac)/(m omega_n v) = eps (1 + p*)``, the jump in the source's (2).

    Returns
    -------
    float
        Zero if the slide sticks again after every release. Infinite if
        it never does, as with p* <= 0 and mu2 >= 1, and where the value exceeds the largest float (mu2 > 0.99999).

    Raises
    ------
    SceneError
        If a parameter is not such a number, or p* <= -1.

    Notes
    -----
    Guida (4), figures 4 and 5. With w = x' sliding is ``w'' + 2 mu(w) w' + w = 0`` and starts at (w, w') = (-1, eps1).
    The slide sticks again if that orbit comes back to w = -1. The outermost orbit that does not is the one that grazes
    (-1, 0); followed backwards it leaves w = -1 at ``w' = eps1_crit``, unless it turns first. With mu2 >= 1 and the
    equilibrium w = 0 above the corner no orbit comes down from there. The kinetic friction drops out. Proved in
    derivations/guida. With p* = 0 exactly and 0 < 1 + mu1 < 1e-5 the speed at the corner underflows, and the answer
    for mu2 < 1 is 0.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.drive.threshold(-0.3, 0.3, -0.2), 6)
    1.859099
    """
    mu1, mu2, p_star = slope(mu1, "mu1"), slope(mu2, "mu2"), finite(p_star, "p_star")
    if not p_star > -1:
        raise SceneError(f"p_star is {p_star:g}; it is v*/v - 1 for positive speeds, so give a number above -1")
    if not is_one_of(scaling, ("v*", "v")):
        raise SceneError(f"scaling is {shortened(scaling)}; forces are taken over m omega_n times 'v*' or 'v'")
    if p_star <= 0 and mu2 >= 1:
        return math.inf
    eps1, _ = excursion(-1.0, 0.0, p_star, -mu1, -mu2)
    return eps1 if scaling == "v" else eps1 / (1 + p_star)
