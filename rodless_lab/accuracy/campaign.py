# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Many random rigs on every core, kept in a file from which an interrupted campaign goes on."""

import csv
import math
import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from io import StringIO
from itertools import islice
from multiprocessing import get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import TextIO

from rodless_base.atomic_write import check_file_writable, naming
from rodless_base.one_line import described, in_one_line, shown
from rodless_lab import bare_rigs
from rodless_lab.accuracy.judge import Verdict, judge
from rodless_lab.accuracy.random_rigs import neighbourhood_and_drive
from rodless_lab.results_folder import lock_or_refuse
from rodless_lab.studies.seal import Seal
from rodless_lab.studies.version import SIMULATION, sources_digest

# Each row ends in a seal: whether it is as it was written, and by this version.
COLUMNS = (*Verdict._fields, "seal")
_HEADER = ",".join(COLUMNS)
_SEAL_DIGITS = 16

# Digits of the number of a rig: more have never been run.
LONGEST_NUMBER = 9
MOST_RIGS = 10**LONGEST_NUMBER

# Beside what kernels depend on: what draws the rigs, runs and judges them.
_JUDGES = (
    *(Path(__file__).with_name(f"{name}.py") for name in ("judge", "radau", "random_rigs")),
    SIMULATION,
    Path(bare_rigs.__file__),
)

# What a terminal sends to all of its processes.
_REQUESTS = (signal.SIGINT, signal.SIGHUP)


def leave_requests_to_parent() -> None:
    """Ignore what a terminal sends to the workers, too: it is their parent that ends them.

    Where that has been killed they end by themselves.
    """
    for number in _REQUESTS:
        signal.signal(number, signal.SIG_IGN)
    # Blocked since they were started, while they imported what they need.
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _REQUESTS)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _requests_blocked() -> Iterator[None]:
    """Block what a terminal sends; processes that are started meanwhile inherit that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _REQUESTS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def campaign(
    path: Path, count: int, progress: Callable[[int], None], stopped: Callable[[], bool]
) -> list[Verdict]:
    """Judge the cases 0 to ``count`` - 1 and return what is known of them, by number.

    Those that ``path`` (CSV) has already are not run again; each other one is added to it as soon
    as it is known. ``progress`` is told how many are known; ``stopped`` ends the campaign early.
    Raises ValueError for more than ``MOST_RIGS`` and as :func:`read_verdicts`, and OSError where
    another process adds to it.
    """
    if count > MOST_RIGS:
        raise ValueError(
            f"count {count} refused, must be {MOST_RIGS} or less: the numbers of rigs have at most "
            f"{LONGEST_NUMBER} digits"
        )
    check_file_writable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", newline="", encoding="utf-8") as file:
        lock_or_refuse(file.fileno(), path)
        known = {verdict.number: verdict for verdict in read_verdicts(path)}
        wanted = (number for number in range(count) if number not in known)
        with naming(path):
            _begin(file, path)
        before = sum(number < count for number in known)
        for done, verdict in enumerate(judged(wanted, stopped), before + 1):
            with naming(path):
                file.write(row_text(verdict))
                file.flush()
            known[verdict.number] = verdict
            progress(done)
    return [known[number] for number in sorted(known) if number < count]


def row_text(verdict: Verdict) -> str:
    """Return the line that a campaign's file has of a verdict, with its seal and its end."""
    cells = list(map(str, verdict))
    return _csv_line([*cells, _seal(cells)])


def _seal(cells: list[str]) -> str:
    """Return the seal of a row: it depends on its text, and on all sources that its figures do."""
    seal = Seal(sources_digest(*_JUDGES).encode(), "campaign")
    return seal.of(_csv_line(cells).encode())[:_SEAL_DIGITS]


def _csv_line(cells: list[str]) -> str:
    line = StringIO(newline="")
    csv.writer(line).writerow(cells)
    return line.getvalue()


def _begin(file: TextIO, path: Path) -> None:
    """Cut off a line that an interruption cut; write the header where there is none."""
    whole = len(_whole_lines(path))
    file.truncate(whole)
    if not whole:
        file.write(_HEADER + "\n")
    file.flush()


def _whole_lines(path: Path) -> bytes:
    content = path.read_bytes()
    return content[: content.rfind(b"\n") + 1]


def judged(numbers: Iterable[int], stopped: Callable[[], bool]) -> Iterator[Verdict]:
    """Yield the verdicts on ``numbers`` as they come, from one process for each core."""
    left = iter(numbers)
    cores = len(os.sched_getaffinity(0))
    with _requests_blocked():  # for the process that keeps track of what the workers share
        executor = ProcessPoolExecutor(cores, get_context("spawn"), leave_requests_to_parent)
    with executor as pool:
        running: set[Future[Verdict]] = set()
        while not stopped():
            with _requests_blocked():  # for the workers
                running |= {pool.submit(judge, n) for n in islice(left, 4 * cores - len(running))}
            if not running:
                return
            done, running = wait(running, timeout=1.0, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
        pool.shutdown(cancel_futures=True)


def read_verdicts(path: Path) -> list[Verdict]:
    """Return the verdicts in a file; none where there is no file.

    Raises ValueError for a file of something else, and for a row that has changed since it was
    written, or that another version of this package has written. A last line that an interruption
    or a full disk cut is left out: its case is run again.
    """
    if not path.exists():
        return []
    try:
        whole = _whole_lines(path)
        if not whole and _HEADER.encode().startswith(path.read_bytes()):
            return []
        header, *rows = list(csv.reader(StringIO(whole.decode(), newline=""))) or [[]]
        if tuple(header) != COLUMNS:
            raise ValueError("other columns")
        return _verdicts(rows)
    except (ValueError, csv.Error) as error:
        raise ValueError(
            f"{path}: not a campaign of this version ({described(error)}); give another --output"
        ) from error


def _verdicts(rows: list[list[str]]) -> list[Verdict]:
    """Return what each row says; raises ValueError, which names the first that says nothing."""
    found: dict[int, Verdict] = {}
    for place, row in enumerate(rows, 1):
        try:
            verdict = _verdict(row)
            if verdict.number in found:
                raise ValueError(f"rig {verdict.number} a second time")
        except ValueError as error:
            raise ValueError(f"row {place}: {error}") from error
        found[verdict.number] = verdict
    return list(found.values())


def _verdict(row: list[str]) -> Verdict:
    if len(row) != len(COLUMNS):
        raise ValueError(f"{len(row)} columns, must be {len(COLUMNS)}")
    *cells, seal = row
    number, around, drive, *figures, failure = cells
    exists = number.isascii() and number.isdecimal() and len(number) <= LONGEST_NUMBER
    if not exists or (around, drive) != neighbourhood_and_drive(int(number)):
        raise ValueError(f"there is no rig {', '.join(map(in_one_line, row[:3]))}")
    verdict = Verdict._make((int(number), around, drive, *map(float, figures), failure))
    for text, value in zip(figures, verdict[3:-1], strict=True):
        if value < 0.0 or math.isinf(value) or "_" in text:
            raise ValueError(f"{shown(text)} is no difference")
    # Radau's alone may be missing without a reason: it solves few.
    if not failure and math.isnan(sum(verdict[3:-3])):
        raise ValueError("figures are missing, and nothing says why")
    if seal != _seal(cells):
        raise ValueError("changed, or of another version of this package")
    return verdict
