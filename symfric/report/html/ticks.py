"""Tick labels of axes."""

from matplotlib.ticker import ScalarFormatter


class Ticks(ScalarFormatter):
    """Tick formatter that typesets only the power of ten as mathematics; typesetting every number is much slower."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return super().__call__(x, pos).removeprefix(r"$\mathdefault{").removesuffix("}$")
