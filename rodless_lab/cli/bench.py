"""`rodless bench`: what the kernels and the nodes cost on this machine."""

import argparse
import importlib.util
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.start import Stop


class _InterruptedError(Exception):
    """The user has asked to stop."""


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Print a table and write it as JSON; return 2 without psutil, 1 after Ctrl-C."""
    parser = argparse.ArgumentParser(prog="rodless bench", description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("results/bench/metrics.json"))
    output = parser.parse_args(arguments).output
    if importlib.util.find_spec("psutil") is None:
        print("rodless bench needs psutil: pip install 'rodless_sim[bench]'", file=sys.stderr)
        return 2
    stop.from_now_on_wait()
    try:
        figures = _measure(stop)
    except _InterruptedError:
        print("interrupted", file=sys.stderr)
        return 1
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    for name, value in figures.items():
        print(f"{name:66} {value:10.4g}")
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    return 0


def _measure(stop: Stop) -> dict[str, float]:
    # They load numba and ROS: not for help.
    from rodless_lab.benchmark.closed_loop import bench_closed_loop  # noqa: PLC0415
    from rodless_lab.benchmark.ros.nodes import bench_lockstep, bench_realtime  # noqa: PLC0415

    def check() -> None:
        if stop.requested:
            raise _InterruptedError

    figures = bench_closed_loop()
    check()
    for rate in (100.0, 500.0, 1000.0):
        figures |= bench_realtime(rate, check)
    for one_process in (False, True):
        figures |= bench_lockstep(one_process, check)
    return figures
