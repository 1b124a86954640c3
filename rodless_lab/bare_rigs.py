# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The rigs of the paper's equations alone: air, valve and cylinder, read by ideal instruments.

Other solvers can compute them too. ``paper`` is the preset; ``saturating`` has friction that bends
above creep speed, and gains for it.
"""

from types import MappingProxyType

from rodless_control import PidParameters
from rodless_sim import RigParameters

BARE_RIGS = ("paper", "saturating")

SATURATING_PLANT = MappingProxyType({"friction.form": "saturating"})
SATURATING_CONTROLLER = MappingProxyType(
    {
        "controller.kp": 400.0,
        "controller.ki": 45.0,
        "controller.kd": 25.0,
        "controller.feedforward": 36.0,
        "controller.filter_bandwidth": 375.0,
        "controller.integral_zone": 2.3e-3,
        "controller.error_dead_band": 7e-5,
        "controller.dead_zone_voltage": 0.24,
        "controller.dead_zone_width": 0.03,
    }
)


def bare_rig(name: str) -> RigParameters:
    """Return the parameters of one of ``BARE_RIGS``."""
    return RigParameters(SATURATING_PLANT if name == "saturating" else {})


def bare_pid(name: str) -> PidParameters:
    """Return the controller's, tuned for it."""
    return PidParameters(SATURATING_CONTROLLER if name == "saturating" else {})
