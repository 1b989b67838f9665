"""Steady sliding: friction acts on motions across the sliding direction as a damper."""

from symfric.errors import SceneError
from symfric.model.laws import Law
from symfric.model.laws.law import refuse_memory
from symfric.model.symbols import positive, shortened
from symfric.spelling import spelt


@spelt
def transverse_damping(law: Law, speed: float, normal: float = 1.0) -> float:
    r"""Return the damping constant of friction for motions across a steady sliding.

    Parameters
    ----------
    law : Law
        In numbers.
    speed : float
        Sliding speed v, > 0.
    normal : float
        Normal load N, >= 0.

    Returns
    -------
    float
        :math:`\mu(v) N/v`, force over velocity; never negative, where the damping along, ``N mu'(v)``, may be.

    Raises
    ------
    SceneError
        If a number is out of range, or the law has symbols or memory.

    Notes
    -----
    The friction ``-N mu(S) s/S`` on the slip vector ``s = (v, w)`` has the component ``-N mu(v) w/v`` across, up to
    ``w^3``; along, the slope of the law. With a harmonic w of the amplitude q it takes the mean power
    ``mu N q^2/(2 v)`` from the motion across, and the drag falls by ``N (mu - v mu') q^2/(4 v^2)``;
    derivations/plane.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.plane.transverse_damping(sf.laws.coulomb(0.3), 0.2, normal=10.0), 12)
    15.0
    """
    return steady_power(law, speed, normal) / float(speed) ** 2


@spelt
def steady_power(law: Law, speed: float, normal: float = 1.0) -> float:
    r"""Return the power that friction takes in steady sliding, ``mu(v) N v``.

    Parameters
    ----------
    law, speed, normal
        As in `transverse_damping`.

    Returns
    -------
    float
        Force times velocity.

    Raises
    ------
    SceneError
        As `transverse_damping`.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.plane.steady_power(sf.laws.coulomb(0.3), 0.2, normal=10.0), 12)
    0.6
    """
    if not isinstance(law, Law):
        raise SceneError(f"law is {shortened(law)}; give one of sf.laws")
    refuse_memory(law, "steady sliding in the plane")
    v = positive(speed, "speed")
    return float(law(v)) * positive(normal, "normal", zero=True) * v
