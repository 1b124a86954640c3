# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The lab: experiments in process and over ROS, bags, reports, and the `rodless` command."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rodless_lab.bags.reader import Bag, TopicMessages, read_bag
    from rodless_lab.runs.commands import Commands
    from rodless_lab.runs.from_bag import read_commands, read_run
    from rodless_lab.runs.measured_run import MeasuredRun
    from rodless_lab.simulation.closed_loop import ClosedLoopTrace, closed_loop
    from rodless_lab.simulation.design import Range
    from rodless_lab.simulation.draw import draw
    from rodless_lab.simulation.ensemble import Ensemble, ensemble
    from rodless_lab.simulation.linear_model import LinearModel
    from rodless_lab.simulation.linearise import linearise
    from rodless_lab.simulation.run_metrics import RunMetrics, run_metrics
    from rodless_lab.studies.sweep import sweep

__all__ = [
    "Bag",
    "ClosedLoopTrace",
    "Commands",
    "Ensemble",
    "LinearModel",
    "MeasuredRun",
    "Range",
    "RunMetrics",
    "TopicMessages",
    "closed_loop",
    "draw",
    "ensemble",
    "linearise",
    "read_bag",
    "read_commands",
    "read_run",
    "run_metrics",
    "sweep",
]

# Where each is. Loaded when asked for: the compiled loop takes half a second, bags need rclpy, and
# most of this package does without either.
_MODULES = {
    "Bag": "bags.reader",
    "ClosedLoopTrace": "simulation.closed_loop",
    "Commands": "runs.commands",
    "Ensemble": "simulation.ensemble",
    "LinearModel": "simulation.linear_model",
    "MeasuredRun": "runs.measured_run",
    "Range": "simulation.design",
    "RunMetrics": "simulation.run_metrics",
    "TopicMessages": "bags.reader",
    "closed_loop": "simulation.closed_loop",
    "draw": "simulation.draw",
    "ensemble": "simulation.ensemble",
    "linearise": "simulation.linearise",
    "read_bag": "bags.reader",
    "read_commands": "runs.from_bag",
    "read_run": "runs.from_bag",
    "run_metrics": "simulation.run_metrics",
    "sweep": "studies.sweep",
}


def __getattr__(name: str) -> object:
    """Load a public object from its module."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    """Return what is public."""
    return sorted(__all__)
