"""Numbers along an axis."""

from matplotlib.ticker import ScalarFormatter


class Ticks(ScalarFormatter):
    """Set the power of ten beside an axis as mathematics, but not every number on it, which takes far longer."""

    def __call__(self, x, pos=None):
        return super().__call__(x, pos).removeprefix(r"$\mathdefault{").removesuffix("}$")
