"""The source's own fixed steps, section 2.4, on scaled models: what its scheme and its rounded factors return."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from symfric.motions import scaled_set
from symfric.motions.motion import Motion
from symfric.theory.scaling import Factors, factors, returned_ratio
from symfric_evidence.sources.rolling.study import INTENSITIES, MASS, RESPONSES, SCALES, G, Profile

FIELDS = {name: field for name, field in RESPONSES.items() if name != "residual_end_of_record"}
PRINTED = {  # of table 1, for 1:4 to 1:19; the other rows are whole numbers or fractions
    "mass": (0.0156, 0.00292, 0.001, 0.000455, 0.000244, 0.000146),
    "force": (0.0625, 0.0204, 0.01, 0.00592, 0.00391, 0.00277),
    "damping": (0.0625, 0.0204, 0.01, 0.00592, 0.00391, 0.00277),
    "time": (0.25, 0.143, 0.1, 0.0769, 0.0625, 0.0526),
}


def rounded_factors() -> tuple[Factors, ...]:
    """Return the factors of table 1 with the digits that are printed."""
    exact = [factors(float(L)) for L in SCALES]
    return tuple(replace(f, **{name: row[k] for name, row in PRINTED.items()}) for k, f in enumerate(exact))


def returned_by_steps(
    motions: Sequence[Motion],
    profile: Profile,
    by: Sequence[Factors],
    *,
    moved: bool = False,
    damping: float = 1e5,
    intensities: Sequence[float] = INTENSITIES,
) -> dict[str, np.ndarray]:
    """Return the ratios RR of models under gravity of the model, prototype and models both marched in fixed steps.

    Parameters
    ----------
    motions : sequence of Motion
    profile : float or (edges, values)
        Coefficient of friction, or cells of the floor, m.
    by : sequence of Factors
        The models.
    moved : bool
        Whether the cells shrink with the model.
    damping : float
        N s/m, of the prototype.
    intensities : sequence of float
        Peak accelerations, g, of the mean spectrum.

    Returns
    -------
    dict of str to ndarray, shape (model, motion, pga)
        By response; not a number where the response of the prototype is 0.

    Notes
    -----
    The step of a model is the record's step times its factor of time.
    """
    sets = [scaled_set(motions, level, "g") for level in intensities]
    length = max(m.samples.size for m in motions)
    ground = np.zeros((length, len(motions), len(intensities)))
    for k, level in enumerate(sets):
        for i, motion in enumerate(level):
            ground[: motion.samples.size, i, k] = motion.samples
    record = np.array([m.dt for m in motions])[:, None], np.array([m.samples.size for m in motions])[:, None]
    responses = _march(ground, *record, (factors(1.0), *by), damping, _floor(profile), moved)
    scale = {name: np.array([getattr(f, field) for f in by])[:, None, None] for name, field in FIELDS.items()}
    return {name: returned_ratio(responses[name][1:], responses[name][:1], scale[name]) for name in FIELDS}


def _floor(profile: Profile) -> Callable[[np.ndarray], np.ndarray]:
    """Return the coefficient of friction over the displacement."""
    if isinstance(profile, float | int):
        return lambda u: np.full_like(u, float(profile))
    edges, values = (np.asarray(part, dtype=float) for part in profile)
    return lambda u: values[np.searchsorted(edges[1:-1], u, side="right")]


def _march(
    a: np.ndarray,
    dt: np.ndarray,
    ends: np.ndarray,
    by: Sequence[Factors],
    damping: float,
    floor: Callable[[np.ndarray], np.ndarray],
    moved: bool,
) -> dict[str, np.ndarray]:
    """March all motions, intensities and models at once; a has shape (n, motion, pga), results (model, motion, pga).

    Explicit steps: the mass rolls while v_s is not v_e, and stops when the velocity left and the driving acceleration
    are both within the friction of one step.
    """

    def column(values: Sequence[float]) -> np.ndarray:
        return np.array(values, dtype=float)[:, None, None]

    time, scale, length = (column([getattr(f, name) for f in by]) for name in ("time", "acceleration", "length"))
    rate, g = column([damping * f.damping / (MASS * f.mass) for f in by]), column([G * f.gravity_1 for f in by])
    step, stretch = dt * time, length if moved else np.ones_like(length)
    u, w = (np.zeros((len(by), *a.shape[1:])) for _ in range(2))
    peaks = np.zeros((3, *u.shape))
    for k in range(a.shape[0] - 1):
        going = k < ends - 1
        now, friction = a[k] * scale, floor(u / stretch) * g
        rests = (w == 0.0) & (np.abs(now) <= friction)
        side = np.where(w != 0.0, np.sign(w), -np.sign(now))
        absolute = np.where(rests, 0.0, -side * friction - rate * w)
        peaks[0] = np.where(going, np.maximum(peaks[0], np.abs(absolute)), peaks[0])
        w = np.where(going & ~rests, w + (absolute - now) * step, w)
        u = np.where(going, u + w * step, u)
        limit = floor(u / stretch) * g
        stops = (np.abs(w - rate * w * step) <= limit * step) & (np.abs(a[k + 1] * scale + rate * w) <= limit)
        w = np.where(going & stops, 0.0, w)
        peaks[1:] = np.where(going, np.maximum(peaks[1:], np.abs([w, u])), peaks[1:])
    return dict(zip(FIELDS, (*peaks, u), strict=True))
