"""`rodless identify`: from a bag of the rig's topics to a parameter file the plant loads."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rodless_base.atomic_write import atomic_write
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_lab.identification.friction.findings import friction_findings
from rodless_lab.identification.friction.run import identify_friction
from rodless_lab.identification.parameter_writer import Finding, parameter_text
from rodless_lab.identification.pressures.chambers import chambers_findings
from rodless_lab.identification.pressures.valve import valve_findings
from rodless_lab.runs.from_bag import read_run
from rodless_lab.runs.measured_run import MeasuredRun, RunError, UninformativeRunError
from rodless_sim import ParameterError, RigParameters
from rodless_sim.instruments.instruments import DATA_SHEET


def _friction(run: MeasuredRun, parameters: RigParameters) -> list[Finding]:
    return friction_findings(identify_friction(run, parameters))


SUBJECTS: dict[str, Callable[[MeasuredRun, RigParameters], list[Finding]]] = {
    "chambers": chambers_findings,
    "friction": _friction,
    "valve": valve_findings,
}


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Return 0 if a parameter was identified, 1 if none was, 2 for a bag that cannot be used."""
    options = _parser().parse_args(arguments)
    try:
        parameters = assumed_parameters(options.base, options.sensors)
        run = read_run(options.bag, options.namespace)
        run.check_absolute()
        findings = SUBJECTS[options.subject](run, parameters)
        if all(found.value is None for found in findings):
            _report(findings)
            print(f"{options.bag}: informs none of these; nothing was written", file=sys.stderr)
            return 1
        text = parameter_text(_title(options, run), findings)
        atomic_write(options.output, text)
    except (RunError, ParameterError) as error:
        text = str(error)
        named = text if str(options.bag) in text else f"{options.bag}: {text}"
        print(named, file=sys.stderr)
        return 1 if isinstance(error, UninformativeRunError) else 2
    except OSError as error:
        print(f"{options.output}: cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    _report(findings)
    print(f"written to {options.output}; the plant takes it with --params-file")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rodless identify",
        description="Identify parameters of a rig from a recorded run.",
        epilog="Topics read: joint_states, chamber_a/pressure, chamber_b/pressure, "
        "supply/pressure, valve/voltage. Pressures are absolute.",
    )
    parser.add_argument("subject", choices=sorted(SUBJECTS))
    parser.add_argument("bag", type=Path, metavar="BAG", help="folder of a rosbag2 bag")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE.yaml")
    parser.add_argument("--namespace", default="", help="of the rig's topics, such as /rig1")
    parser.add_argument(
        "--base",
        default="paper",
        metavar="PRESET|FILE",
        help="parameters taken as known: a preset or a parameter file (default: paper)",
    )
    parser.add_argument(
        "--sensors",
        choices=("data-sheet", "base", "ideal"),
        default="data-sheet",
        help="accuracy of the sensors: of the paper's (default), as in --base, or perfect",
    )
    return parser


def assumed_parameters(base: str, sensors: str) -> RigParameters:
    """Return what is taken as known; raises :class:`ParameterError` that names the file."""
    if base in preset_names():
        parameters = RigParameters.preset(base)
    else:
        try:
            parameters = RigParameters.from_file(base)
        except OSError as error:
            raise ParameterError(
                f"{base}: neither a preset ({', '.join(preset_names())}) nor a file that can be "
                f"read: {error.strerror}"
            ) from error
    if sensors == "base":
        return parameters
    if sensors == "data-sheet":
        return parameters.with_values(DATA_SHEET)
    return parameters.with_values(
        {name: RigParameters.DECLARATIONS[name].default for name in DATA_SHEET}
    )


def _title(options: argparse.Namespace, run: MeasuredRun) -> list[str]:
    return [
        f"Identified by `rodless identify {options.subject}` from {options.bag.resolve().name}: "
        f"{run.time[-1]:.1f} s, {len(run.time)} samples.",
        f"Intervals are 95 % confidence intervals; sensors: {options.sensors}; taken as known: "
        f"{Path(options.base).name}.",
    ]


def _report(findings: Sequence[Finding]) -> None:
    for found in findings:
        for label, estimate in found.estimates.items():
            shown = str(estimate) if found.value is not None else estimate.note
            note = f"  [{estimate.note}]" if found.value is not None and estimate.note else ""
            print(f"{found.name:34} {label:10} {shown}{note}")
