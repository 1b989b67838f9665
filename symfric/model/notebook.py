"""Tables of results for notebooks, made from `to_dict`."""

from collections.abc import Mapping

MOST = 12  # longest list whose numbers are shown; of longer ones, and of lists of results, only the length


def html_table(name: str, values: Mapping[str, object]) -> str:
    """Return an HTML table of a result's values; nested values carry the names of their parents.

    Parameters
    ----------
    name : str
        Of the result's class.
    values : mapping
        Plain data, as `to_dict` returns it.
    """
    from symfric.templates import render  # slow to import, and only notebooks need it

    return render("result.html", name=name, rows=list(_rows(values)))


def _rows(values: Mapping[str, object], above: str = ""):
    """Yield the name and the text of each value."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _rows(value, f"{above}{name}: ")
        else:
            yield f"{above}{name}", _shown(value)


def _shown(value) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "none"}[value]
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple):
        flat = [_shown(v) for v in value]
        nested = any(isinstance(v, list | tuple) for v in value)
        if len(flat) > MOST or any(isinstance(v, Mapping) for v in value):
            return f"{len(flat)} values"
        return ("; " if nested else ", ").join(flat) or "none"
    return str(value) or "none"
