"""Write the shipped event loops anew, for the family of processors of this machine: ``python -m symfric.codegen.ship``.

After any change to what a compiled loop does; tests say when.
"""

import os
import platform
import subprocess
import sys

from symfric.codegen.loop_loader import LOOPS, optimised, sources
from symfric.codegen.shipped_loops import write_shipped

# No instruction of the intermediate code shall depend on this very processor.
_FAMILY = {"x86_64": "x86-64-v3", "amd64": "x86-64-v3"}


def main() -> None:
    """Compile every loop and write its file."""
    for module in LOOPS:
        path = write_shipped(module, sources(module), *optimised(module))
        print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    family = _FAMILY.get(platform.machine().lower())
    if family and os.environ.get("NUMBA_CPU_NAME") != family:
        chosen = {**os.environ, "NUMBA_CPU_NAME": family, "NUMBA_CPU_FEATURES": ""}
        sys.exit(subprocess.run([sys.executable, "-m", "symfric.codegen.ship"], env=chosen).returncode)
    main()
