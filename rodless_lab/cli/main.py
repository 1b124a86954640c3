# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The `rodless` command: one verb, one module with `main(arguments, stop) -> exit code`."""

import argparse
import importlib
import importlib.util
import os
import sys
from pathlib import Path

from rodless_base.command_line import Parser
from rodless_base.one_line import has_half_character
from rodless_base.output import Output
from rodless_base.ros.shared_memory import prepare_shared_memory
from rodless_base.start import NO_ROS, Stop

# Imported only when asked for, so that help is quick and Ctrl-C is caught during slow imports.
VERBS = {
    "demo": (
        "rodless_lab.cli.demo",
        "move the carriage over ROS, record a bag, measure and draw it",
    ),
    "rig": (
        "rodless_lab.cli.rig",
        "run plant and controller until Ctrl-C, without ros2 launch",
    ),
    "move": ("rodless_lab.cli.move", "move the carriage of a running rig to a position in mm"),
    "set": ("rodless_lab.cli.set_parameters", "change parameters of a running rig, all or none"),
    "fault": ("rodless_lab.cli.fault", "show, make and clear faults of a running rig"),
    "get": ("rodless_lab.cli.get_parameters", "show parameters of a running rig"),
    "status": ("rodless_lab.cli.status", "show the state of a running rig"),
    "pause": ("rodless_lab.cli.pause", "stop the plant time of a running rig"),
    "resume": ("rodless_lab.cli.resume", "let the plant time of a running rig run on"),
    "reset": ("rodless_lab.cli.reset", "return a running rig to its start"),
    "enable": ("rodless_lab.cli.enable", "let the controller of a running rig control"),
    "disable": ("rodless_lab.cli.disable", "close the valve and keep it closed"),
    "experiment": (
        "rodless_lab.cli.experiment",
        "repeat the paper's experiments beside what they report",
    ),
    "record": ("rodless_lab.cli.record", "record topics into a rosbag2 bag"),
    "recover": ("rodless_lab.cli.recover", "repair a bag whose recording was killed"),
    "drive": ("rodless_lab.cli.drive", "give a rig the voltages an identification needs"),
    "identify": ("rodless_lab.cli.identify", "find parameters of a rig from a recorded run"),
    "compare": ("rodless_lab.cli.compare", "overlay two runs and report their differences"),
    "replay": ("rodless_lab.cli.replay", "feed a bag's voltages to the plant and compare"),
    "animate": ("rodless_lab.cli.animate", "draw a run as a moving picture"),
    "bench": ("rodless_lab.cli.bench", "time the rig, other solvers and the nodes on this machine"),
    "laws": ("rodless_lab.cli.laws", "compare the control laws, yours among them, on random rigs"),
    "campaign": ("rodless_lab.cli.campaign", "show how exactly random rigs follow their equations"),
    "sweep": ("rodless_lab.cli.sweep", "run many rigs over parameters, into one data set"),
    "tune": ("rodless_lab.cli.tune", "find a law's parameters that do well on many rigs"),
    "policy": ("rodless_lab.cli.policy", "write the SROS2 policy of a running rig"),
    "soak": ("rodless_lab.cli.soak", "run the nodes for long; report memory, losses and balance"),
    "view": ("rodless_lab.cli.view", "show and steer a rig in the browser, and play bags"),
    "docs": ("rodless_lab.cli.docs", "write the generated pages and pictures of the docs"),
}


# Verbs that find a user's law in the folder where they are run, as the nodes of `rodless rig` do:
# there last, so that nothing takes the place of a library.
WITH_LAWS = ("laws", "set", "sweep", "tune")

# Verbs that run until Ctrl-C, and leave nothing undone if it comes before they do.
UNTIL_INTERRUPTED = ("rig", "view")


def main() -> None:
    """Run the verb on the command line and exit with its code, 1 where its output got lost."""
    output = Output()
    try:
        stop = Stop(1, "interrupted")
        code = _run(stop)
    except SystemExit as ended:  # after help, or a refusal of the command line
        code = ended.code
    failure = output.end()
    if failure is not None:
        print(failure, file=sys.stderr)
    sys.exit(code or int(failure is not None))


def _run(stop: Stop) -> str | int | None:
    parser = Parser(
        prog="rodless",
        description="A simulated pneumatic servo rig for ROS 2.",
        epilog="\n".join(f"  {verb:10} {summary}" for verb, (_, summary) in VERBS.items()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("verb", choices=VERBS, metavar="verb")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="see rodless VERB --help")
    chosen = parser.parse_args()
    try:
        Path.cwd()
    except OSError as error:  # neither Python's libraries nor relative paths get along with it
        parser.error(f"the folder in which this runs: {error.strerror}; go into another one")
    for text in chosen.arguments:
        # Neither ROS nor a bag takes another text.
        if has_half_character(text):
            parser.error(f"{text!a} is not text in UTF-8")
    if chosen.verb in WITH_LAWS and not getattr(sys.flags, "safe_path", False):
        sys.path.append(str(Path.cwd()))
    if chosen.verb in UNTIL_INTERRUPTED:
        stop.end_with(0)
    else:
        # They draw into files, and what is set for windows may not be installed.
        os.environ["MPLBACKEND"] = "agg"
    try:
        note = prepare_shared_memory()
    except RuntimeError as error:  # which the verbs without ROS get along with
        note = str(error)
    if note is not None:
        print(note, file=sys.stderr)
    try:
        module = importlib.import_module(VERBS[chosen.verb][0])
        code: int = module.main(chosen.arguments, stop)
    except ModuleNotFoundError as error:
        if "pip install" in str(error):  # a library that is missing, and not ROS
            print(error, file=sys.stderr)
        elif _is_there("rclpy"):
            raise
        else:
            print(NO_ROS, file=sys.stderr)
        code = 2
    return code


def _is_there(module: str) -> bool:
    """Whether a module can be imported."""
    try:
        return importlib.util.find_spec(module) is not None
    except ValueError:  # of one that is kept from being imported
        return False
