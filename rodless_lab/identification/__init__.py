# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Identification: from measured runs to the rig's parameters, with honest intervals."""

from rodless_lab.identification.bristles.fit import BristleFit, identify_bristles
from rodless_lab.identification.estimate import Estimate
from rodless_lab.identification.friction.auxiliary_lines import AuxiliaryLines, auxiliary_lines
from rodless_lab.identification.friction.curve import Stribeck, friction_force, turning_points
from rodless_lab.identification.friction.fit import DirectionFit, FrictionFit, fit_friction
from rodless_lab.identification.friction.run import friction_points, identify_friction
from rodless_lab.identification.friction.stick_slip import StickSlipEvents, stick_slip_events
from rodless_lab.identification.friction.uniform_motion import (
    UniformPart,
    UniformSearch,
    uniform_parts,
)
from rodless_lab.identification.pressures.chambers import identify_chambers
from rodless_lab.identification.pressures.fit import PressureFit
from rodless_lab.identification.pressures.heat import identify_heat
from rodless_lab.identification.pressures.leaks import identify_leaks
from rodless_lab.identification.pressures.spool import identify_spool
from rodless_lab.identification.pressures.valve import identify_valve
from rodless_lab.identification.valve_bench.area_curve import (
    AreaCurve,
    effective_area,
    fit_area_curve,
    three_sines,
)
from rodless_lab.identification.valve_bench.flow_coefficient import (
    FlowCoefficientCurve,
    fit_flow_coefficient,
    flow_coefficient,
)
from rodless_lab.identification.verdict import Verdict
from rodless_lab.runs.measured_run import MeasuredRun, RunError, run_of_trace

__all__ = [
    "AreaCurve",
    "AuxiliaryLines",
    "BristleFit",
    "DirectionFit",
    "Estimate",
    "FlowCoefficientCurve",
    "FrictionFit",
    "MeasuredRun",
    "PressureFit",
    "RunError",
    "StickSlipEvents",
    "Stribeck",
    "UniformPart",
    "UniformSearch",
    "Verdict",
    "auxiliary_lines",
    "effective_area",
    "fit_area_curve",
    "fit_flow_coefficient",
    "fit_friction",
    "flow_coefficient",
    "friction_force",
    "friction_points",
    "identify_bristles",
    "identify_chambers",
    "identify_friction",
    "identify_heat",
    "identify_leaks",
    "identify_spool",
    "identify_valve",
    "run_of_trace",
    "stick_slip_events",
    "three_sines",
    "turning_points",
    "uniform_parts",
]
