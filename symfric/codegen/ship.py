"""Write the shipped event loops anew, for the family of processors of this machine: ``python -m symfric.codegen.ship``.

After any change to the files of a compiled loop; tests say when. A loop that does what it did is not compiled again:
its files learn the bytes of their sources only, which are faster to compare than what they mean. With ``--check``
nothing is written: every loop is compiled from its sources, and its intermediate code must be that of its file bit for
bit, which a file made from other sources is not, whatever it says of itself. With ``--made-with`` the versions are
printed that made the files, as pip takes them: other versions of Python, numba and llvmlite give other code.
"""

import os
import subprocess
import sys

from symfric.codegen.loop_loader import LOOPS, optimised, sources
from symfric.codegen.shipped_loops import (
    UNREADABLE,
    bitcode,
    compilers,
    family,
    for_family,
    machine_code_place,
    place,
    renewed,
    shipped_code,
    shipped_header,
    shipped_machine_code,
    write_shipped,
)

CHECK, MADE_WITH = "--check", "--made-with"


def write() -> None:
    """Compile every loop that is not what its sources give, and write its files."""
    for module in LOOPS:
        if renewed(module, sources(module)):
            print(f"{module}: nothing new but comments, docstrings and layout at most")
            continue
        for path in write_shipped(module, sources(module), *optimised(module)):
            print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")


def check(modules: tuple[str, ...] = LOOPS) -> list[str]:
    """Compile loops and return a line for each whose file holds other code."""
    complaints, own = [], family()
    for module in modules:
        try:
            made, code, ready = shipped_header(module), shipped_code(module), shipped_machine_code(module)
        except UNREADABLE as error:
            complaints.append(f"{module}: its file cannot be read ({error}); write it anew")
            continue
        versions = made.get("made with", {})
        if versions and versions != compilers():
            complaints.append(
                f"{module}: made with {_listed(versions)}, and this is {_listed(compilers())}; use the former"
            )
            continue
        function, text = optimised(module)
        if made["function"] != function or code != bitcode(text):
            complaints.append(f"{module}: its file {place(module).name} holds other code than its sources give")
        elif own is not None and ready is not None and ready != for_family(code, own):
            complaints.append(f"{module}: {machine_code_place(module).name} holds other code than its sources give")
        else:
            print(f"{module}: the same")
    return complaints


def _listed(versions: dict[str, str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in versions.items())


def made_with() -> str:
    """Return the compiler packages that made the files, as requirements of pip."""
    versions = shipped_header(LOOPS[0]).get("made with", {})
    return " ".join(f"{name}=={number}" for name, number in versions.items() if name != "python") or "llvmlite numba"


def main(arguments: list[str]) -> int:
    """Write, check or describe the files; return the exit status."""
    if arguments == [MADE_WITH]:
        print(made_with())
        return 0
    if arguments == [CHECK]:
        faults = check()
        print("\n".join(faults), end="\n" if faults else "", file=sys.stderr)
        return 1 if faults else 0
    if arguments:
        print(f"give nothing, {CHECK} or {MADE_WITH}", file=sys.stderr)
        return 2
    write()
    return 0


if __name__ == "__main__":
    # no instruction of the intermediate code shall depend on this very processor
    own = family()
    if own is not None and os.environ.get("NUMBA_CPU_NAME") != own.name:
        chosen = {**os.environ, "NUMBA_CPU_NAME": own.name, "NUMBA_CPU_FEATURES": ""}
        command = [sys.executable, "-m", "symfric.codegen.ship", *sys.argv[1:]]
        sys.exit(subprocess.run(command, env=chosen).returncode)
    sys.exit(main(sys.argv[1:]))
