"""Where the degrees of freedom of a structure are, for pictures of its shapes."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symfric.errors import SceneError
from symfric.files import read_regular
from symfric.model.symbols import nearest, shorten

_HEADS = (["name", "x"], ["name", "x", "y"], ["name", "x", "y", "direction"])
_MOST = 10_000_000  # bytes of a table of places


@dataclass(frozen=True, eq=False)
class Places:
    """Places of the degrees of freedom in a plane or along a line.

    Attributes
    ----------
    at : ndarray, shape (n, 1) or (n, 2)
        NaN where a place is not known.
    along : tuple of str
        "x" or "y", the direction in which a degree of freedom moves; "" for others, such as rotations.
    """

    at: np.ndarray
    along: tuple[str, ...]

    @property
    def plane(self) -> bool:
        """Whether nodes of a plane move in it, so that a shape can be drawn as a displaced one."""
        return self.at.shape[1] == 2 and any(self.along)

    def nodes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the places of nodes, shape (m, 2), and the degree of freedom of each in x and y, -1 for none."""
        at: list[np.ndarray] = []
        moves: list[list[int]] = []
        open_at: dict[
            tuple[float, float], int
        ] = {}  # the node of a place that lacks a direction: bodies may touch there
        for i, (place, way) in enumerate(zip(self.at, self.along, strict=True)):
            if not way or not np.all(np.isfinite(place)):
                continue
            key, slot = (float(place[0]), float(place[1])), "xy".index(way)
            node = open_at.get(key, -1)
            if node < 0 or moves[node][slot] >= 0:
                node = open_at[key] = len(at)
                at.append(place)
                moves.append([-1, -1])
            moves[node][slot] = i
        return np.array(at), np.array(moves)


def read_places(path: Path, names: Sequence[str], what: str) -> Places:
    """Read a table of places.

    Raises
    ------
    SceneError
        If it cannot be read, names what is no degree of freedom, or holds no number where one belongs.
    """
    try:
        data = read_regular(path, _MOST)
        if len(data) > _MOST:
            raise SceneError(f"{what}: {path.name} is larger than {_MOST // 1_000_000} MB")
        rows = [row for row in csv.reader(data.decode("utf-8-sig").splitlines()) if row]
    except UnicodeDecodeError:
        raise SceneError(f"{what}: {shorten(path.name, 60)} is not text; save it as UTF-8") from None
    except (OSError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{what}: {shorten(path.name, 60)} cannot be read ({shorten(reason, 60)})") from None
    head = [cell.strip().lower() for cell in rows[0]] if rows else []
    if head not in _HEADS:
        raise SceneError(f"{what}: the first line of {path.name} must be name,x or name,x,y or name,x,y,direction")
    width = min(len(head) - 1, 2)
    at, along, order = np.full((len(names), width), np.nan), [""] * len(names), {n: i for i, n in enumerate(names)}
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(head):
            raise SceneError(f"{what}: line {number} of {path.name} has {len(row)} cells; {len(head)} are needed")
        name = row[0].strip()
        if name not in order:
            known = nearest(name, names)
            raise SceneError(f"{what}: line {number}: no degree of freedom {shorten(name, 40)!r}{known}")
        try:
            place = [float(cell) for cell in row[1 : 1 + width]]
        except ValueError:
            place = [math.nan]
        if not all(map(math.isfinite, place)):
            raise SceneError(f"{what}: line {number} of {path.name} holds no finite numbers")
        at[order[name]] = place
        if len(head) == 4:
            along[order[name]] = _direction(row[3].strip(), f"{what}: line {number} of {path.name}")
    return Places(at, tuple(along))


def _direction(given: str, place: str) -> str:
    if given not in ("x", "y", ""):
        raise SceneError(f"{place}: the direction is {shorten(given, 20)!r}; it is x or y, or empty")
    return given
