# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The campaign: it goes on where it was interrupted, and its tables say what is in its file."""

import math
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import cast

import pytest
from no_room import no_room
from quiet_stop import Quiet

from rodless_lab.accuracy import campaign as module
from rodless_lab.accuracy.campaign import COLUMNS, MOST_RIGS, campaign, read_verdicts, row_text
from rodless_lab.accuracy.judge import Verdict, judge
from rodless_lab.accuracy.random_rigs import neighbourhood_and_drive
from rodless_lab.accuracy.summary import summary
from rodless_lab.cli.campaign import main
from rodless_lab.results_folder import lock_or_refuse

pytestmark = pytest.mark.usefixtures("hears_hangup")


def verdict(number: int, error: float, disturbed: float = 0.0, failure: str = "") -> Verdict:
    """Return a verdict on an open loop around paper with this error (m)."""
    nan = math.nan
    return Verdict(number, "paper", "open loop", 0.1, error, 1.0, disturbed, 2.0, nan, nan, failure)


HEADER = ",".join(COLUMNS) + "\n"
KNOWN = row_text(Verdict(7, "paper", "open loop", 0.1, *[1.0] * 6, ""))


@pytest.mark.slow
def test_an_interrupted_campaign_goes_on_where_it_was(tmp_path: Path) -> None:
    """Stopped after two rigs it has two; the same again adds the others, each once."""
    path, told = tmp_path / "folder" / "campaign.csv", list[int]()
    first = campaign(path, 4, told.append, lambda: len(told) >= 2)
    assert len(first) >= 2
    before = path.read_text()
    path.write_text(before + "3,paper,open l")  # as a power cut leaves it
    whole = campaign(path, 4, told.append, lambda: False)
    assert [found.number for found in whole] == [0, 1, 2, 3]
    assert path.read_text().startswith(before)
    assert repr(read_verdicts(path)[0]) == repr(judge(read_verdicts(path)[0].number))
    assert told[-1] == 4


@contextmanager
def begun(path: Path) -> Iterator["subprocess.Popen[str]"]:
    """Run a long campaign, which has some verdicts already."""
    run = "from rodless_lab.cli.main import main; main()"
    with subprocess.Popen(
        [sys.executable, "-c", run, "campaign", "--count", "1000", "--output", str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        while not (path.exists() and read_verdicts(path)):
            with suppress(subprocess.TimeoutExpired):
                pytest.fail(f"it has ended with {process.wait(0.1)}")
        yield process


@pytest.mark.slow
def test_the_workers_of_a_killed_campaign_end_with_it(tmp_path: Path) -> None:
    """They would keep its memory, and whoever reads its output waiting."""
    with begun(tmp_path / "campaign.csv") as process:
        process.kill()
        try:
            # Until the last of those that have its output has ended.
            process.communicate(timeout=60)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_what_a_terminal_sends_to_all_ends_it_in_words(tmp_path: Path, number: int) -> None:
    """Ctrl-C, or closing it, reaches the workers, too: they leave the end to their parent."""
    path = tmp_path / "campaign.csv"
    with begun(path) as process:
        os.killpg(process.pid, number)
        _, said = process.communicate(timeout=240)
    assert process.returncode == 1
    assert said.splitlines()[-1] == "interrupted; the same command goes on"
    assert "Traceback" not in said
    assert read_verdicts(path)


def masks_in_workers(monkeypatch: pytest.MonkeyPatch) -> set[int]:
    """Return what a worker of a campaign has blocked where it would judge a rig."""
    look = partial(signal.pthread_sigmask, signal.SIG_BLOCK)
    monkeypatch.setattr(module, "judge", look)
    (found,) = module.judged([()], lambda: False)  # type: ignore[list-item]
    return set(cast(set[int], found))


def test_workers_begin_with_what_a_terminal_sends_blocked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while they still import what they need would end them in tracebacks.

    Where nothing has been done about signals yet, they wait; the parent, which listens, has them.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    monkeypatch.setattr(module, "leave_requests_to_parent", os.getpid)
    assert masks_in_workers(monkeypatch) >= {signal.SIGINT, signal.SIGHUP}
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before


def test_workers_that_have_begun_block_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """They ignore it instead, and what they start hears it again."""
    assert masks_in_workers(monkeypatch).isdisjoint({signal.SIGINT, signal.SIGHUP})


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_a_header_that_a_full_disk_cut_is_written_anew(tmp_path: Path, share: float) -> None:
    """A file that is empty, or ends within its first line, holds nothing: none is refused."""
    path, header = tmp_path / "campaign.csv", ",".join(COLUMNS)
    path.write_text(header[: int(share * len(header))])
    assert read_verdicts(path) == []
    campaign(path, 0, lambda _: None, lambda: False)
    assert path.read_text() == header + "\n"


@pytest.mark.parametrize(
    "more",
    [
        b"3,paper,open l",
        b"3,paper,open loop,1,1,1,1,1,1,1,it bur",
        b"3,paper,open loop,1,1,1,1,1,1,1,it burst,0123456789abcde",
        b"\xc2",
    ],
)
def test_a_row_that_an_interruption_cut_is_no_row(tmp_path: Path, more: bytes) -> None:
    """Though all of its commas are there: half a failure is another one, an empty one is none."""
    path = tmp_path / "campaign.csv"
    whole = f"{HEADER}{KNOWN}"
    path.write_bytes(whole.encode() + more)
    assert [one.number for one in read_verdicts(path)] == [7]
    campaign(path, 0, lambda _: None, lambda: False)
    assert path.read_bytes() == whole.encode()


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("7;paper;open loop\n", "row 1: 1 columns, must be 12"),
        (f"{KNOWN}{KNOWN}", "row 2: rig 7 a second time"),
        (KNOWN.replace("7", "-5", 1), "row 1: there is no rig -5, paper, open loop"),
        (KNOWN.replace("paper", "lead"), "row 1: there is no rig 7, lead, open loop"),
        (KNOWN.replace("open", "closed"), "row 1: there is no rig 7, paper, closed loop"),
        (KNOWN.replace(",1.0,", ",-1,", 1), "row 1: '-1' is no difference"),
        (KNOWN.replace(",1.0,", ",inf,", 1), "row 1: 'inf' is no difference"),
        (KNOWN.replace(",1.0,", ",1_0,", 1), "row 1: '1_0' is no difference"),
        (KNOWN.replace(",1.0,", ",nan,", 1), "row 1: figures are missing, and nothing says why"),
        (KNOWN.replace(",1.0,", ",one,", 1), "row 1: could not convert string to float: 'one'"),
    ],
)
def test_rows_that_are_no_verdicts_are_refused(tmp_path: Path, rows: str, said: str) -> None:
    """Somebody has written them: they are neither counted nor passed over, and they are kept."""
    path = tmp_path / "campaign.csv"
    path.write_text(text := HEADER + rows, newline="")
    with pytest.raises(ValueError, match="not a campaign of this version") as caught:
        campaign(path, 0, lambda _: None, lambda: False)
    assert said in str(caught.value)
    assert path.read_bytes() == text.encode()


