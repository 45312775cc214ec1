"""Runs independent pieces of work side by side: on this machine's cores or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import TypeVar

import joblib

from microgripper_control.core.errors import MicrogripperError

Result = TypeVar("Result")
PATIENCE = 10.0  # s, for a scheduler to answer


@contextmanager
def cluster(address: str | None) -> Iterator[None]:
    """Send the work inside to the Dask scheduler at an address, tcp://HOST:PORT; None stays here.

    Raises MicrogripperError if nobody answers there or Dask is not installed.
    """
    if address is None:
        yield
        return
    try:
        from distributed import Client
    except ImportError:
        raise MicrogripperError(
            f"--scheduler {address}: Dask is not installed; pip install distributed"
        ) from None
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise MicrogripperError(f"--scheduler {address}: {error or 'no answer'}") from None
    with client, _backend("dask"):
        yield


def _backend(name: str) -> AbstractContextManager[object]:
    config: AbstractContextManager[object] = joblib.parallel_config(name)
    return config


def side_by_side(
    work: Callable[..., Result], arguments: Sequence[tuple[object, ...]], jobs: int
) -> Iterator[Result]:
    """The results of work(*a) for each a, in whatever order they come; `jobs` at once, -1 all."""
    if jobs == 1 or len(arguments) <= 1:
        yield from (work(*given) for given in arguments)
        return
    parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered")
    yield from parallel(joblib.delayed(work)(*given) for given in arguments)
