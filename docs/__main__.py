"""Build the documentation as HTML: ``python -m docs``. Warnings are errors.

Pages are executed where their text, or a source of the package, has changed; an example that has changed runs alone.
"""

import argparse
import os
import sys
from pathlib import Path

from docs import kernel

FOLDER = Path(__file__).parent


def main() -> int:
    """Build, and return the exit status of Sphinx."""
    parser = argparse.ArgumentParser(prog="python -m docs", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=FOLDER / "_build" / "html", help="folder of the pages")
    parser.add_argument(
        "--fresh", action="store_true", help="execute every page, not only those whose text or sources changed"
    )
    arguments = parser.parse_args()
    from sphinx.cmd.build import main as sphinx

    own = (FOLDER.parent, FOLDER.parent / "derivations" / "evidence")  # of this checkout, for executed pages
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [*map(str, own), os.environ.get("PYTHONPATH")]))
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # small matrices; more threads wait for each other where others work too
    os.environ.setdefault("SYMPY_CACHE_SIZE", "20000")  # it keeps more of what it has worked out
    os.environ["SYMFRIC_PROGRESS"] = "0"  # no bars among the outputs of the pages
    os.environ["SYMFRIC_DOCS_FRESH"] = "yes" if arguments.fresh else ""
    doctrees = str(arguments.out.parent / "doctrees")
    fresh = ["-E", "-a"] if arguments.fresh else []
    options = ["-W", "--keep-going", "-q", "-b", "html", "-d", doctrees, *fresh]
    with kernel.offered():
        status = sphinx([*options, str(FOLDER), str(arguments.out)])
    if status == 0:
        print(arguments.out / "index.html")
    return status


if __name__ == "__main__":
    sys.exit(main())
