"""Cases of uncertain parameters: a table of values, or draws from distributions."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of, whole
from symfric.model.symbols import Key, name_of, numbers_of, shortened
from symfric.spelling import spelt

METHODS = ("sobol", "latin", "random")
MOST = 10_000_000  # cases


@dataclass(frozen=True, eq=False)
class CaseTable:
    """A table of parameter sets, one case for each row; an axis of a sweep.

    Parameters
    ----------
    columns : mapping of symbol or name to array_like, shape (n,)
        Values of each parameter.
    repeat : array_like of int, shape (n,), optional
        To which of several independent draws each case belongs; all to one unless given.

    Attributes
    ----------
    columns : dict of str to ndarray
    repeat : ndarray of int, shape (n,)

    Raises
    ------
    SceneError
        If a value is not finite, or the columns differ in length.

    Examples
    --------
    >>> import symfric as sf
    >>> cases = sf.CaseTable({"v_b": [0.1, 0.2, 0.3], "beta": [0.01, 0.02, 0.02]})
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0)
    >>> found = sf.sweep(scene.wanting({"half": sf.HalfRange(scene.system.q[0])}), cases)
    >>> found["half"].dims, found["v_b"].values.tolist()
    (('case',), [0.1, 0.2, 0.3])
    """

    columns: Mapping[Key, Any]
    repeat: Any = None

    def __post_init__(self) -> None:
        if not isinstance(self.columns, Mapping) or not self.columns:
            raise SceneError(
                "the columns of a CaseTable must name at least one parameter, such as {'mu_s': [0.3, 0.4]}"
            )
        columns: dict[str, np.ndarray] = {}
        for key, values in self.columns.items():
            name = name_of(key)
            if name in columns:
                raise SceneError(f"{name} is given twice in CaseTable, as a symbol and by name")
            columns[name] = row_of(values, name)
        sizes = {n: v.size for n, v in columns.items()}
        if len(set(sizes.values())) > 1:
            raise SceneError(
                f"the columns of a CaseTable have different lengths: {', '.join(f'{n} {k}' for n, k in sizes.items())}"
            )
        size = next(iter(sizes.values()))
        group = np.zeros(size, dtype=np.int64) if self.repeat is None else np.array(self.repeat)
        if group.shape != (size,) or group.dtype.kind not in "iu":
            raise SceneError(
                f"repeat of CaseTable has shape {group.shape}; give a whole number for each of {size} cases"
            )
        object.__setattr__(self, "columns", columns)
        object.__setattr__(self, "repeat", group)

    def __len__(self) -> int:
        return int(self.repeat.size)

    def __getitem__(self, key: Key) -> np.ndarray:
        name = name_of(key)
        if name not in self.columns:
            raise SceneError(f"{name} is no column of the cases; there are {', '.join(map(str, self.columns))}")
        return cast(np.ndarray, self.columns[name])

    def __repr__(self) -> str:
        return f"CaseTable({len(self)} of {', '.join(map(str, self.columns))})"


def row_of(values: Any, name: str) -> np.ndarray:
    """Return the values of a parameter as a one-dimensional array of finite numbers."""
    try:
        row = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise SceneError(f"the values of {name} are not numbers; give a sequence of numbers") from None
    if row.ndim != 1 or not row.size:
        raise SceneError(f"the values of {name} have shape {row.shape}; give a sequence of at least one")
    if not np.all(np.isfinite(row)):
        raise SceneError(f"value {int(np.flatnonzero(~np.isfinite(row))[0])} of {name} is not finite")
    return row


@spelt
def draw(
    distributions: Mapping[Key, Any],
    number: int,
    *,
    seed: int = 0,
    method: Literal["sobol", "latin", "random"] = "sobol",
    repeats: int = 1,
    correlation: Any = None,
) -> CaseTable:
    """Draw cases from distributions of parameters.

    Parameters
    ----------
    distributions : mapping of symbol or name to frozen scipy.stats distribution
        Such as ``scipy.stats.norm(0.4, 0.02)`` or ``scipy.stats.uniform(0.1, 0.2)``.
    number : int
        Cases of each repeat; of Sobol points best a power of two.
    seed : int
        The same seed draws the same cases.
    method : {'sobol', 'latin', 'random'}
        Scrambled Sobol points, a Latin hypercube (both by `scipy.stats.qmc`), or independent points.
    repeats : int
        Independent draws of `number` cases; from their scatter `probability` and `spread` tell the error of Sobol
        points and Latin hypercubes, which is smaller than that of independent ones. Ten or more tell it well.
    correlation : array_like, shape (k, k), optional
        Of the normal scores of the k parameters (a Gaussian copula); none unless given.

    Returns
    -------
    CaseTable

    Raises
    ------
    SceneError
        If an argument is wrong.

    Notes
    -----
    Every parameter is the quantile of its distribution at its coordinate of the points. A. B. Owen, Journal of
    Complexity 14 (1998) 466, on scrambled points; with a correlation C the coordinates are first mapped to normal
    scores, multiplied by the Cholesky factor of C and mapped back.

    Examples
    --------
    >>> import scipy.stats
    >>> import symfric as sf
    >>> cases = sf.draw({"mu": scipy.stats.uniform(0.2, 0.1)}, 8, seed=1)
    >>> len(cases), bool(0.2 <= cases.columns["mu"].min() <= cases.columns["mu"].max() <= 0.3)
    (8, True)
    """
    from scipy.stats import qmc  # slow to import

    if not isinstance(distributions, Mapping) or not distributions:
        raise SceneError("distributions must name at least one parameter, such as {'mu': scipy.stats.norm(0.3, 0.02)}")
    names = [name_of(k) for k in distributions]
    laws = list(distributions.values())
    for name, law in zip(names, laws, strict=True):
        try:
            middle = float(law.ppf(0.5))
        except (AttributeError, TypeError, ValueError):
            middle = np.nan
        if not np.isfinite(middle):
            raise SceneError(
                f"the distribution of {name} is {law!r}; give a frozen one of scipy.stats, with its numbers"
            )
    for what, value in (("number", number), ("repeats", repeats)):
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
            raise SceneError(f"{what} is {shortened(value)}; give a whole number, at least 1")
    if number * repeats > MOST:
        raise SceneError(f"{number} cases {repeats} times are more than {MOST}; draw fewer")
    if not is_one_of(method, METHODS):
        raise SceneError(f"method is {shortened(method)}; it is one of {', '.join(map(repr, METHODS))}")
    factor = None if correlation is None else _factor(correlation, len(names))
    seeds = np.random.SeedSequence(whole(seed, "seed", 0)).spawn(repeats)
    parts = []
    for own in seeds:
        rng = np.random.default_rng(own)
        if method == "sobol":
            points = qmc.Sobol(len(names), seed=rng).random_base2(int(np.ceil(np.log2(number))))[:number]
        elif method == "latin":
            points = qmc.LatinHypercube(len(names), seed=rng).random(number)
        else:
            points = rng.random((number, len(names)))
        parts.append(points if factor is None else _correlated(points, factor))
    points = np.clip(np.concatenate(parts), 2.0**-54, 1 - 2.0**-53)
    columns = {n: np.asarray(law.ppf(u), dtype=float) for n, law, u in zip(names, laws, points.T, strict=True)}
    return CaseTable(columns, np.repeat(np.arange(repeats), number))


def _factor(correlation: Any, size: int) -> np.ndarray:
    """Return the Cholesky factor of a correlation matrix."""
    matrix = numbers_of(correlation, "correlation")
    if matrix.shape != (size, size) or not np.allclose(matrix, matrix.T) or not np.allclose(np.diag(matrix), 1.0):
        raise SceneError(
            f"correlation has shape {matrix.shape}; give a symmetric ({size}, {size}) with ones on its diagonal"
        )
    try:
        return np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        raise SceneError("correlation is not positive definite; no distribution has it") from None


def _correlated(points: np.ndarray, factor: np.ndarray) -> np.ndarray:
    from scipy.special import ndtr, ndtri

    return np.asarray(ndtr(ndtri(np.clip(points, 2.0**-54, 1 - 2.0**-53)) @ factor.T))
