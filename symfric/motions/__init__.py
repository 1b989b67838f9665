"""Ground motions: records from files, synthetic motions, and scaling."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of, items
from symfric.model.numeric import Floats
from symfric.model.public_names import names_of
from symfric.model.symbols import finite, shortened
from symfric.motions.motion import Motion
from symfric.motions.random_forcing import random_forcing
from symfric.motions.record_files import read_at2, read_text
from symfric.motions.spectrum import Spectrum
from symfric.motions.synthetic import Misfit, eurocode8, misfit, sine_burst, synthetic
from symfric.motions.units import factor_of
from symfric.spelling import spelt

__all__ = [
    "Misfit",
    "Motion",
    "Spectrum",
    "eurocode8",
    "mean_spectrum",
    "misfit",
    "random_forcing",
    "read_at2",
    "read_text",
    "scaled_set",
    "sine_burst",
    "synthetic",
]


@spelt
def mean_spectrum(motions: Sequence[Motion], periods: Floats, damping: float = 0.05) -> Spectrum:
    """Return the arithmetic mean of the motions' spectra; its acceleration at period 0 is the mean of their PGAs.

    Parameters
    ----------
    motions : sequence of Motion
    periods : sequence of float
        s.
    damping : float
        Damping ratio.

    Returns
    -------
    Spectrum

    Raises
    ------
    SceneError
        If there is no motion, or the periods are wrong.

    Examples
    --------
    >>> import symfric as sf
    >>> quake = sf.motions.sine_burst(3.0, 2.0, cycles=5)
    >>> (sf.motions.mean_spectrum([quake, quake.times(2.0)], [0.5]).pseudo_acceleration).round(6)
    array([25.017484])
    """
    spectra = [m.spectrum(periods, damping) for m in _set(motions)]
    return Spectrum(
        spectra[0].periods,
        spectra[0].damping,
        np.mean([s.displacement for s in spectra], axis=0),
        np.mean([s.pseudo_velocity for s in spectra], axis=0),
        np.mean([s.pseudo_acceleration for s in spectra], axis=0),
        f"mean of {len(spectra)} motions",
    )


@spelt
def scaled_set(
    motions: Sequence[Motion], pga: float, unit: str = "m/s^2", *, by: str = "mean spectrum"
) -> tuple[Motion, ...]:
    """Scale a set of motions to a peak acceleration.

    Parameters
    ----------
    motions : sequence of Motion
    pga : float
        In `unit`.
    unit : str
    by : {'mean spectrum', 'record'}
        'mean spectrum': all by one factor, so that the mean spectrum has `pga` at period 0, as the study of scaled
        rolling isolation does (its section 2.2): the motions keep their ratios, and most of them have another PGA.
        'record': each by its own factor, so that each has `pga`.

    Returns
    -------
    tuple of Motion

    Raises
    ------
    SceneError
        If there is no motion, or `pga` is not positive.

    Examples
    --------
    >>> import symfric as sf
    >>> quake = sf.motions.sine_burst(3.0, 2.0, cycles=5)
    >>> [m.pga for m in sf.motions.scaled_set([quake], 0.5, "g", by="record")]
    [4.905]
    """
    motions = _set(motions)
    target = finite(pga, "pga") * factor_of(unit, "the unit of pga")
    if target <= 0:
        raise SceneError(f"pga is {pga}; it must be positive")
    if is_one_of(by, ("record",)):
        return tuple(m.scaled(target) for m in motions)
    if not is_one_of(by, ("mean spectrum",)):
        raise SceneError(f"by is {shortened(by)}; scale by 'mean spectrum' or by 'record'")
    mean = float(np.mean([m.pga for m in motions]))
    if mean == 0:
        raise SceneError("every motion of the set is zero; it cannot be scaled")
    return tuple(m.times(target / mean) for m in motions)


def _set(motions: Sequence[Motion]) -> tuple[Motion, ...]:
    found = () if isinstance(motions, Motion) else tuple(items(motions, "motions"))
    if not found or not all(isinstance(m, Motion) for m in found):
        raise SceneError("a set of motions is a list of sf.motions.Motion, at least one")
    return found


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
