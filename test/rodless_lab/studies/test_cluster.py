# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A sweep on a Dask cluster of two workers, one of which is killed: the same files."""

import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from pathlib import Path

import pytest
from small_study import write_study

from rodless_lab import sweep
from rodless_lab.studies import cluster
from rodless_lab.studies.errors import StudyError
from rodless_lab.studies.study import read_study

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The scheduler of two workers, each a process with one thread, on this machine alone."""
    from distributed import LocalCluster  # noqa: PLC0415  takes a second

    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address=None,
        host="127.0.0.1",
        local_directory=str(tmp_path_factory.mktemp("dask")),
    ) as found:
        yield found.scheduler_address


def test_rows_of_a_cluster_are_those_of_this_process(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker is killed with rows in hand; the files are equal byte for byte."""
    from distributed import Client  # noqa: PLC0415

    monkeypatch.setattr(cluster, "BATCH", 2)
    study = read_study(write_study(tmp_path, rows=60, duration=1.0))
    killed: list[int] = []

    def kill_one(known: int, _total: int) -> None:
        if known >= 6 and not killed:
            with Client(address, set_as_default=False) as client:
                process = client.run(os.getpid)
                # What is done lies with the worker, too, until it is fetched: by now, six tasks.
                held = {**client.has_what()}, {**client.processing()}
            in_hand = {worker: sum(len(one.get(worker, ())) for one in held) for worker in process}
            victim = max(in_hand, key=lambda worker: in_hand[worker])
            assert in_hand[victim] > 0
            os.kill(process[victim], signal.SIGKILL)
            killed.append(process[victim])

    found = sweep(study, tmp_path / "cluster", scheduler=address, progress=kill_one)
    assert len(killed) == 1
    assert found.complete
    sweep(study, tmp_path / "here")
    (part,) = (tmp_path / "here" / "rows").iterdir()
    assert (tmp_path / "cluster" / "rows" / part.name).read_bytes() == part.read_bytes()


def test_a_cluster_of_another_version_is_refused(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its rows could have other bits: none is kept."""
    monkeypatch.setattr(cluster, "rules_digest", lambda: "another")
    with pytest.raises(StudyError, match="a worker runs another version of this package"):
        sweep(write_study(tmp_path), tmp_path / "out", scheduler=address)
    assert not list((tmp_path / "out" / "rows").iterdir())


def test_a_cluster_of_another_law_is_refused(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A user's file may be an older one on a worker, beside the same package."""
    monkeypatch.setattr(cluster, "law_digests", lambda _controllers: ["another"])
    with pytest.raises(StudyError, match="a worker runs another version of the law"):
        sweep(write_study(tmp_path), tmp_path / "out", scheduler=address)
    assert not list((tmp_path / "out" / "rows").iterdir())


class LostCluster:
    """Stands in for Dask's client and its tasks, which end with ``error`` or, without, never."""

    def __init__(self, error: Exception | None) -> None:
        self.error = error

    def __call__(self, *_arguments: object, **_options: object) -> "LostCluster":
        """Be client and task at once."""
        return self

    __enter__ = submit = __call__

    def __exit__(self, *_raised: object) -> None:
        """Close."""

    def wait_for_workers(self, _count: int, timeout: float) -> None:
        """Find one."""
        assert timeout > 0.0

    def nthreads(self) -> dict[str, int]:
        """Have lost it, where tasks do not end."""
        return {"worker": 1} if self.error else {}

    def add_done_callback(self, tell: Callable[[object], None]) -> None:
        """Tell of a task's end."""
        if self.error:
            tell(self)

    def result(self) -> None:
        """Fail."""
        assert self.error
        raise self.error


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (None, "no workers are left"),
        (CancelledError("cancelled for reason:\nlost."), "cancelled for reason: lost"),
        (
            RuntimeError("Error during deserialization.\nSee x"),
            "Error during deserialization. See x",
        ),
    ],
    ids=["no workers", "no scheduler", "another environment"],
)
def test_a_cluster_that_is_lost_on_the_way_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception | None, said: str
) -> None:
    """Its last worker, its scheduler, or a package that it lacks: neither waited for nor traced."""
    monkeypatch.setattr("distributed.Client", LostCluster(error))
    monkeypatch.setattr(cluster, "CONNECTION_TIMEOUT", 0.02)
    monkeypatch.setattr(cluster, "LOOK_EVERY", 0.01)
    with pytest.raises(StudyError) as refusal:
        sweep(write_study(tmp_path), tmp_path / "out", scheduler="tcp://there:1")
    kept = "what is known is kept, and the same command goes on, with this package and the law"
    assert (
        str(refusal.value) == f"--scheduler tcp://there:1: {said}; {kept} on scheduler and workers"
    )


def test_a_scheduler_that_is_not_there_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With its address; nothing is lost."""
    monkeypatch.setattr(cluster, "CONNECTION_TIMEOUT", 1.0)
    for address in ("tcp://127.0.0.1:9", "nowhere://x"):
        with pytest.raises(StudyError, match=f"^--scheduler {address}: not reached: ") as refusal:
            sweep(write_study(tmp_path), tmp_path / "out", scheduler=address)
        assert "\n" not in str(refusal.value)
