"""Many cases of one scene in lanes, on any number of threads."""

from collections.abc import Callable, Iterator

import numpy as np

from symfric.codegen.array_table import Table
from symfric.codegen.loop_loader import load_loop
from symfric.solve.lanes.fields import WANTING
from symfric.solve.lanes.model import LaneModel
from symfric.solve.loop.case_arrays import CaseArrays, make_arrays
from symfric.solve.loop.cases import Share, share_out


def run_in_lanes(
    lanes: LaneModel,
    y: np.ndarray,
    p: np.ndarray,
    threads: int,
    progress: Callable[[float], None] | None,
    directions: int = 0,
) -> CaseArrays:
    """Run every case from its state at t = 0 with its parameters; see `symfric.solve.loop.cases.run_cases`.

    The bits are those of the event loop, which does what is rare in a lane.
    """
    loop, model = load_loop("symfric.solve.lanes.entry", "the loop over lanes"), lanes.model

    def work(share: Share) -> Iterator[int]:
        workspace = lanes.workspace()
        b = workspace.taking(share.arrays)
        table, fresh, taken = Table(b), True, 0
        b.place.next, b.place.end = block = share.take()
        while code := loop.launch(table, fresh):
            fresh = False
            if code == WANTING:
                yield taken
                taken = block[1] - block[0]
                b.place.next, b.place.end = block = share.take()
                b.kernels.wanting, b.kernels.closing = 0, block[0] == block[1]
            else:
                yield 0
        lanes.give_back(workspace)
        yield taken

    observed = model.first.observed
    arrays = make_arrays(y, p, observed.total.shape[0], observed.seen.size, directions)
    return share_out(arrays, work, threads, progress)
