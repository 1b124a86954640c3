"""`rodless compare`: overlay two runs and report their differences as the paper does."""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from rodless_base.atomic_write import atomic_write
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_control import PidParameters
from rodless_lab.figures.comparison import comparison_picture
from rodless_lab.runs.comparison import QUANTITIES, Difference, common_time, difference
from rodless_lab.runs.from_bag import Setpoint, read_run_and_setpoint
from rodless_lab.runs.measured_run import MeasuredRun, RunError, run_of_trace
from rodless_lab.runs.resimulate import resimulate, rig_of
from rodless_lab.simulation.closed_loop import closed_loop
from rodless_sim import ParameterError, RigParameters


@dataclass(frozen=True)
class _Held:
    """Set-points held from when each is given; the first also before."""

    setpoint: Setpoint

    def sample(self, time: float) -> tuple[float, float]:
        """Return the set-point in force at ``time`` (s), and no velocity."""
        place = int(np.searchsorted(self.setpoint.time, time, side="right")) - 1
        return float(self.setpoint.position[max(place, 0)]), 0.0


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Return 0 once picture and numbers are written, 2 for a run that cannot be used."""
    options = _parser().parse_args(arguments)
    try:
        if not options.bag.exists() and str(options.bag) in preset_names():
            raise RunError(f"{options.bag}: a preset can only stand first; BAG must be a bag")
        second, setpoint = read_run_and_setpoint(options.bag, options.namespace)
        if options.first in preset_names() and not Path(options.first).exists():
            first = simulated(options.first, second, setpoint, options.drive)
        else:
            first, own = read_run_and_setpoint(options.first, options.namespace)
            first, second = aligned((first, own), (second, setpoint))
        code = _compare(options, first, second)
    except (RunError, ParameterError) as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{options.output}: cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rodless compare",
        description="Overlay two runs; differences are second minus first.",
        epilog=f"Presets: {', '.join(preset_names())}. A preset is simulated with what drove BAG.",
    )
    parser.add_argument("first", metavar="BAG_OR_PRESET")
    parser.add_argument("bag", type=Path, metavar="BAG")
    parser.add_argument("--output", type=Path, default=Path("results/compare"), help="folder")
    parser.add_argument("--namespace", default="", help="of the rig's topics, such as /rig1")
    parser.add_argument(
        "--drive",
        choices=("voltage", "setpoint"),
        default="voltage",
        help="what of BAG drives the preset: its recorded voltage, or its set-points (default: "
        "voltage)",
    )
    return parser


def simulated(preset: str, like: MeasuredRun, setpoint: Setpoint | None, drive: str) -> MeasuredRun:
    """Simulate ``preset`` from where ``like`` starts, at its supply pressure.

    Driven by the voltage of ``like``, or by its set-points through the preset's controller. Raises
    :class:`RunError` where those were not recorded, ParameterError for a supply no rig has.
    """
    if drive == "voltage":
        return resimulate(RigParameters.preset(preset), like)
    if setpoint is None:
        raise RunError("no set-points were recorded; compare with --drive voltage")
    parameters, start = rig_of(RigParameters.preset(preset), like)
    trace = closed_loop(
        parameters,
        PidParameters.preset(preset),
        _Held(setpoint),
        duration=float(like.time[-1]),
        period=like.period,
        position=start,
    )
    return run_of_trace(trace, parameters.number("supply.pressure"))


def aligned(
    first: tuple[MeasuredRun, Setpoint | None], second: tuple[MeasuredRun, Setpoint | None]
) -> tuple[MeasuredRun, MeasuredRun]:
    """Put two recordings on one time: by their first set-points, else by their starts."""
    (run, own), (other, others) = first, second
    if own is None or others is None:
        return run, other
    shift = others.time[0] - own.time[0]
    return replace(run, time=run.time + shift), other


def _compare(options: argparse.Namespace, first: MeasuredRun, second: MeasuredRun) -> int:
    time = common_time(first.time, second.time)
    if len(time) < 2:
        raise RunError("the two runs have no stretch of time in common")
    found = {
        name: difference(
            time,
            np.interp(time, first.time, getattr(first, name)),
            np.interp(time, second.time, getattr(second, name)),
        )
        for name in QUANTITIES
    }
    labels = (Path(options.first).name, options.bag.resolve().name)
    options.output.mkdir(parents=True, exist_ok=True)
    picture = comparison_picture(labels, (first, second), time)
    atomic_write(options.output / "compare.png", picture)
    values = {
        "first": labels[0],
        "second": labels[1],
        "duration": float(time[-1] - time[0]),
        "differences": {name: asdict(value) for name, value in found.items()},
    }
    atomic_write(options.output / "compare.json", json.dumps(values, indent=2) + "\n")
    print(table(labels, found))
    print(f"compare.json and compare.png are in {options.output}")
    return 0


def table(labels: tuple[str, str], found: dict[str, Difference]) -> str:
    """Return the differences as a table for people."""
    lines = [
        f"{labels[1]} minus {labels[0]}",
        f"{'':16}{'steady state':>16}{'largest':>14}{'at':>10}{'rms':>12}",
    ]
    for name, value in found.items():
        label, unit, factor = QUANTITIES[name]
        lines.append(
            f"{label:16}{value.steady * factor:16.3f}{value.largest * factor:14.3f}"
            f"{value.time:8.3f} s{value.rms * factor:12.3f} {unit}"
        )
    return "\n".join(lines)