CHANGED = "row 2: changed, or of another version of this package); give another --output"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (",1.0,1.0,1.0,", ",1.0,1.5,1.0,"),
        ("1.0,", "1.00,"),
        ("2.5,", "2.5,it burst"),
        ("4,paper,closed loop", "10,paper,closed loop"),
        ("\r\n", "0\r\n"),
    ],
)
def test_a_row_that_has_changed_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], before: str, after: str
) -> None:
    """A digit, a failure, the rig or the seal itself: one line with row and file, code 2."""
    row = row_text(Verdict(4, *neighbourhood_and_drive(4), 0.1, *[1.0] * 5, 2.5, ""))
    assert before in row
    path = tmp_path / "campaign.csv"
    content = (HEADER + KNOWN + row.replace(before, after, 1)).encode()
    path.write_bytes(content)
    assert main(["--count", "5", "--output", str(path)], Quiet()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{path}: not a campaign of this version ({CHANGED}")
    assert path.read_bytes() == content


def test_a_row_of_another_version_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whose sources differ, though its columns do not: its figures would stand for this one's."""
    path = tmp_path / "campaign.csv"
    path.write_text(HEADER + KNOWN, newline="")
    assert [one.number for one in read_verdicts(path)] == [7]
    monkeypatch.setattr(module, "sources_digest", lambda *_: "another")
    with pytest.raises(ValueError, match=r"campaign\.csv: .*row 1: changed, or of another vers"):
        read_verdicts(path)


def test_all_that_a_verdict_depends_on_is_sealed() -> None:
    """What draws, runs and judges the rigs; what kernels depend on is in every digest."""
    folder = Path(module.__file__).parent
    assert (
        *(folder / name for name in ("judge.py", "radau.py", "random_rigs.py")),
        folder.parent / "simulation",
        folder.parent / "bare_rigs.py",
    ) == module._JUDGES
    assert all(place.exists() for place in module._JUDGES)


def test_a_worker_that_is_killed_is_told_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the system that is out of memory: one line, code 1; what is known stays."""

    def end_early(*_given: object) -> None:
        raise BrokenProcessPool("A process in the process pool was terminated abruptly")

    monkeypatch.setattr("rodless_lab.accuracy.campaign.campaign", end_early)
    assert main(["--count", "2", "--output", str(tmp_path / "rigs.csv")], Quiet()) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == "one of its processes was killed; the same command goes on\n"


def test_a_campaign_that_knows_nothing_leaves_its_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Interrupted before its first rig: tables of none do not replace those there are."""
    page = tmp_path / "rigs.md"
    page.write_text("10000 rigs")
    monkeypatch.setattr("rodless_lab.accuracy.campaign.judged", lambda *_: iter(()))
    assert main(["--count", "2", "--output", str(tmp_path / "rigs.csv")], Quiet()) == 1
    assert capsys.readouterr() == ("", "interrupted; the same command goes on\n")
    assert page.read_text() == "10000 rigs"


def test_more_rigs_than_have_a_number_are_refused_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line with value and bound, code 2, before a folder is made."""
    path = tmp_path / "folder" / "campaign.csv"
    assert main(["--count", "100000000000", "--output", str(path)], Quiet()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("count 100000000000 refused, must be 1000000000 or less")
    assert not path.parent.exists()


def test_the_numbers_of_many_rigs_take_no_memory(tmp_path: Path) -> None:
    """As many as there can be: those that are run next are taken, and no list of them all."""
    assert campaign(tmp_path / "campaign.csv", MOST_RIGS, lambda _: None, lambda: True) == []


def test_progress_counts_the_rigs_that_are_wanted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those of an earlier campaign among them, and none beyond; each that is known is not run."""

    def known(number: int) -> Verdict:
        return Verdict(number, *neighbourhood_and_drive(number), 0.1, *[1.0] * 6, "")

    path, told = tmp_path / "campaign.csv", list[int]()
    path.write_text(HEADER + KNOWN + row_text(known(1)), newline="")
    monkeypatch.setattr(module, "judged", lambda numbers, _: map(known, numbers))
    found = campaign(path, 4, told.append, lambda: False)
    assert [one.number for one in found] == [0, 1, 2, 3]
    assert told == [2, 3, 4]
    assert [one.number for one in read_verdicts(path)] == [7, 1, 0, 2, 3]


def test_a_full_disk_is_named_with_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, with code 2, before any rig is run."""
    path = tmp_path / "campaign.csv"
    with no_room():
        assert main(["--count", "1", "--output", str(path)], Quiet()) == 2
    assert capsys.readouterr().err == f"{path}: cannot be written: File too large\n"


def test_two_campaigns_in_one_file_are_told_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second is refused in one line, with code 2, and adds nothing to what the first has."""
    path = tmp_path / "campaign.csv"
    with path.open("w+") as first:
        first.write("number,aro")
        first.flush()
        lock_or_refuse(first.fileno(), path)
        assert main(["--count", "1", "--output", str(path)], Quiet()) == 2
    assert capsys.readouterr().err == (
        f"{path}: cannot be written: another process writes there; wait for its end, or give "
        "another --output\n"
    )
    assert path.read_text() == "number,aro"


@pytest.mark.parametrize("content", [b"time,position\n0,0\n", b"\xff\xfe\x00"])
def test_a_file_of_something_else_is_refused_and_kept(tmp_path: Path, content: bytes) -> None:
    """One line that names the file; nothing is written into it."""
    path = tmp_path / "run.csv"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"run\.csv: not a campaign .* give another --output"):
        campaign(path, 1, lambda _: None, lambda: False)
    assert path.read_bytes() == content


def test_the_summary_by_hand() -> None:
    """Of 1 to 101 µm the median is 51 µm; the disturbance explains what it makes a tenth of."""
    verdicts = [verdict(n, (n + 1) * 1e-6, 2e-6 if n == 100 else 20e-6) for n in range(101)]
    text = summary([*verdicts, verdict(101, math.nan, failure="it burst")])
    assert "| paper, open loop | 101 | 100% | 51 µm | 96 µm | 1e+02 µm |" in text
    assert "102 rigs, 1 not computed. 96 errors above 5 µm, 96 of them in open loop" in text
    assert "in 95 of them" in text
    assert "- rig 101: it burst" in text
    assert "| 100 | paper, open loop | 101 µm | 2 µm | 100 mm |" in text


def test_the_summary_says_why_radau_has_not_solved_a_rig() -> None:
    """It may take too long, or find no step: each reason is counted by itself."""
    late, stuck = "Radau: takes too long", "Radau: Required step size is less than spacing"
    failures = [late, stuck, late, ""]
    verdicts = [verdict(n, 1e-6, failure=one) for n, one in enumerate(failures)]
    reasons = f"- 2 not solved by {late}\n- 1 not solved by {stuck}\n"
    assert f"No rig was solved by Radau.\n{reasons}" in summary(verdicts)
    text = summary([*verdicts, verdict(4, 1e-6)._replace(radau_position=2e-6)])
    assert "1 rigs solved by Radau at 1e-10 too. The converged run is away from it by 50 %" in text
    assert f"100 %: 2 µm.\n{reasons}" in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--count", "0"], "'0' is not a positive whole number"),
        (["--count", "many"], "'many' is not a positive whole number"),
        (["--output", "rigs.md"], "'rigs.md' does not end in .csv"),
    ],
)
def test_arguments_that_cannot_be_are_refused(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 and a line with the argument; as .md, the tables would replace the figures."""
    with pytest.raises(SystemExit) as ended:
        main(arguments, Quiet())
    assert ended.value.code == 2
    assert words in capsys.readouterr().err
