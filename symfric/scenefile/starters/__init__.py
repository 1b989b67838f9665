"""Scene files to start from, one for each ready model and one with own equations."""

from importlib.resources import files

from symfric.errors import SceneError
from symfric.model.symbols import nearest


def starters() -> list[str]:
    """Return the models that have a file to start from; "own" has its own equations, "structure" matrices."""
    return sorted(f.name.removesuffix(".toml") for f in files(__name__).iterdir() if f.name.endswith(".toml"))


def companions(model: str) -> dict[str, str]:
    """Return the texts of the files that belong to a scene file to start from, by name; of most models none.

    Parameters
    ----------
    model : str
    """
    folder = files(__name__).joinpath(model)
    return {f.name: f.read_text(encoding="utf-8") for f in folder.iterdir()} if folder.is_dir() else {}


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
