"""The server of the explorer, reachable only from this machine and from pages of its own address."""

import contextlib
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.server.util import bind_sockets
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import ErrorHandler

from symfric.errors import SceneError

FORBIDDEN = 403


class OwnPages(BokehTornado):
    """Request router that accepts only requests whose Host and Origin are this server's address.

    A foreign page can let its own name point to this machine (DNS rebinding) and would then read the data served here;
    its requests carry that name as their Host. A socket opened by another page carries that page as its Origin.
    """

    def __init__(self, pages: dict[str, Application], port: int):
        self._hosts = {f"localhost:{port}", f"127.0.0.1:{port}"}
        super().__init__(pages, extra_websocket_origins=sorted(self._hosts), absolute_url=f"http://localhost:{port}/")

    def find_handler(self, request: HTTPServerRequest, **arguments: Any) -> Any:
        """Return the handler of a request of any path, including files and sockets."""
        if not self._own(request):
            return self.get_handler_delegate(request, ErrorHandler, {"status_code": FORBIDDEN})
        return super().find_handler(request, **arguments)

    def _own(self, request: HTTPServerRequest) -> bool:
        hosts, origins = request.headers.get_list("Host"), request.headers.get_list("Origin")
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            return False
        return all(_host_of(origin) in self._hosts for origin in origins)


def _host_of(origin: str) -> str:
    """Return the host and port of an origin of the web; empty for any other, such as ``null``."""
    scheme, _, host = origin.lower().partition("://")
    return host if scheme == "http" and urlsplit(f"//{host}").netloc == host else ""


def check_free(port: int, option: str) -> None:
    """Raise if the port is in use; `option` names another one."""
    try:
        with socket.create_server(("127.0.0.1", port)):
            pass
    except OSError:
        raise SceneError(
            f"port {port} cannot be used: it is taken or not allowed; name another with {option}"
        ) from None


def serve(fill: Callable[[Any], None], port: int, ready: Callable[[str], None]) -> None:
    """Serve a page on the loopback address until interrupted.

    Parameters
    ----------
    fill : callable ``(doc) -> None``
        Fills a Bokeh document.
    port : int
        0 for any that is free.
    ready : callable ``(address) -> None``
        Called once the page can be opened, in the thread that serves it; an interrupt or ``IOLoop.current().stop``
        ends it.
    """
    sockets, port = bind_sockets("127.0.0.1", port)
    application = OwnPages({"/": Application(FunctionHandler(fill))}, port)
    http = HTTPServer(application)
    http.add_sockets(sockets)
    server = BaseServer(IOLoop.current(), application, http)
    server.start()
    ready(f"http://localhost:{port}/")
    try:
        with _ended_by_interrupt(server.io_loop):
            server.io_loop.start()
    finally:
        server.stop()


@contextlib.contextmanager
def _ended_by_interrupt(loop: IOLoop) -> Iterator[None]:
    """Let the first interrupt stop a loop between two callbacks; the next one breaks off the callback itself.

    Raised inside a callback it could be lost: compiled code that calls Python back drops what is raised there.
    """

    def stop(_signal: int, _frame: object) -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        loop.add_callback_from_signal(loop.stop)

    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        yield
        return
    before = signal.signal(signal.SIGINT, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
