"""Fields on a cluster of machines, by Dask: its workers solve the patches and evaluate queries.

Dask is an extra, `fieldrecon[dask]`.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from fieldrecon.fields import Field

if TYPE_CHECKING:
    import dask.array
    from distributed import Client


class Cluster(Executor):
    """The workers of a `dask.distributed` client, as an executor.

    The sites are sent to each worker once, then chunks of patches or of queries; the results are
    returned in order. If a worker dies, its tasks are repeated. The results are identical to
    those on one machine, since the chunks do not depend on the workers.

    Parameters
    ----------
    client : distributed.Client
        Connected to a scheduler.

    Examples
    --------
    With a client of the cluster, ``method.field(values, executor=Cluster(client))`` solves the
    patches there, and ``field(x, executor=Cluster(client))`` evaluates there.
    """

    def __init__(self, client: Client) -> None:
        self._client = client

    @contextmanager
    def shared_work(self, work: Callable[[np.ndarray], Any]) -> Iterator[Any]:
        """Send the work to the workers, and release it when all chunks are done.

        It is the result of a task, which Dask repeats if the worker that has it dies. Scattered
        data would be lost: Dask keeps one copy of them, even if they were sent to every worker.
        """
        import dask
        from distributed.protocol.pickle import dumps  # functions of a notebook too

        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1PiB"}):
            held = self._client.submit(_unpacked, dumps(work), pure=False)
        try:
            yield held
        finally:
            held.release()

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        """Start a task, whose future is Dask's; `fn` may be what `shared_work` gave."""
        return self._client.submit(_call, fn, *args, pure=False, **kwargs)


def evaluated(field: Field, x: dask.array.Array) -> dask.array.Array:
    """Evaluate a field lazily at queries in a Dask array.

    Parameters
    ----------
    field : Field
        A field of any method.
    x : dask.array.Array of shape (m, d)
        Queries in chunks of rows.

    Returns
    -------
    dask.array.Array of shape (m, *v)
        Values in the same chunks of rows.

    Raises
    ------
    ValueError
        If the queries have the wrong number of coordinates.
    """
    import dask
    import dask.array

    d = field.method.points.shape[1]
    if x.ndim != 2 or x.shape[1] != d:
        raise ValueError(f"x must have the shape (m, {d}); got {x.shape}")
    one = field(field.method.points[:1])
    held = dask.delayed(field, pure=True)  # one key, so that a cluster holds the field once
    blocks = [
        dask.array.from_delayed(dask.delayed(_call)(held, part), (rows, *one.shape[1:]), one.dtype)
        for part, rows in zip(x.rechunk({1: -1}).to_delayed()[:, 0], x.chunks[0], strict=True)
    ]
    return dask.array.concatenate(blocks)


def _unpacked(pickled: bytes) -> Any:
    return pickle.loads(pickled)


def _call(work: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    return work(*args, **kwargs)
