"""Friction examples of the Modelica Standard Library 4.0.0, with some of the numbers published for them.

Scenes: the models Friction and CoupledClutches of Modelica.Mechanics.Rotational.Examples, Brake and Friction of
Modelica.Mechanics.Translational.Examples (of the last the mass on a table; its stops strike). Numbers: the reference
results of the Modelica Association for these models, https://github.com/modelica/MAP-LIB_ReferenceResults, commit
d6a2b9b, computed by Dymola 2020x with DASSL; here at some of their 3000 to 10000 instants.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from symfric.model.scene import Scene
from symfric.scenefile import read_scene_text
from symfric.solve.routes import prepare
from symfric_evidence.bench.friction_table import table_scene

_TOLERANCE = 1e-12
Row = tuple[float, ...]  # time, and the signals


@dataclass(frozen=True)
class PublishedModel:
    """One example with its published numbers.

    Attributes
    ----------
    name : str
        Of the model.
    scene : callable
    signals : dict of str to (dict of str to float)
        Names in the library, and the sum of states that each is.
    rows : tuple of tuple of float
    """

    name: str
    scene: Callable[[], Scene]
    signals: dict[str, dict[str, float]]
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class PublishedDifference:
    """Largest difference of one signal from its published numbers.

    Attributes
    ----------
    model, signal : str
    difference : float
    time : float
        Where it is.
    size : float
        Largest magnitude of the signal there.
    """

    model: str
    signal: str
    difference: float
    time: float
    size: float


@cache
def scene_of(name: str) -> Scene:
    """Return the scene of a file of the folder `modelica`."""
    text = files("symfric_evidence.bench").joinpath("modelica", f"{name}.toml").read_text(encoding="utf-8")
    return read_scene_text(text).scene


def compared() -> tuple[PublishedDifference, ...]:
    """Run all models and compare them with the published numbers."""
    found = []
    for model in MODELS:
        run = prepare(model.scene(), _TOLERANCE).run().checked()
        table = np.array(model.rows)
        states = dict(zip(run.names, run(table[:, 0]), strict=True))
        for column, (signal, parts) in enumerate(model.signals.items(), 1):
            own = sum(factor * states[name] for name, factor in parts.items())
            off = np.abs(own - table[:, column])
            worst = int(np.argmax(off))
            size = float(np.max(np.abs(table[:, column])))
            found.append(PublishedDifference(model.name, signal, float(off[worst]), float(table[worst, 0]), size))
    return tuple(found)


MODELS = (
    PublishedModel(
        "Rotational.Friction",
        lambda: scene_of("clutch_and_brake"),
        {
            "inertia3.w": {"w3": 1.0},
            "clutch.w_rel": {"w2": 1.0, "w3": -1.0},
            "spring.phi_rel": {"phi1": 1.0, "phi2": -1.0},
            "spring.w_rel": {"w1": 1.0, "w2": -1.0},
        },
        (
            (0.1, 96.94780585017186, -3.607692904648773, -0.488396519017762, 3.223117624077344),
            (0.25, 92.83878071791597, 1.2525712472458438e-10, 0.36973727822613256, 4.197921979253087),
            (0.45, 94.66950881231898, 1.2525712472458438e-10, -0.3122883771886069, 1.3766282910078935),
            (0.55, 89.09124312142542, -8.509167959891544, -0.7276944693672891, -19.132594468232952),
            (0.6, 85.09124312142549, -68.0393984522847, -0.7641206332194481, 11.57414754877984),
            (0.7, 77.0912431214253, -79.0756020447406, -0.43666337497873137, 1.9843589233150944),
            (1.0, 53.091243121425364, -53.20438437260743, -0.5036796806906447, 0.11314125118184612),
            (1.5, 13.091243121416658, -13.09109906934314, -0.4999737811750614, -0.00014405207354626718),
            (2.0, 4.449327642289485, 9.816240261774616e-15, 0.24140466953008866, -4.449327642289526),
            (3.0, 2.289890998276737, 9.816240261774616e-15, 0.1959851558674667, -2.289890998276777),
        ),
    ),
    PublishedModel(
        "Rotational.CoupledClutches",
        lambda: scene_of("coupled_clutches"),
        {
            "J1.w": {"w1": 1.0},
            "clutch1.w_rel": {"w2": 1.0, "w1": -1.0},
            "clutch2.w_rel": {"w3": 1.0, "w2": -1.0},
            "clutch3.w_rel": {"w4": 1.0, "w3": -1.0},
        },
        (
            (0.2, 8.020963579105223, -6.041952337534431, -1.9790112415707943, 4.762418186090023e-16),
            (0.5, 5.959117237338108, -2.281670967462555, -2.6774462698755555, -0.9999999999999973),
            (0.7, 4.505014258021974, -1.3734648417495323, -0.13154941627241934, -3.000000000000017),
            (0.85, 3.4651235125278843, -0.03856011264748355, 6.1896017466106125e-16, -3.426563399880401),
            (1.0, 3.0000306716392005, 1.517039982255175e-12, 6.1896017466106125e-16, -2.000030671640711),
            (1.1, 3.3880203290175657, -0.763685719828761, 6.1896017466106125e-16, -0.6243346091887829),
            (1.25, 2.928722754923056, -0.4655151540253682, 6.1896017466106125e-16, 7.973578952751564e-12),
            (1.5, 3.247034565240657, -0.7838269643429722, 6.1896017466106125e-16, 7.973578952751564e-12),
        ),
    ),
    PublishedModel(
        "Translational.Brake",
        lambda: scene_of("brake"),
        {
            "mass1.s": {"s": 1.0},
            "mass1.v": {"v": 1.0},
        },
        (
            (0.1, 0.1, 1.0),
            (0.5, 0.4199999999937338, 0.6),
            (1.0, 0.5949999999930818, 0.09999999999999998),
            (1.1, 0.5999999999930116, -1.1102230246251565e-16),
            (2.0, 0.5999999999930116, -1.1102230246251565e-16),
        ),
    ),
    PublishedModel(
        "Translational.Friction",
        table_scene,
        {
            "mass.s": {"s": 1.0},
            "mass.v": {"v": 1.0},
        },
        (
            (0.5, 0.005449102291245561, 0.2041399071823524),
            (1.0, 1.6992808025567276, 6.901295071038167),
            (1.5, 6.40254989717778, 10.95194806957746),
            (2.0, 11.464761161967802, 8.051272422618531),
            (2.5, 13.414311076709513, -0.1583835045637863),
            (3.0, 11.757209675639833, -6.840479081632969),
            (3.5, 7.077838450406627, -10.915070728509887),
            (4.0, 2.030139711209078, -8.028894283955886),
            (4.5, 0.0887850585208505, 0.15998970204076465),
            (5.0, 1.7472367279313534, 6.84272940635481),
        ),
    ),
)
