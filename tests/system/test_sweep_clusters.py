"""A sweep on a local cluster of two workers, of Dask and of Ray: the same rows as on this machine.

The clusters are started as their users start them, in processes of their own.
"""

import subprocess
import sys

import pytest
from pyarrow import parquet

from lexstack_experiments.commands import sweep as command
from lexstack_experiments.sweeps.storage import RUNS

SWEEP = """
name: clusters
description: "A few short runs."
run: promises
random: {requests: {low: 1, high: 3, of: integers}}
runs: 9
"""
DASK = """
import subprocess, sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        sys.exit(subprocess.run([*sys.argv[1:], cluster.scheduler_address]).returncode)
"""
RAY = """
import subprocess, sys
import ray
ray.init(num_cpus=2, include_dashboard=False, object_store_memory=100_000_000)
code = subprocess.run([*sys.argv[1:], "ray:" + ray.get_runtime_context().gcs_address]).returncode
ray.shutdown()
sys.exit(code)
"""


@pytest.mark.parametrize("script", [DASK, RAY], ids=["dask", "ray"])
def test_a_cluster_of_two_workers_gives_the_same_rows(script, tmp_path, monkeypatch):
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    path = tmp_path / "clusters.yaml"
    path.write_text(SWEEP, encoding="utf-8")
    assert command.main([str(path), "--out", str(tmp_path / "here"), "--workers", "1"]) == 0
    start = tmp_path / "start.py"
    start.write_text(script, encoding="utf-8")
    module = "lexstack_experiments.commands.sweep"
    call = [sys.executable, "-m", module, str(path), "--out", str(tmp_path / "there")]
    call += ["--batch", "2", "--cluster"]
    subprocess.run([sys.executable, start, *call], check=True, timeout=240)
    here, there = (parquet.read_table(tmp_path / name / RUNS) for name in ("here", "there"))
    assert there.num_rows == 9
    assert there.equals(here)
