"""Figures and tables of the sources by name: each computes, draws and says what it found."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from symfric.errors import SceneError
from symfric.model.names import nearest


@dataclass(frozen=True)
class Made:
    """A reproduced figure or table.

    Attributes
    ----------
    figure : matplotlib Figure or None
    text : str
        A table for reading; empty if there is none.
    data : object
        Plain data for JSON, or None.
    """

    figure: object = None
    text: str = ""
    data: object = None


@dataclass(frozen=True)
class Reproduction:
    """How a figure or table is made.

    Attributes
    ----------
    caption : str
    make : callable
        ``make(motions, progress) -> Made``; motions may be None.
    takes_records : bool
        Whether motions make a difference.
    """

    caption: str
    make: Callable[[Sequence | None, Callable[[float], None]], Made] = field(repr=False)
    takes_records: bool = False


def reproductions() -> dict[str, Reproduction]:
    """Return everything that can be made again, by name."""
    from symfric.report.slide_figures import FIGURES as SLIDES
    from symfric.report.younes_ashour import FIGURES as DECAYS

    found = {f"younes-{name}": Reproduction(_first_line(make), _decay(make)) for name, make in DECAYS.items()}
    found["younes-claims"] = Reproduction("What the text claims, and which readings of it hold.", _claims)
    found |= {name: Reproduction(figure.caption, _slide(figure)) for name, figure in SLIDES.items()}
    caption = "Returned ratios of scaled models, from 40 000 runs; --records names a folder of AT2 files."
    found["rolling-table-3"] = Reproduction(caption, _table_3, takes_records=True)
    return found


def chosen(names: Sequence[str]) -> dict[str, Reproduction]:
    """Return those that are named, all unless any is.

    Raises
    ------
    SceneError
        On an unknown name, with the nearest known one.
    """
    known = reproductions()
    unknown = next((name for name in names if name not in known), None)
    if unknown is not None:
        raise SceneError(f"no figure {unknown!r}{nearest(unknown, known)}")
    return {name: known[name] for name in names} if names else known


def _first_line(make: Callable) -> str:
    return (make.__doc__ or "").strip().splitlines()[0]


def _decay(make: Callable) -> Callable:
    def made(_motions, _progress) -> Made:
        from symfric.report.younes_ashour import draw

        return Made(draw(make()))

    return made


def _slide(figure) -> Callable:
    def made(_motions, _progress) -> Made:
        import numpy as np

        return Made(np.ravel(figure.draw(figure.data()))[0].figure)

    return made


def _claims(_motions, _progress) -> Made:
    from symfric.report.younes_ashour import claims_table

    rows = claims_table()
    lines = [f"{r['where']}: {r['claim']}\n    {r['verdict']}; {r['reading']}: {r['holds']}" for r in rows]
    return Made(text="\n".join(lines) + "\n", data=rows)


def _table_3(motions, progress) -> Made:
    from symfric.report.rolling import plot_table_3, table_3

    table = table_3(motions, lambda done, of: progress(done / of))
    return Made(plot_table_3(table).flat[0].figure, table.text(), table.rows())
