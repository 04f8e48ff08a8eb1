"""Traces a fleet's logs with Ray: `python with_ray.py MODEL LOGS ANSWERS`.

On a cluster, `ray job submit` starts it; `ray.init()` then joins the cluster that is there.
"""

from __future__ import annotations

import sys

import ray
from fleet import Work, answer


def main() -> int:
    """Traces what is left; the exit code says whether all of it has an answer."""
    work = Work("Ray")
    # One thread each: workers share the cores already.
    one_thread = {"env_vars": {"RAYON_NUM_THREADS": "1"}}
    ray.init(num_cpus=work.workers, include_dashboard=False, runtime_env=one_thread)
    remote = ray.remote(num_cpus=1)(answer)
    running = {remote.remote(work.model, log, work.answers): log for log in work.left}
    failed, number, count = 0, 0, len(running)
    while running:
        (done,), _ = ray.wait(list(running), num_returns=1)
        log, number = running.pop(done), number + 1
        try:
            line = ray.get(done)
        except ray.exceptions.RayError as error:
            failed, line = failed + 1, f"{log.stem}: {error!r}"
        print(f"{number}/{count} {line}", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
