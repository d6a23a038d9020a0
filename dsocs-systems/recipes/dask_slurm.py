#!/usr/bin/env python3
"""A sweep by Dask: the shards are Dask's tasks, its workers are jobs of SLURM, or processes here.

python3 dask_slurm.py plan.toml sweep/ --shards 64 --workers 8           # jobs of SLURM, by dask-jobqueue
python3 dask_slurm.py plan.toml sweep/ --shards 8 --workers 2 --local    # processes here

A worker that dies takes no finished part with it: Dask gives its shard to another, which computes what is missing.
"""

import argparse
import os
import subprocess

from dask.distributed import Client, LocalCluster, as_completed


def shard(number, count, plan, out):
    """Computes a share of the parts, in a process of its own."""
    program = os.environ.get("DSOCS", "dsocs")
    command = [program, "sweep", plan, "--out", out, "--threads", "1", "--shard", f"{number}/{count}"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"shard {number}/{count}: {done.stderr}")
    return done.stderr.strip()


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("plan")
    arguments.add_argument("out")
    arguments.add_argument("--shards", type=int, default=64)
    arguments.add_argument("--workers", type=int, default=8)
    arguments.add_argument("--local", action="store_true")
    given = arguments.parse_args()
    plan, out = os.path.abspath(given.plan), os.path.abspath(given.out)
    if given.local:
        cluster = LocalCluster(n_workers=given.workers, threads_per_worker=1, dashboard_address=None)
    else:
        from dask_jobqueue import SLURMCluster

        cluster = SLURMCluster(cores=1, memory="1GB", walltime="01:00:00")
        cluster.scale(given.workers)
    with cluster, Client(cluster) as client:
        tasks = [
            client.submit(shard, number, given.shards, plan, out, pure=False, retries=3)
            for number in range(1, given.shards + 1)
        ]
        for task in as_completed(tasks):
            print(task.result(), flush=True)
    subprocess.run([os.environ.get("DSOCS", "dsocs"), "sweep", "--status", "--out", out], check=True)


if __name__ == "__main__":
    main()
