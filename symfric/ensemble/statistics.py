"""Statistics of a sweep over cases: probabilities with their standard errors, means and quantiles."""

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of
from symfric.model.symbols import finite, numbers_of, shortened
from symfric.spelling import spelt

if TYPE_CHECKING:
    import xarray as xr

CASE, REPEAT = "case", "repeat"
FAILED = "lost"


@spelt
def probability(
    values: "xr.DataArray", *, above: float | None = None, below: float | None = None, over: str = CASE
) -> "xr.Dataset":
    """Return the probability that an output of a sweep lies above or below a limit, with its standard error.

    Parameters
    ----------
    values : xarray.DataArray
        An output of a sweep over a `CaseTable`; cases that failed (NaN) do not count.
    above, below : float
        One of them, or both for a range: ``values > above`` and ``values < below``.
    over : str
        Dimension of the cases.

    Returns
    -------
    xarray.Dataset
        ``probability``, ``standard_error``, ``low`` and ``high`` (an interval of 95 %), ``cases`` that count and
        ``lost`` ones, over the other dimensions.

    Raises
    ------
    SceneError
        If there is no limit or no such dimension.

    Notes
    -----
    For one draw the error is that of independent cases, ``sqrt(p (1 - p)/n)``, and the interval that of Wilson (1927),
    which holds at p = 0 too; for Sobol points and Latin hypercubes both are on the safe side. For several independent
    draws (``sf.draw(..., repeats=)``) the error is that of the mean of their probabilities, ``s/sqrt(repeats)``.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=60.0)
    >>> cases = sf.CaseTable({"v_b": np.linspace(0.3, 0.6, 31)})
    >>> found = sf.sweep(scene.wanting({"half": sf.HalfRange(scene.system.q[0])}), cases)
    >>> float(sf.probability(found["half"], above=0.3).probability.round(3))
    0.387
    """
    import xarray as xr

    array = _array(values, over)
    if above is None and below is None:
        raise SceneError("give a limit: above=..., below=..., or both")
    there: Any = np.isfinite(array)
    hit = there.copy()
    if above is not None:
        hit &= array > finite(above, "above")
    if below is not None:
        hit &= array < finite(below, "below")
    n = there.sum(over)
    part = hit.sum(over) / n.where(n > 0)
    error = _error(hit.where(there), part * (1 - part), n, over)
    low, high = interval(part, n)
    estimate = {"probability": part, "standard_error": error, "low": low, "high": high}
    return xr.Dataset({**estimate, "cases": n, FAILED: array.sizes[over] - n})


def interval(part: Any, n: Any) -> tuple[Any, Any]:
    """Return the ends of Wilson's interval of 95 % of a probability, found as a part of n independent cases."""
    z = 1.959963984540054
    middle = (part + z**2 / (2 * n)) / (1 + z**2 / n)
    reach = z * np.sqrt(part * (1 - part) / n + z**2 / (4 * n**2)) / (1 + z**2 / n)
    return middle - reach, middle + reach


@spelt
def spread(
    found: "xr.Dataset | xr.DataArray", quantiles: Sequence[float] = (0.05, 0.5, 0.95), *, over: str = CASE
) -> "xr.Dataset":
    """Return mean, standard deviation and quantiles of the outputs of a sweep over its cases.

    Parameters
    ----------
    found : xarray.Dataset or DataArray
        Result of a sweep over a `CaseTable`, or one of its outputs; cases that failed (NaN) do not count.
    quantiles : sequence of float
        Between 0 and 1.
    over : str
        Dimension of the cases.

    Returns
    -------
    xarray.Dataset
        For every output ``mean``, ``standard_error`` of the mean, ``deviation`` and ``quantiles`` along ``quantile``;
        several outputs make a dimension ``output``. ``lost`` counts cases that failed.

    Raises
    ------
    SceneError
        If a quantile is out of range, or there is no such dimension.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=60.0)
    >>> found = sf.sweep(scene.wanting({"top": sf.Max(scene.system.q[0])}), sf.CaseTable({"v_b": [0.1, 0.15, 0.2]}))
    >>> sf.spread(found["top"], [0.5])["quantiles"].values.round(4).tolist()
    [0.5248]
    """
    import xarray as xr

    levels = numbers_of(quantiles, "quantiles")
    if levels.ndim != 1 or not levels.size or not np.all((levels >= 0) & (levels <= 1)):
        raise SceneError(f"quantiles is {shortened(quantiles)}; give numbers between 0 and 1")
    if isinstance(found, xr.Dataset):
        outputs = [n for n, v in found.data_vars.items() if n != "status" and v.dtype.kind == "f" and over in v.dims]
        if not outputs:
            raise SceneError(f"no output has the dimension {shortened(over)}; sweep over sf.CaseTable")
        parts = [spread(found[n], quantiles, over=over) for n in outputs]
        return xr.concat(parts, xr.DataArray(outputs, dims="output", name="output"), join="outer")
    array = _array(found, over)
    with warnings.catch_warnings():  # where no case has a number, the results have none
        warnings.simplefilter("ignore", RuntimeWarning)
        return _spread(array, levels, over)


def _spread(array: "xr.DataArray", levels: np.ndarray, over: str) -> "xr.Dataset":
    import xarray as xr

    there: Any = np.isfinite(array)
    n = there.sum(over)
    deviation = array.std(over, ddof=1)
    return xr.Dataset(
        {
            "mean": array.mean(over),
            "standard_error": _error(array, deviation**2, n, over),
            "deviation": deviation,
            "quantiles": array.quantile(levels, over),
            FAILED: array.sizes[over] - n,
        }
    )


def _array(values: Any, over: str) -> "xr.DataArray":
    import xarray as xr

    if not isinstance(values, xr.DataArray):
        raise SceneError(f"{type(values).__name__} is no output of a sweep; give found['name'], an xarray.DataArray")
    if not is_one_of(over, values.dims):
        raise SceneError(
            f"the output has no dimension {shortened(over)} but {', '.join(map(str, values.dims))}; "
            "sweep over sf.CaseTable"
        )
    if not values.sizes[over]:
        raise SceneError(f"the output has no entry along {shortened(over)}; sweep over at least one case")
    return values


def _error(array: Any, variance: Any, n: Any, over: str) -> Any:
    """Return the standard error of a mean: of independent draws if there are several, else of independent cases."""
    if REPEAT in array.coords and np.unique(array[REPEAT].values).size > 1:
        means = array.groupby(REPEAT).mean(over)
        return means.std(REPEAT, ddof=1) / np.sqrt(means.sizes[REPEAT])
    return np.sqrt(variance / n)
