# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless rig`: plant and controller until Ctrl-C, for machines without `ros2 launch`."""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rodless_base.atomic_write import cannot_be_written, check_writable
from rodless_base.command_line import Parser, named_path
from rodless_base.parameter_file import preset_names
from rodless_base.parameters import ParameterError
from rodless_base.start import Stop
from rodless_lab.bags.default_bag import default_bag
from rodless_lab.cli.number import real
from rodless_lab.cli.running_rig import add_namespace
from rodless_lab.session.errors import HarnessError, InterruptedRunError, NodeDiedError
from rodless_sim import RigParameters
from rodless_sim.cylinder_series import sizes
from rodless_sim.instruments.instruments import SENSORS
from rodless_sim.scenario import scenario_parameter

if TYPE_CHECKING:
    from rodless_lab.session.processes import ProcessPlan, SessionProcesses

# How often the processes are polled, in wall-clock s.
POLL_SECONDS = 0.2


# What Ctrl-C promises, in wall-clock s; after it a process is killed. One that has a bag to close
# is given longer.
STOP_TIMEOUT = 2.0
CLOSE_TIMEOUT = 30.0


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Run the nodes; return 1 if one ends by itself, 2 for what cannot be started."""
    options = _options(arguments)
    # Here, so that help is quick and works without ROS.
    from rodless_lab.session.domain import full_namespace, named_domain  # noqa: PLC0415
    from rodless_lab.session.network import stay_on_this_machine  # noqa: PLC0415
    from rodless_lab.session.processes import run_rig  # noqa: PLC0415

    try:
        named_domain()
        full_namespace(options.namespace)
        if not options.network:
            stay_on_this_machine()
    except HarnessError as error:
        print(error, file=sys.stderr)
        return 2
    try:
        plan = _plan(options)
    except ParameterError as error:
        print(error, file=sys.stderr)
        return 2
    stop.from_now_on_wait()
    try:
        _check_free(plan, stop)
        timeout = STOP_TIMEOUT if plan.record is None else CLOSE_TIMEOUT
        with run_rig(plan, stop_timeout=timeout) as processes:
            _watch(processes, plan, stop)
        return _told_of_its_end(processes, plan)
    except InterruptedRunError:
        return 0
    except NodeDiedError as error:
        print(error, file=sys.stderr)
        return 1
    except (ParameterError, HarnessError) as error:
        print(error, file=sys.stderr)
        return 2


def _told_of_its_end(processes: "SessionProcesses", plan: "ProcessPlan") -> int:
    """Return 1, and say so, where a bag was not closed."""
    if plan.record is None or not processes["rig"].had_to_be_killed:
        return 0
    print(
        f"the rig did not end within {CLOSE_TIMEOUT:g} s and was killed; `rodless recover "
        f"{plan.record}` ends its bag",
        file=sys.stderr,
    )
    return 1


def _check_free(plan: "ProcessPlan", stop: Stop) -> None:
    from rodless_lab.session.running_rig import RunningRig  # noqa: PLC0415

    with RunningRig(plan.namespace, stop) as there:
        there.check_free(plan.own_nodes)


def _watch(processes: "SessionProcesses", plan: "ProcessPlan", stop: Stop) -> None:
    """Say when the nodes are ready and wait for ``stop``; raises NodeDiedError."""
    from rodless_lab.session.readiness import say_when_ready  # noqa: PLC0415

    def ended() -> bool:
        processes.check()
        return stop.requested

    say_when_ready(plan, stop, ended, lambda line: print(line, flush=True))
    while not ended():
        time.sleep(POLL_SECONDS)


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = Parser(prog="rodless rig", description=__doc__)
    parser.add_argument("--preset", default="paper", choices=preset_names())
    parser.add_argument(
        "--sensors",
        choices=("preset", *SENSORS),
        default="preset",
        help="as the preset has them (default), ideal, or as accurate as those of the paper",
    )
    parser.add_argument("--supply-pressure", type=real, metavar="PA", help="Pa, absolute")
    parser.add_argument(
        "--cylinder", metavar="MODEL", help="of the CY3R series, such as CY3R32-500"
    )
    add_namespace(parser)
    parser.add_argument(
        "--parameters", type=named_path, metavar="FILE", help="on top of the preset"
    )
    parser.add_argument(
        "--scenario",
        metavar="FILE",
        help="faults and other changes at given plant times; or the name of a scenario of the "
        "package, such as leak",
    )
    parser.add_argument("--truth", action="store_true", help="publish what is true, too")
    parser.add_argument(
        "--raw", action="store_true", help="publish the voltages of the instruments, too"
    )
    parser.add_argument(
        "--no-clock",
        action="store_true",
        help="leave /clock to another rig: this one tells its time on the clock of its namespace",
    )
    parser.add_argument("--lockstep", action="store_true", help="one period for each command")
    parser.add_argument("--without-controller", action="store_true", help="the plant alone")
    parser.add_argument("--one-process", action="store_true", help="both nodes in one process")
    parser.add_argument(
        "--network",
        action="store_true",
        help="let other machines find the rig, as ros2 run does; without it, it stays on this one, "
        "unless the environment says how far it reaches (such as ROS_AUTOMATIC_DISCOVERY_RANGE)",
    )
    parser.add_argument(
        "--record",
        nargs="?",
        type=named_path,
        const=default_bag(),
        metavar="BAG",
        help="record both, in one process, into a new bag (without BAG: named after the time)",
    )
    options = parser.parse_args(arguments)
    if options.record is not None and options.without_controller:
        parser.error("--record is for both nodes in one process; use `rodless record` here")
    try:
        _check(options)
    except (ParameterError, HarnessError) as error:
        parser.error(str(error))
    return options


def _check(options: argparse.Namespace) -> None:
    """Raise ParameterError or HarnessError for what no rig can be started with."""
    if options.cylinder is not None:
        sizes(options.cylinder)
    if options.parameters is not None:
        _check_file(options.parameters)
    if options.record is not None:
        _check_bag(options.record)


def _check_file(file: Path) -> None:
    try:
        cause = "" if file.is_file() else "no such file"
        if cause and file.exists():
            cause = "no file, but something else"
    except OSError as error:
        cause = f"cannot be read: {error.strerror}"
    if cause:
        raise HarnessError(f"--parameters {file}: {cause}")


def _check_bag(bag: Path) -> None:
    try:
        if bag.exists():
            raise HarnessError(f"--record {bag}: exists already; a bag is never written over")
        check_writable(bag.parent)
    except OSError as error:
        raise HarnessError(cannot_be_written(f"--record {bag}", error)) from error


def _plan(options: argparse.Namespace) -> "ProcessPlan":
    from rodless_lab.session.file_parameters import (  # noqa: PLC0415
        own_parameters,
        reference_maximum,
    )
    from rodless_lab.session.processes import ProcessPlan  # noqa: PLC0415

    plant: dict[str, object] = dict(SENSORS.get(options.sensors, {}))
    if options.supply_pressure is not None:
        plant["supply.pressure"] = options.supply_pressure
    for name in ("truth", "raw"):
        if getattr(options, name):
            plant[f"sensors.publish_{name}"] = True
    if options.scenario is not None:
        plant |= scenario_parameter(options.scenario)
    if options.no_clock:
        plant["time.publish_clock"] = False
    if options.lockstep:
        plant["time.mode"] = "lockstep"
    controller: dict[str, object] = {}
    file = options.parameters
    if options.cylinder is not None:
        plant["cylinder.model"] = options.cylinder
        of_file = own_parameters(file, options.namespace) if file else {"controller": {}}
        controller["reference.maximum"] = reference_maximum(sizes(options.cylinder).stroke, of_file)
    if file is None:
        # With a file the plan does so itself.
        RigParameters.preset(options.preset).with_values(plant)
    return ProcessPlan(
        options.preset,
        plant,
        None if options.without_controller else controller,
        parameter_file=file,
        namespace=options.namespace,
        one_process=(options.one_process or options.record is not None)
        and not options.without_controller,
        record=options.record,
    )
