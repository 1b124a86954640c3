# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A sweep: all rows of a study over all cores, or over a Dask cluster, into one data set."""

from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from rodless_base.file_path import file_path
from rodless_lab.simulation.ensemble import at_once
from rodless_lab.simulation.in_order import check_workers, in_order
from rodless_lab.studies.base import Base
from rodless_lab.studies.part import parquet_modules
from rodless_lab.studies.results import Results, read_results
from rodless_lab.studies.row_run import RowResult, RowRunner
from rodless_lab.studies.store import Store
from rodless_lab.studies.study import Row, Study, read_study


def sweep(
    study: str | Path | Study,
    output: str | Path,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Results:
    """Run the rows of a study that ``output`` does not have yet, and return all of them.

    Each row is kept as soon as it is known: a sweep that was interrupted, or killed, goes on with
    the rows that are missing, and ends with the same files as one that was not. Rows have the bits
    of ``closed_loop``, wherever they run.

    Parameters
    ----------
    study
        A YAML file (docs/sweeps.md), the name of a study that ships with the package, or what
        :func:`rodless_lab.studies.study.read_study` returns.
    output
        Folder of the results; its folder ``rows`` is a Parquet data set.
    workers
        Threads; by default one for each core, and no more than there is memory for. A law in plain
        Python runs row by row, as in :func:`rodless_lab.ensemble`.
    scheduler
        Address of a Dask scheduler (extra ``dask``), such as ``tcp://host:8786``; then its workers
        run the rows.
    progress
        Called with the number of rows known and of all rows, after each row.

    Raises
    ------
    StudyError
        A ValueError of one line, before anything has run: for a study that cannot be done, and an
        ``output`` that another study has, or of which something is not as it was written.
    ModuleNotFoundError
        Without pyarrow (extra ``data``).
    OSError
        Where the folder cannot be written.
    TypeError
        For an ``output`` that is no path.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     found = sweep("friction", folder)
    >>> len(found), found.failures
    (81, {})
    """
    folder = file_path(output)
    parquet_modules()
    chosen = study if isinstance(study, Study) else read_study(study)
    run_sweep(chosen, folder, workers, scheduler, progress or (lambda _known, _total: None))
    return read_results(folder, chosen)


def run_sweep(
    study: Study,
    folder: Path,
    workers: int | None,
    scheduler: str | None,
    progress: Callable[[int, int], None],
    stopped: Callable[[], bool] = lambda: False,
) -> bool:
    """Do what :func:`sweep` does until ``stopped``; return whether all rows are known."""
    check_workers(workers)
    store = Store(folder, study)
    try:
        count = store.done
        rows = map(study.row, store.missing())
        with closing(_run(study, rows, store.add, workers, scheduler)) as runs:
            # A cluster need not be there where all is known.
            for _ in runs if count < len(study) else ():
                count += 1
                progress(count, len(study))
                if stopped():
                    break
        # Rows that were in hand have been kept, too.
        return store.done == len(study)
    finally:
        store.close()


def _run(
    study: Study,
    rows: Iterable[Row],
    keep: Callable[[RowResult], None],
    workers: int | None,
    scheduler: str | None,
) -> Generator[None, None, None]:
    """Run rows and hand them to ``keep``, each as soon as it is known; yield after each."""
    if scheduler is not None:
        from rodless_lab.studies.cluster import on_cluster  # noqa: PLC0415  an extra

        for result in on_cluster(scheduler, study, rows):
            keep(result)
            yield
        return
    run = RowRunner(study.trace_columns, study.trace_every)

    def work(row: Row) -> None:
        keep(run(row))

    yield from in_order(work, rows, _at_once(study.base, workers))


def _at_once(base: Base, workers: int | None) -> int:
    """Return how many rows may run at once, whatever their laws."""
    loops = (replace(base, controller=one).loop() for one in base.by_law.values())
    return min(at_once(loop, workers) for loop in loops)
