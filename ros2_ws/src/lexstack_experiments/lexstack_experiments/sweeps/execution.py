"""Runs spread over processes by joblib: this machine's cores, or a cluster of Ray or Dask."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib

from lexstack.errors import ConfigurationError, LexstackError
from lexstack.options import shown
from lexstack_experiments.sweeps.kinds import KINDS
from lexstack_experiments.sweeps.kinds.kind import Row
from lexstack_experiments.sweeps.sweep_file import SweepFile

Indices = Sequence[int]
_PER_WORKER = 4

ERROR = "error"
"""The column with the reason of a run that could not be done; empty for all others."""


@dataclass(frozen=True, slots=True)
class Done:
    """Some runs that are done: their numbers, and for each its values and figures."""

    indices: tuple[int, ...]
    rows: tuple[Row, ...]


def run_batch(sweep: SweepFile, config: Path, indices: Indices) -> Done:
    """Do some runs one after the other; called in the workers.

    A run that cannot be done has the reason in its row: what the library says, or what its
    arithmetic does with the values; so no run takes the others with it. What is wrong with the
    sweep itself, such as an unknown key, is raised: it is wrong in every run.

    Raises:
        ConfigurationError: a value does not fit the kind of run.
    """
    rows = []
    for index in indices:
        values = sweep.values(index)
        try:
            found = {**KINDS[sweep.run](config, sweep.of, values), ERROR: ""}
        except ConfigurationError:
            raise
        except LexstackError as error:
            found = {ERROR: " ".join(str(error).split()) or type(error).__name__}
        except (ArithmeticError, ValueError) as error:
            found = {ERROR: f"{type(error).__name__}: {' '.join(str(error).split())}"}
        rows.append({**{key: cell(value) for key, value in values.items()}, **found})
    return Done(tuple(indices), tuple(rows))


def cell(value: Any) -> float | int | str | bool | None:
    """Return a value as it is kept in a table: numbers and texts as they are, others as text."""
    return value if value is None or isinstance(value, float | int | str) else repr(value)


def batches(indices: Indices, size: int) -> list[Indices]:
    """Return the runs in groups, each for one call of a worker."""
    return [indices[start : start + size] for start in range(0, len(indices), size)]


def spread(
    sweep: SweepFile, config: Path, groups: Sequence[Indices], cluster: str = "", workers: int = 0
) -> Iterator[Done]:
    """Do groups of runs in parallel, and yield each as it is done, in any order.

    Args:
        sweep: what is run.
        config: the configuration folder, by the same path on every machine.
        groups: numbers of runs.
        cluster: '' for this machine; ``ray://HOST:PORT`` or ``ray:ADDRESS`` for Ray; an address of
            a Dask scheduler, as ``tcp://HOST:PORT``.
        workers: processes of this machine; 0: one per core. A cluster has as many as it has.

    Raises:
        ConfigurationError: the cluster's software is not installed, or its address is none.
        LexstackError: the cluster cannot be reached.
    """
    with ExitStack() as stack:
        jobs = _connected(stack, cluster) if cluster else min(workers, len(groups)) or -1
        calls = [joblib.delayed(run_batch)(sweep, config, group) for group in groups]
        if not cluster.startswith("ray:"):
            parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
            yield from parallel(calls)
            return
        # Ray's back end gives all results at the end: so calls go out a few per worker at a time.
        for start in range(0, len(calls), _PER_WORKER * jobs):
            round_of = calls[start : start + _PER_WORKER * jobs]
            yield from joblib.Parallel(n_jobs=jobs, batch_size=1)(round_of)


def _connected(stack: ExitStack, cluster: str) -> int:
    """Connect to a cluster until the stack is closed; returns how many workers it has."""
    if cluster.startswith("ray:"):
        return _ray(stack, cluster)
    if "://" in cluster:
        return _dask(stack, cluster)
    raise ConfigurationError(
        "--cluster: expected ray://HOST:PORT, ray:ADDRESS, or tcp://HOST:PORT of a Dask scheduler, "
        f"got {shown(cluster)}"
    )


def _ray(stack: ExitStack, cluster: str) -> int:
    """Use a Ray cluster; joblib's calls become those of Ray's own back end."""
    try:
        import ray  # noqa: PLC0415 - large, and for those alone who have such a cluster
        from ray.util.joblib import register_ray  # noqa: PLC0415
    except ImportError as error:
        raise ConfigurationError(f"--cluster: {error}; pip install 'ray'") from error
    address = cluster if cluster.startswith("ray://") else cluster.removeprefix("ray:")
    try:
        ray.init(address=address, log_to_driver=False, logging_level="error")
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise LexstackError(f"--cluster: {shown(cluster)} cannot be reached: {error}") from error
    stack.callback(ray.shutdown)
    register_ray()
    stack.enter_context(joblib.parallel_config("ray"))
    return int(ray.cluster_resources().get("CPU", 1))


def _dask(stack: ExitStack, cluster: str) -> int:
    """Use a Dask cluster; distributed brings joblib's back end."""
    try:
        from distributed import Client  # noqa: PLC0415 - for those alone who have such a cluster
    except ImportError as error:
        raise ConfigurationError(f"--cluster: {error}; pip install 'distributed'") from error
    try:
        client = stack.enter_context(Client(cluster, timeout="20s", set_as_default=True))
    except (OSError, ValueError) as error:
        raise LexstackError(f"--cluster: {shown(cluster)} cannot be reached: {error}") from error
    stack.enter_context(joblib.parallel_config("dask"))
    return max(1, sum(client.nthreads().values()))
