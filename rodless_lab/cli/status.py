# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless status`: the state of a running rig, on one screen."""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from rodless_base.command_line import Parser
from rodless_base.start import Stop
from rodless_lab.cli.running_rig import add_namespace, add_timeout, with_rig

if TYPE_CHECKING:
    from rodless_lab.session.running_rig import RunningRig
    from rodless_lab.session.status import RigStatus


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Return 0 for a rig that is well, 1 where a node is missing or reports an error."""
    options = _parser().parse_args(arguments)
    return with_rig(options.namespace, stop, lambda rig: _status(rig, options))


def _parser() -> Parser:
    parser = Parser(
        prog="rodless status",
        description="Show the state of a running rig: its nodes, plant time, readings and "
        "diagnostics.",
        epilog="Exit code: 0 all is well, warnings of past faults included; 1 a node is missing, "
        "there twice, or reports an error, or Ctrl-C; 2 no such ROS domain or namespace.",
    )
    add_namespace(parser)
    parser.add_argument("--json", action="store_true", help="print JSON, in SI units")
    add_timeout(parser, "for both nodes to report", 8.0)
    return parser


def _status(rig: "RunningRig", options: argparse.Namespace) -> int:
    from rodless_lab.session.status import rig_status  # noqa: PLC0415  imports ROS

    status = rig_status(rig, options.timeout)
    if options.json:
        print(json.dumps(asdict(status), indent=2))
    else:
        print("\n".join(screen(status)))
    for problem in status.problems:
        print(problem, file=sys.stderr)
    missing = [name for name, node in status.nodes.items() if node.level == "missing"]
    for line in dict.fromkeys(rig.unreported(name, options.timeout) for name in missing):
        print(line, file=sys.stderr)
    return 0 if status.is_well else 1


def screen(status: "RigStatus") -> list[str]:
    """Return the lines of the screen."""
    rows = [
        ("rig", f"{status.namespace}{_state(status)}"),
        *((name, f"{node.level}: {node.message}") for name, node in status.nodes.items()),
        *(_plant_rows(status) if status.nodes["plant"].values else ()),
    ]
    return [f"{label:14}{text}" for label, text in rows]


def _state(status: "RigStatus") -> str:
    values = status.nodes["plant"].values
    if not values:
        return ""
    if status.has_ended:
        state = "ended: time.duration is over, rodless reset begins anew"
    elif status.is_running:
        state = "running"
    else:
        state = "paused" if status.is_paused else "standing still"
    return f", {values.get('mode', 'unknown mode')}, {state}"


def _plant_rows(status: "RigStatus") -> list[tuple[str, str]]:
    values, readings = status.nodes["plant"].values, status.readings
    atmosphere = status.atmosphere
    return [
        ("plant time", _number(readings["time"], "s")),
        ("speed factor", values.get("speed factor", "-")),
        ("lag", f"{values.get('lag (s)', '-')} s"),
        ("overruns", values.get("overruns", "-")),
        *(("faults", values[name]) for name in ("faults",) if name in values),
        ("position", _number(readings["position"], "mm", 1e3)),
        ("reference", _number(readings["reference"], "mm", 1e3)),
        ("valve voltage", _number(readings["voltage"], "V")),
        ("chamber A", _pressure(readings["pressure_a"], atmosphere)),
        ("chamber B", _pressure(readings["pressure_b"], atmosphere)),
        ("supply", _pressure(readings["supply_pressure"], atmosphere)),
    ]


def _number(value: float | None, unit: str, factor: float = 1.0) -> str:
    return "-" if value is None else f"{value * factor:.3f} {unit}"


def _pressure(value: float | None, atmosphere: float) -> str:
    if value is None:
        return "-"
    gauge = (value - atmosphere) * 1e-6
    return f"{gauge:.3f} MPa gauge, {value * 1e-6:.3f} MPa absolute"
