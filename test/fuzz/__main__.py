# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Give the product odd inputs, from a seed, and judge how each ends.

Each target runs in a process of its own, one after the other, so that a crash, a hang or a leak is
one target's failure. `python test/fuzz --help` says how to run one, and one input again.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import worker

# Shares of the time; over DDS comes last.
SHARES = {
    "python": 0.25,
    "files": 0.1,
    "scenarios": 0.05,
    "studies": 0.05,
    "bags": 0.15,
    "view": 0.1,
    "nodes": 0.25,
    "dds": 0.05,
}

# How many inputs --smoke takes of each: the same in each run, within a minute.
SMOKE = {
    "python": 3000, "files": 200, "scenarios": 100, "studies": 100, "bags": 100, "view": 100,
    "nodes": 100, "dds": 40,
}  # fmt: skip

# Wall-clock s that a process may take beyond its time: importing, compiling, one last input.
ALLOWANCE = 1800.0


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python test/fuzz", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="for all targets (60)")
    parser.add_argument("--seed", type=int, default=1, help="another draws other inputs (1)")
    parser.add_argument("--target", choices=SHARES, action="append", help="only these")
    parser.add_argument("--first", type=int, default=0, help="number of the first input (0)")
    parser.add_argument("--count", type=int, help="how many inputs, instead of --seconds")
    parser.add_argument("--smoke", action="store_true", help="a few of each, always the same")
    parser.add_argument("--worker", type=Path, help=argparse.SUPPRESS)
    return parser.parse_args()


def fuzz(given: argparse.Namespace, target: str, seconds: float, count: int | None) -> bool:
    """Fuzz one target; print a line, and what it has found; return whether that is nothing."""
    # In memory where that can be: what is written here is also forced to the disk.
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="rodless-fuzz-", dir=memory) as folder:
        report = Path(folder) / "report.json"
        command = [sys.executable, str(Path(__file__).parent), "--worker", str(report)]
        command += ["--target", target, "--seconds", str(seconds), "--seed", str(given.seed)]
        command += ["--first", str(given.first)]
        command += ["--count", str(count)] if count is not None else []
        began = time.monotonic()
        try:
            done = subprocess.run(
                command,
                cwd=folder,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=(seconds if count is None else 36e3) + ALLOWANCE,
                check=False,
            )
            code, output = str(done.returncode), done.stdout + done.stderr
        except subprocess.TimeoutExpired as error:
            code, output = "none, it hangs", str(error.stderr)
        found = json.loads(report.read_text(encoding="utf-8"))
        elapsed = time.monotonic() - began
        print(
            f"{target:9} {found['inputs']:9} inputs {found['accepted']:9} accepted "
            f"{elapsed:8.0f} s {found['memory']:6} MB  seed {given.seed}",
            flush=True,
        )
        if not found["ended"]:
            print(f"  the process ended at input {found['next']}, exit code {code}\n{output}")
        for failure in found["failures"]:
            again = f"--target {target} --seed {given.seed} --first {failure['number']} --count 1"
            print(f"  {failure['text']}\n    changes: {failure['changes']}\n    again: {again}")
        return bool(found["ended"]) and not found["failures"]


def main() -> int:
    """Run what is asked for; return 1 where something was found."""
    given = arguments()
    counts = SMOKE if given.smoke else {}
    if given.worker is not None:
        worker.work(given)
        return 0
    targets = given.target or list(SHARES)
    whole = sum(SHARES[target] for target in targets)
    sound = [
        fuzz(given, target, given.seconds * SHARES[target] / whole, counts.get(target, given.count))
        for target in targets
    ]
    print("nothing found" if all(sound) else "FOUND something", flush=True)
    return 0 if all(sound) else 1


if __name__ == "__main__":
    sys.exit(main())
