# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What controllers with any law have in common: groups of parameters, each declared once."""

from collections.abc import Mapping
from typing import ClassVar

from rodless_base import frames
from rodless_base.constants import (
    CARRIAGE,
    CLOSED_VOLTAGE,
    MAXIMUM_VOLTAGE,
    MINIMUM_VOLTAGE,
    STROKE,
)
from rodless_base.parameters import Parameter, ParameterError, ParameterSet, declare

# What every law's command is kept within; the law knows it too, for its anti-windup.
OUTPUT = declare(
    Parameter(
        "controller.neutral_voltage",
        CLOSED_VOLTAGE,
        "V",
        "valve command for no flow; also the fail-safe command",
        "Zhang et al. 2022, 3.5",
        MINIMUM_VOLTAGE,
        MAXIMUM_VOLTAGE,
    ),
    Parameter(
        "controller.minimum_voltage",
        MINIMUM_VOLTAGE,
        "V",
        "lower limit of the command",
        "Festo MPYE",
        MINIMUM_VOLTAGE,
        MAXIMUM_VOLTAGE,
    ),
    Parameter(
        "controller.maximum_voltage",
        MAXIMUM_VOLTAGE,
        "V",
        "upper limit of the command",
        "Festo MPYE",
        MINIMUM_VOLTAGE,
        MAXIMUM_VOLTAGE,
    ),
)

# Names the law of the controller.
LAW = "controller.law"

NODE_PARAMETERS = declare(
    Parameter(
        LAW,
        "pid",
        "",
        "control law: one of this package by name, or a Law of your own as package.module:Class; "
        "while the node runs, one of this package, or the one that it was started with",
        "interface",
    ),
    Parameter(
        "controller.position_timeout",
        0.1,
        "s",
        "wall-clock time without a position after which the valve is commanded to neutral, 0 for "
        "never; of a simulated plant at least 0.5 s, and a paused or slow one is waited for",
        "judgement",
        0.0,
        60.0,
        in_runs=False,
    ),
    Parameter(
        "controller.recorders",
        0,
        "",
        "recorders to wait for: the node subscribes to positions once valve/voltage has this many "
        "subscribers and one more, and none of them misses the first command or term",
        "interface",
        0,
        100,
        fixed=True,
        in_runs=False,
    ),
    Parameter(
        "controller.joint",
        CARRIAGE,
        "",
        "name of the joint to control in joint_states, without frame_prefix",
        "interface",
        in_runs=False,
    ),
    *frames.PARAMETERS.values(),
)

REFERENCE = declare(
    Parameter(
        "reference.type",
        "setpoint",
        "",
        "setpoint: jump to each message; ramp, move: go there at a velocity, jerk-limited; "
        "step, sine: from these parameters alone",
        "interface",
        choices=("setpoint", "ramp", "move", "step", "sine"),
    ),
    Parameter(
        "reference.minimum",
        0.0,
        "m",
        "least position that a set-point, step or sine may ask for",
        "stroke of the cylinder",
        -1.0,
        10.0,
    ),
    Parameter(
        "reference.maximum",
        STROKE,
        "m",
        "greatest position that a set-point, step or sine may ask for",
        "stroke of the cylinder",
        -1.0,
        10.0,
    ),
    Parameter(
        "reference.start",
        0.0,
        "m",
        "position before the step",
        "Zhang et al. 2022, 6.2",
        -1.0,
        10.0,
    ),
    Parameter(
        "reference.target",
        0.058,
        "m",
        "position after the step",
        "Zhang et al. 2022, 6.2",
        -1.0,
        10.0,
    ),
    Parameter(
        "reference.at", 0.5, "s", "plant time of the step or sine's start", "interface", 0.0, 1e6
    ),
    Parameter("reference.centre", 0.1, "m", "centre of the sine", "mid-stroke", -1.0, 10.0),
    Parameter("reference.amplitude", 0.02, "m", "amplitude of the sine", "judgement", 0.0, 10.0),
    Parameter(
        "reference.frequency",
        0.381,
        "Hz",
        "frequency of the sine",
        "Zhang et al. 2022, 6.3",
        0.0,
        100.0,
    ),
    Parameter(
        "reference.velocity", 0.05, "m/s", "velocity of ramps and moves", "judgement", 1e-6, 10.0
    ),
    Parameter(
        "reference.acceleration", 0.5, "m/s²", "acceleration limit of moves", "judgement", 1e-6, 1e3
    ),
    Parameter(
        "reference.velocity_timeout",
        0.1,
        "s",
        "plant time for which the velocity of a command on joint_commands counts: then it is 0",
        "judgement",
        1e-3,
        60.0,
    ),
    Parameter("reference.jerk", 10.0, "m/s³", "jerk limit of moves", "judgement", 1e-6, 1e6),
)


class LawParameters(ParameterSet):
    """What one law is given: its own parameters and the limits of its output."""

    DECLARATIONS: ClassVar[dict[str, Parameter]] = OUTPUT
    NODE: ClassVar[str] = "controller"

    # The law these parameters are for, as ``controller.law`` names it.
    LAW_NAME: ClassVar[str] = ""

    def check_together(self) -> None:
        """Refuse limits that leave the neutral voltage outside."""
        low = self.number("controller.minimum_voltage")
        high = self.number("controller.maximum_voltage")
        neutral = self.number("controller.neutral_voltage")
        if not low < neutral < high:
            raise ParameterError(
                f"controller.neutral_voltage: {neutral:g} V refused, must lie between "
                f"controller.minimum_voltage ({low:g} V) and maximum_voltage ({high:g} V)"
            )

    @classmethod
    def own(cls, values: Mapping[str, object]) -> dict[str, object]:
        """Leave out what a file gives to the rest of the node, once checked, and to other laws."""
        from rodless_control.laws import without_other_laws  # noqa: PLC0415  laws import this

        rest = {**NODE_PARAMETERS, **REFERENCE}
        for name in values.keys() & rest.keys():
            rest[name].check(values[name])
        own = {name: value for name, value in values.items() if name not in rest}
        return without_other_laws(own, cls)

    @classmethod
    def unknown(cls, name: object) -> str:
        """Say that ``name`` is no parameter of the law, and whose it may be."""
        if name in NODE_PARAMETERS or name in REFERENCE:
            return (
                f"{name}: belongs to the controller node, not to its law; use ControllerParameters"
            )
        return super().unknown(name)
