# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Output whose reader has left, or which nobody can write, ends no program."""

import os
import subprocess
import sys

# Prints a lot, and says on standard error that it got to its end.
PROGRAM = """
import sys
from rodless_base.output import Output
output = Output()
for k in range(20_000):
    print(k, flush=k % 1000 == 0)
print("caf\\u00e9 \\udcff \\u2192")
print("done", output.end(), file=sys.stderr)
"""


def run(redirection: str, **variables: str) -> tuple[int, str, str]:
    """Run the program in a shell with ``redirection``; return exit code, output and errors."""
    done = subprocess.run(
        ["bash", "-c", f'set -o pipefail; "$0" -c "$1" {redirection}', sys.executable, PROGRAM],
        capture_output=True,
        text=True,
        env={**os.environ, **variables},
        timeout=60,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def test_a_reader_who_leaves_is_no_failure() -> None:
    """All is done behind `head`, which has its line; nothing is said of it, exit code 0."""
    assert run("| head -n 1") == (0, "0\n", "done None\n")


def test_a_closed_output_is_no_failure() -> None:
    """Nor is a standard output, input or error that was closed from the start."""
    assert run(">&-") == (0, "", "done None\n")
    code, output, errors = run("<&- 2>&-")
    assert (code, output[:4], errors) == (0, "0\n1\n", "")


def test_a_full_disk_is_said_once() -> None:
    """The program gets to its end, and learns why its output is lost."""
    text = "done standard output: cannot be written: No space left on device\n"
    assert run(">/dev/full") == (0, "", text)


def test_what_an_encoding_cannot_say_is_written_with_backslashes() -> None:
    """A file name that is not UTF-8, or an arrow in Latin-1, is no traceback."""
    assert run("| tail -n 1")[1] == "café \\udcff →\n"
    latin = run("| tail -n 1 | iconv -f latin1 -t utf8", PYTHONIOENCODING="latin1")
    assert latin[:2] == (0, "café \\udcff \\u2192\n")


def test_what_is_closed_is_not_given_to_the_next_file() -> None:
    """A file opened later must not become the standard output of a child."""
    program = (
        "import os, subprocess, sys, tempfile\n"
        "from rodless_base.output import Output\n"
        "Output()\n"
        "with tempfile.TemporaryFile() as file:\n"
        "    subprocess.run(['echo', 'lost'], check=True)\n"
        "    sys.exit(file.seek(0, 2) + 10 * (file.fileno() < 3))\n"
    )
    done = subprocess.run(
        ["bash", "-c", '"$0" -c "$1" <&- >&-', sys.executable, program], timeout=60, check=False
    )
    assert done.returncode == 0


def test_a_pipe_that_does_not_block_loses_nothing() -> None:
    """Whoever made it so: the program waits until its reader has read."""
    script = f"import os; os.set_blocking(1, False)\n{PROGRAM}"
    process = subprocess.Popen(
        [sys.executable, "-c", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 0
    assert (len(output.splitlines()), errors) == (20_001, "done None\n")
