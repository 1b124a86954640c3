# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Rows of a study on a Dask cluster (extra ``dask``): the same rows, the same bits.

Batches of rows go out as the workers ask for them. What a worker that dies had in hand, Dask gives
to another; what this process has received is kept by the caller, row by row.
"""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any

from rodless_base.extras import missing_extra
from rodless_base.one_line import described
from rodless_control.controller_parameters import ControllerParameters
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.row_run import RowResult, RowRunner
from rodless_lab.studies.study import Row, Study
from rodless_lab.studies.version import law_digests, rules_digest

# Rows of a task: a tenth of a second of work, a hundred times what it costs to send.
BATCH = 25

# Tasks that wait for each thread of the cluster.
AHEAD = 3

# How long a scheduler, or a first worker, is waited for.
CONNECTION_TIMEOUT = 30.0  # s

# How often it is asked whether there are workers, while none has answered.
LOOK_EVERY = 1.0  # s


def run_rows(
    columns: tuple[str, ...], every: int, controllers: list[ControllerParameters], rows: list[Row]
) -> tuple[list[str], list[RowResult]]:
    """Run rows on a worker; return the digests of its equations and laws, and what it has found."""
    run = RowRunner(columns, every)
    return _versions(controllers), [run(row) for row in rows]


def _versions(controllers: Iterable[ControllerParameters]) -> list[str]:
    return [rules_digest(), *law_digests(controllers)]


def on_cluster(address: str, study: Study, rows: Iterable[Row]) -> Iterator[RowResult]:
    """Yield the results of ``rows`` as they come from the workers of the scheduler ``address``.

    Raises StudyError where the cluster cannot be reached, has no workers, runs another version of
    this package or lacks it, is lost, or loses its workers over and over; ModuleNotFoundError
    without Dask.
    """
    try:
        from distributed import Client  # noqa: PLC0415  an extra
    except ModuleNotFoundError as error:
        raise missing_extra("--scheduler", error.name, "dask") from error
    try:
        client = Client(address, timeout=CONNECTION_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StudyError(f"--scheduler {address}: not reached: {described(error)}") from error
    left = batches(rows)
    waiting: set[Any] = set()
    done: SimpleQueue[Any] = SimpleQueue()
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECTION_TIMEOUT)
            while True:
                # Workers may have joined, or gone.
                free = _wanted(client) - len(waiting)
                for future in _sent(client, study, islice(left, max(free, 0))):
                    waiting.add(future)
                    future.add_done_callback(done.put)
                if not waiting:
                    return
                future = _next(client, done)
                waiting.remove(future)
                yield from _checked(address, study, _result(address, future))
        except OSError as error:
            raise _lost(address, error) from error


def _next(client: Any, done: "SimpleQueue[Any]") -> Any:
    """Return a task that is done; raises TimeoutError where no workers are left to do one."""
    patience = CONNECTION_TIMEOUT
    while patience > 0.0:
        with suppress(Empty):
            return done.get(timeout=LOOK_EVERY)
        patience = CONNECTION_TIMEOUT if _threads(client) else patience - LOOK_EVERY
    raise TimeoutError("no workers are left")


def _result(address: str, future: Any) -> tuple[list[str], list[RowResult]]:
    """Return what a task has found; raises StudyError for whatever Dask or a worker raises."""
    try:
        found: tuple[list[str], list[RowResult]] = future.result()
    except Exception as error:
        raise _lost(address, error) from error
    return found


def _lost(address: str, error: Exception) -> StudyError:
    return StudyError(
        f"--scheduler {address}: {described(error).rstrip('.')}; what is known is kept, and the "
        "same command goes on, with this package and the law on scheduler and workers"
    )


def _checked(
    address: str, study: Study, found: tuple[list[str], list[RowResult]]
) -> list[RowResult]:
    """Return the rows of a worker; raises StudyError where it runs another version."""
    versions, results = found
    if versions != _versions(study.base.by_law.values()):
        what = "this package" if versions[0] != rules_digest() else "the law"
        raise StudyError(
            f"--scheduler {address}: a worker runs another version of {what}; install the same "
            "one everywhere"
        )
    return results


def _wanted(client: Any) -> int:
    """Return how many tasks keep the workers that there are busy: one where none is left."""
    return max(AHEAD * _threads(client), 1)


def _threads(client: Any) -> int:
    """Return how many threads the cluster has; raises OSError where its scheduler is lost."""
    try:
        return sum(client.nthreads().values())
    except AttributeError as error:  # of a client that has closed itself
        raise OSError("the connection to the scheduler is lost") from error


def _sent(client: Any, study: Study, tasks: Iterable[list[Row]]) -> list[Any]:
    given = study.trace_columns, study.trace_every, [*study.base.by_law.values()]
    return [client.submit(run_rows, *given, rows, pure=False) for rows in tasks]


def batches(rows: Iterable[Row]) -> Iterator[list[Row]]:
    """Yield the rows in lists of ``BATCH``."""
    left = iter(rows)
    while batch := list(islice(left, BATCH)):
        yield batch
