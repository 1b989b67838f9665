"""The explorer from Python: a page with sliders, inside a notebook or in a window of its own."""

import asyncio
import html
import threading
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec

from symfric.errors import SceneError
from symfric.model.scene import Scene
from symfric.spelling import spelt

_WIDE = 1000  # px, of the page in a notebook


@dataclass(frozen=True, eq=False)
class Exploration:
    """A page that is being served; a notebook shows it below the cell.

    Attributes
    ----------
    address : str
        Of the page, for a browser on this machine.
    height : int
        Of the page in a notebook, in pixels.

    Examples
    --------
    >>> import symfric as sf
    >>> page = sf.explore(sf.scenes.mass_on_belt(v_b=0.2))
    >>> page.address.startswith("http://localhost:")
    True
    >>> page.stop()
    """

    address: str
    height: int
    _end: Callable[[], None]

    def stop(self) -> None:
        """End the page.

        Examples
        --------
        >>> import symfric as sf
        >>> sf.explore(sf.scenes.mass_on_belt(v_b=0.2)).stop()
        """
        self._end()

    def _repr_html_(self) -> str:
        return (
            f'<iframe src="{html.escape(self.address)}" title="explorer" style="width: 100%; max-width: {_WIDE}px; '
            f'height: {self.height}px; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Exploration({self.address}, until .stop())"


@spelt
def explore(scene: Scene, *, port: int = 0, height: int = 700) -> Exploration:
    """Serve a page with a slider for each value of a scene, and figures that follow it.

    Parameters
    ----------
    scene : Scene
        With at least one value. One that `sf.read` has read keeps the units, the sweep and the name of its file.
    port : int
        Of the page; any free one unless given.
    height : int
        Of the page in a notebook, in pixels.

    Returns
    -------
    Exploration
        In a notebook the last expression of a cell, it shows the page; elsewhere open its address in a browser. It is
        served until `stop` is called or Python ends, to this machine only: not from a notebook on a remote machine.

    Raises
    ------
    SceneError
        If the scene has no values, the port is taken, or Bokeh is not installed.

    Notes
    -----
    The page is that of the command ``symfric explore``. It needs the extra ``explore``.

    Examples
    --------
    >>> import symfric as sf
    >>> page = sf.explore(sf.scenes.mass_on_belt(v_b=0.2))
    >>> repr(page).startswith("Exploration(http://localhost:")
    True
    >>> page.stop()
    """
    if find_spec("bokeh") is None:
        raise SceneError("sf.explore needs Bokeh; install it with: python -m pip install 'symfric[explore]'")
    from tornado.ioloop import IOLoop

    from symfric.report.explorer.page import page
    from symfric.report.explorer.server import check_free, serve
    from symfric.report.explorer.views import explorer
    from symfric.scenefile.read import file_of

    if not scene.parameters:
        raise SceneError("the scene has no values to change; name some by symbols in Scene.values")
    check_free(port, "port=")
    fill = page(explorer(file_of(scene)))
    servers: list[tuple[str, IOLoop]] = []
    there = threading.Event()

    def ready(address: str) -> None:
        servers.append((address, IOLoop.current()))
        there.set()

    def run() -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())  # of this thread; a notebook has its own
        try:
            serve(fill, port, ready)
        finally:
            there.set()

    threading.Thread(target=run, name="symfric explorer", daemon=True).start()
    there.wait()
    if not servers:
        raise SceneError(f"the page cannot be served on port {port}; name another one")
    ((address, loop),) = servers
    return Exploration(address, height, lambda: loop.add_callback(loop.stop))
