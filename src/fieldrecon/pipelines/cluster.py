"""Fields on a cluster of machines, by Dask: patches are solved and queries answered there.

Dask is an extra, `fieldrecon[dask]`; nothing else needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from fieldrecon.reconstruction import Field

if TYPE_CHECKING:
    import dask.array
    from distributed import Client


class Cluster(Executor):
    """The workers of a `dask.distributed` client, as an executor for all that takes one.

    The sites go to each worker once; chunks of patches or of queries follow, and their results come
    back in order. What a worker that dies had to do is done by another; the results are the same
    bits as on one machine, since chunks do not depend on who computes them.

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
        """The work on every worker, until all chunks are done."""
        held = self._client.scatter(work, broadcast=True, hash=False)
        try:
            yield held
        finally:
            held.release()

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        """Start a task, whose future is Dask's; `fn` may be what `shared_work` gave."""
        return self._client.submit(_call, fn, *args, pure=False, **kwargs)


def evaluated(field: Field, x: dask.array.Array) -> dask.array.Array:
    """Values of a field at queries in a Dask array, computed when and where Dask wants them.

    Parameters
    ----------
    field : Field
        Made by any method.
    x : dask.array.Array of shape (m, d)
        Queries, in chunks of rows.

    Returns
    -------
    dask.array.Array of shape (m, *v)
        In the same chunks of rows.

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
    held = dask.delayed(field, pure=True)
    blocks = [
        dask.array.from_delayed(dask.delayed(_call)(held, part), (rows, *one.shape[1:]), one.dtype)
        for part, rows in zip(x.rechunk({1: -1}).to_delayed()[:, 0], x.chunks[0], strict=True)
    ]
    return dask.array.concatenate(blocks)


def _call(work: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    return work(*args, **kwargs)
