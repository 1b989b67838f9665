"""Registry of the reproduced figures and tables by name, and of those that are not reproduced."""

import re
from collections.abc import Sequence
from typing import Any

from symfric.errors import SceneError
from symfric.model.symbols import nearest
from symfric_evidence.sources.registry import SOURCES, Entry

NOT_MADE = {
    "handbook-19.14": "measured damping of structures against amplitude; no data is printed",
    "handbook-19.18": "measured friction of a pair of spur gears; no data is printed, see handbook-19.19",
    "handbook-table-19.6": "damping ratios a code suggests; nothing to compute",
    "younes-2": "layout of the test rig; nothing to compute",
}


def reproductions() -> dict[str, Entry[Any]]:
    """Return all registry entries by name, ordered by source and number."""
    from symfric_evidence.sources import handbook, sketches, thomsen, younes_ashour
    from symfric_evidence.sources.guida import phase_planes
    from symfric_evidence.sources.guida import slide_figures as guida
    from symfric_evidence.sources.rolling import scaling_figures as rolling

    modules = (sketches, thomsen, handbook, phase_planes, guida, younes_ashour, rolling)
    entries = {name: entry for module in modules for name, entry in module.FIGURES.items()}
    return dict(sorted(entries.items(), key=lambda item: _order(item[0])))


def _order(name: str) -> tuple[int, int, list[int], str]:
    """Sort by source, figures by number, then tables, then what the sources do not have."""
    source, _, rest = name.partition("-")
    numbers = [int(n) for n in re.findall(r"\d+", rest)]
    kind = 0 if rest[0].isdigit() else 1 if rest.startswith("table") else 2
    return list(SOURCES).index(source), kind, numbers, rest


def chosen(names: Sequence[str]) -> dict[str, Entry[Any]]:
    """Return the named entries, or all if no name is given.

    Raises
    ------
    SceneError
        On an unknown name, with the nearest known one, or why it is not made.
    """
    known = reproductions()
    for name in names:
        if name in NOT_MADE:
            raise SceneError(f"{name} is not made: {NOT_MADE[name]}")
        if name not in known:
            raise SceneError(f"no figure {name!r}{nearest(name, known)}")
    return {name: known[name] for name in names} if names else known
