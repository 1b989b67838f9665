"""Scene files to start from, one for each ready model and one with own equations."""

from importlib.resources import files

from symfric.errors import SceneError
from symfric.model.symbols import nearest


def starters() -> list[str]:
    """Return the models that have a file to start from; "own" has its own equations."""
    return sorted(f.name.removesuffix(".toml") for f in files(__name__).iterdir() if f.name.endswith(".toml"))


def starter(model: str) -> str:
    """Return the text of a scene file to start from.

    Parameters
    ----------
    model : str

    Raises
    ------
    SceneError
        If there is none for the model.
    """
    if model not in starters():
        raise SceneError(f"no model {model!r}{nearest(model, starters())}")
    return files(__name__).joinpath(f"{model}.toml").read_text(encoding="utf-8")
