"""Settings of processes that make pages, in which most programs run once.

Machine code is compiled fast, also where it is shared by scenes; it ends at the same bits as code compiled for speed
(`tests/solve/test_drafts.py`). Python looks less often for cyclic garbage among the many expressions of SymPy.
"""

import gc


def prepare_for_pages() -> None:
    """Set it for this process and those that it forks."""
    from symfric.codegen.functions import compile_fast

    compile_fast()
    gc.set_threshold(100_000, 50, 100)
