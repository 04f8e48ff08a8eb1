"""Traces a fleet's logs with Dask: `python with_dask.py MODEL LOGS ANSWERS`.

On a cluster, put `Client("tcp://…")` or a cluster of `dask_jobqueue` in the place of `LocalCluster`.
"""

from __future__ import annotations

import sys

from dask.distributed import Client, LocalCluster, as_completed
from fleet import Work, answer


def main() -> int:
    """Traces what is left; the exit code says whether all of it has an answer."""
    work = Work("Dask")
    # One thread each: workers share the cores already.
    one_thread = {"RAYON_NUM_THREADS": "1"}
    failed = 0
    with (
        LocalCluster(
            n_workers=work.workers, threads_per_worker=1, dashboard_address=None, env=one_thread
        ) as cluster,
        Client(cluster) as client,
    ):
        logs = {
            client.submit(answer, work.model, log, work.answers, pure=False): log
            for log in work.left
        }
        for number, future in enumerate(as_completed(logs), start=1):
            error = future.exception()
            failed += error is not None
            line = f"{logs[future].stem}: {error!r}" if error else future.result()
            print(f"{number}/{len(logs)} {line}", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
