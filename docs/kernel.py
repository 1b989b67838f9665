"""Kernels of executed pages, forked from one process that has imported what all pages import.

To import the package, Matplotlib and Jupyter takes longer than to execute most pages. `offered` starts that process and
tells Jupyter of it through a kernel specification. Jupyter runs this file as a script, which has the process fork a
kernel and lives as long as it.
"""

import contextlib
import importlib
import json
import os
import socket
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path

_NAME = "python3"  # what the pages name as their kernel


@contextlib.contextmanager
def offered() -> Iterator[None]:
    """Fork kernels within this block; on other systems than Linux they start as Jupyter starts them.

    The process imports nothing before the first kernel: a build that executes no page pays nothing.
    """
    if sys.platform != "linux":
        yield
        return
    with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX) as door:
        address = str(Path(folder, "door"))
        door.bind(address)
        door.listen()
        spec = Path(folder, "kernels", _NAME, "kernel.json")
        spec.parent.mkdir(parents=True)
        words = [sys.executable, "-S", "-E", __file__, address, "-f", "{connection_file}", "--log-level=ERROR"]
        spec.write_text(json.dumps({"argv": words, "display_name": _NAME, "language": "python"}), encoding="utf-8")
        others = os.environ.get("JUPYTER_PATH", "")
        os.environ["JUPYTER_PATH"] = os.pathsep.join(filter(None, [folder, others]))
        server = _forked(_serve, door)
        try:
            yield
        finally:
            os.environ["JUPYTER_PATH"] = others
            door.shutdown(socket.SHUT_RDWR)  # `accept` in the other process ends
            os.waitpid(server, 0)


def _forked(work: Callable[..., None], *arguments: object) -> int:
    """Return the number of a process that does some work and ends."""
    process = os.fork()
    if process:
        return process
    status = 1
    try:
        work(*arguments)
        status = 0
    except Exception:
        traceback.print_exc()
    finally:
        os._exit(status)


def _serve(door: socket.socket) -> None:
    """Fork a kernel for every caller until the door is shut."""
    kernels: list[int] = []
    while True:
        try:
            caller, _ = door.accept()
        except OSError:
            break
        if not kernels:
            _load()
        kernels.append(_forked(_become_kernel, door, caller))
        caller.close()
    for kernel in kernels:
        os.waitpid(kernel, 0)


def _load() -> None:
    """Import what pages need; run a scene once, which loads the event loop."""
    os.environ["JPY_PARENT_PID"] = "1"  # no parent to be watched: it is not the process that Jupyter started
    import matplotlib

    matplotlib.rcParams["backend"] = "module://matplotlib_inline.backend_inline"  # as Jupyter's kernels set it
    for module in ("ipykernel.ipkernel", "ipykernel.kernelapp", "matplotlib.pyplot", "xarray"):
        importlib.import_module(module)
    import symfric as sf
    from docs.once import prepare_for_pages

    prepare_for_pages()
    sf.limit_cycle(sf.scenes.mass_on_belt(v_b=0.2))


def _become_kernel(door: socket.socket, caller: socket.socket) -> None:
    """Run the kernel in the folder and with the environment of the caller, and end with it."""
    door.close()
    with caller.makefile("r", encoding="utf-8") as letter:
        asked = json.loads(letter.readline())
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)  # what an interpreter reads as it starts
    sys.path[:0] = [path for path in paths if path and path not in sys.path]

    def watch() -> None:
        caller.recv(1)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    from ipykernel.kernelapp import launch_new_instance

    launch_new_instance(argv=asked["arguments"])


def _call(address: str, *arguments: str) -> None:
    """Have a kernel forked, and wait for its end; Jupyter interrupts this process to shut the kernel down."""
    with socket.socket(socket.AF_UNIX) as server, contextlib.suppress(KeyboardInterrupt):
        server.connect(address)
        asked = {"arguments": arguments, "folder": os.getcwd(), "environment": dict(os.environ)}
        server.sendall(json.dumps(asked).encode() + b"\n")
        server.recv(1)


if __name__ == "__main__":
    _call(*sys.argv[1:])
