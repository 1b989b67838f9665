"""A sweep of many belts over workers of dask; a program of its own, so that it can be killed."""

import os
import sys
import warnings

import numpy as np

import symfric as sf


def belts():
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=100.0)
    return scene.wanting({"half": sf.HalfRange(scene.system.q[0])})


def grid(number):
    return {"v_b": np.linspace(0.1, 0.4, number // 100), "beta": np.linspace(0.01, 0.06, 100)}


def main(store, number, until):
    warnings.simplefilter("ignore")  # those of dask
    from distributed import Client, LocalCluster

    def tell(progress):
        if progress.done > until * progress.total:
            os._exit(9)  # as a machine that loses its power does

    options = {"dashboard_address": None, "silence_logs": "CRITICAL"}
    with LocalCluster(n_workers=2, threads_per_worker=1, **options) as cluster, Client(cluster) as client:
        sf.sweep(belts(), grid(number), executor=client.get_executor(), store=store, progress=tell)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))
