"""The study of scaled rolling isolation: responses for every damping, friction, model, motion and intensity."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from symfric.errors import SceneError
from symfric.model.scenes.isolator import patched_floor, rolling_isolator
from symfric.motions import scaled_set
from symfric.motions.motion import Motion
from symfric.solve.exact.record.program import March, Marcher
from symfric.theory.scaling import Factors, factors, returned_ratio

if TYPE_CHECKING:
    import xarray as xr

G = 9.81  # m/s^2
MASS = 3e5  # kg
DAMPINGS = (1e5, 2e5)  # N s/m
INTENSITIES = (0.05, 0.1, 0.2, 0.4, 0.8)  # g
SCALES = (4, 7, 10, 13, 16, 19)
MASS_OF_TABLE_2 = 0.008163
RESPONSES = {  # outputs of the scene, and the field of `Factors` that converts each to full scale
    "peak_acceleration": "acceleration",
    "peak_velocity": "velocity",
    "peak_displacement": "length",
    "residual": "length",
    "residual_end_of_record": "length",
}
Profile: TypeAlias = float | tuple[float, float] | tuple[np.ndarray, np.ndarray]  # as `rolling_isolator` takes it
_RUN_OUT = 20.0  # time after the record, s of the prototype


@dataclass(frozen=True)
class Model:
    """A model of the prototype.

    Attributes
    ----------
    name : str
    factors : Factors
    scaled_gravity : bool
        Whether gravity is scaled too; on a shaking table it is not.
    """

    name: str
    factors: Factors
    scaled_gravity: bool = True

    @property
    def gravity(self) -> float:
        """Factor of gravity."""
        return self.factors.gravity_1 if self.scaled_gravity else self.factors.gravity_2


def models(scales: Sequence[float] = SCALES) -> tuple[Model, ...]:
    """Return the prototype, and for each scale the models of tables 1 and 2 with scaled and with unscaled gravity."""
    built = [Model("prototype", factors(1.0))]
    for table, mass in (("table 1", None), ("table 2", MASS_OF_TABLE_2)):
        for scaled in (True, False):
            word = "scaled g" if scaled else "g"
            built += [Model(f"{table}, 1:{L}, {word}", factors(float(L), mass=mass), scaled) for L in scales]
    return tuple(built)


def frictions(seed: int = 19, cells: int = 81) -> dict[str, Profile]:
    """Return the eight friction profiles: cases 1 to 3 of an even floor, and five concave ones.

    Cases 2 and 3 are drawn, because the source gives range, mean and deviation only; the floor is 4 m long,
    and u = 0 lies in the middle of a cell.
    """
    even: dict[str, Profile] = {
        "case 1": 0.005,
        "case 2": patched_floor(4.0, cells, 0.005, 0.000815, 0.001, seed=seed),
        "case 3": patched_floor(4.0, cells, 0.005, 0.002355, 0.004, seed=seed + 1),
    }
    return even | {f"R = {k / 100:g} 1/m": (0.005, k / 100) for k in range(1, 6)}


def rolling_study(
    motions: Sequence[Motion],
    *,
    intensities: Sequence[float] = INTENSITIES,
    dampings: Sequence[float] = DAMPINGS,
    profiles: Mapping[str, Profile] | None = None,
    against: Sequence[Model] | None = None,
    by: str = "mean spectrum",
    scaled_positions: bool = False,
    jobs: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> "xr.Dataset":
    """Run every combination, 2 x 8 x 25 x 20 x 5 = 40 000 in the source, and compare the models with the prototype.

    Parameters
    ----------
    motions : sequence of Motion
    intensities : sequence of float
        Peak accelerations, g.
    dampings : sequence of float
        N s/m, of the prototype.
    profiles : mapping of str to profile, optional
        As `sf.scenes.rolling_isolator` takes them; those of `frictions` unless given.
    against : sequence of Model, optional
        The first one is the prototype; those of `models` unless given.
    by : {'mean spectrum', 'record'}
        How the motions are scaled, see `sf.motions.scaled_set`; the source takes the mean spectrum.
    scaled_positions : bool
        Whether the cells of an uneven floor shrink with the model, which the source proposes as a cure.
    jobs : int, optional
        Threads; as many as there are processors unless given.
    progress : callable, optional
        Called with the number of finished cases and of all.

    Returns
    -------
    xarray.Dataset
        The responses and, under ``ratio_...``, the returned ratios (RR) over damping, friction, model, motion and pga;
        ``status`` as `sf.Status`, NaN where it is not OK.

    Raises
    ------
    SceneError
        If something is wrong with the motions or a number.
    """
    import xarray as xr

    profiles = frictions() if profiles is None else dict(profiles)
    against = models() if against is None else tuple(against)
    sets = [scaled_set(motions, level, "g", by=by) for level in intensities]
    scale = np.array([[m.pga / raw.pga if raw.pga else 0.0 for m, raw in zip(s, motions, strict=True)] for s in sets])
    shape = len(dampings), len(profiles), len(against), len(motions), len(intensities)
    responses = {name: np.full(shape, np.nan) for name in RESPONSES}
    status = np.full(shape, -1, dtype=np.int8)
    tasks = [(f, k) for f in range(len(profiles)) for k in range(len(motions))]
    floors = list(profiles.values())
    marchers = [Marcher(rolling_isolator(C=1.0, m=1.0, motion=motions[0], profile=floor)) for floor in floors]

    def work(f: int, k: int) -> None:
        march = marchers[f].under(motions[k].samples)
        for i, C in enumerate(dampings):
            for j, model in enumerate(against):
                for n in range(len(intensities)):
                    case = _values(model, C, scale[n, k], floors[f], scaled_positions)
                    at = i, f, j, k, n
                    status[at] = _run(marchers[f], march, case, model, motions[k], responses, at)

    done, size = 0, len(dampings) * len(against) * len(intensities)
    with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
        for future in as_completed([pool.submit(work, *task) for task in tasks]):
            future.result()
            done += size
            if progress is not None:
                progress(done, size * len(tasks))
    axes = ("damping", "friction", "model", "motion", "pga")
    data = {name: (axes, values) for name, values in responses.items()} | {"status": (axes, status)}
    data |= {f"ratio_{name}": (axes, ratio) for name, ratio in _ratios(responses, against)}
    coords = {
        "damping": list(dampings),
        "friction": list(profiles),
        "model": [m.name for m in against],
        "motion": [m.name for m in motions],
        "pga": list(intensities),
    }
    return xr.Dataset(data, coords, {"scaled_by": by, "scaled_positions": int(scaled_positions)})


def _values(model: Model, C: float, amplitude: float, profile: Profile, scaled_positions: bool) -> dict[str, float]:
    """Return the parameters of a case by name."""
    by = model.factors
    case = {"C": C * by.damping, "m": MASS * by.mass, "g": G * model.gravity, "amplitude": amplitude * by.acceleration}
    if isinstance(profile, float | int):
        return case | {"mu": float(profile)}
    if all(np.ndim(part) == 0 for part in profile):
        return case | {"mu0": float(profile[0]), "R": float(profile[1]) * by.friction_increment}
    return case | {"stretch": by.length if scaled_positions else 1.0}


def _run(
    marcher: Marcher,
    march: March,
    case: dict[str, float],
    model: Model,
    motion: Motion,
    responses: dict[str, np.ndarray],
    at: tuple[int, ...],
) -> int:
    """Run one case and store its responses; return its status."""
    time = model.factors.time
    p = np.array([case[name] for name in marcher.parameters])
    ends = {"residual": (motion.duration + _RUN_OUT) * time, "residual_end_of_record": motion.duration * time}
    times = {marcher.row[name]: end for name, end in ends.items()}
    status, total = march.run(p, motion.dt * time, ends["residual"], times)
    if status == 0:
        for name, values in responses.items():
            row = total[marcher.row[name]]
            values[at] = row[2] if name in ends else max(-row[0], row[1])
    return status


def _ratios(responses: dict[str, np.ndarray], against: Sequence[Model]) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the returned ratio of every response, relative to the first model."""
    for name, field in RESPONSES.items():
        factor = np.array([getattr(m.factors, field) for m in against])[None, None, :, None, None]
        yield name, returned_ratio(responses[name], responses[name][:, :, :1], factor)


def synthetic_set(n: int = 20, seed: int = 19) -> tuple[Motion, ...]:
    """Return n artificial motions for one target spectrum, for a study without records."""
    from symfric.motions.synthetic import eurocode8, synthetic

    if n < 1:
        raise SceneError(f"{n} motions; give at least one")
    periods = np.geomspace(0.05, 4.0, 40)
    return tuple(synthetic(periods, eurocode8(periods), seed=seed + k) for k in range(n))
