# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The integral of the error, near the target only, and never against a limit.

    İ = gain·e   while |e| < zone, not parked, and the command not at a limit that I pushes against

Beyond the zone I only unwinds, at the pace of the zone's edge, while it pushes away from the
target.
The law's own form of conditional integration: see ``saturation``. ``saturated`` is that of the
sample before, as the command is not known yet; the difference is one sample's growth.
"""

from typing import NamedTuple

from rodless_base.kernels import kernel
from rodless_base.parameters import Parameter, ParameterSet, declare
from rodless_control.laws.parts.saturation import held_at_limit, unwound


class Integrator(NamedTuple):
    """Constants of the integral, which is in the unit of effort of the law."""

    gain: float  # per m·s
    zone: float  # m

    @classmethod
    def of(cls, parameters: ParameterSet, law: str) -> "Integrator":
        """Return the constants that ``law`` is given by ``parameters``."""
        return cls(
            parameters.number(f"{law}.integral_gain"), parameters.number(f"{law}.integral_zone")
        )


def declared(law: str, unit: str, gain: float, zone: float, source: str) -> dict[str, Parameter]:
    """Return the part's parameters as those of ``law``, whose effort is in ``unit``: V or N."""
    return declare(
        Parameter(f"{law}.integral_gain", gain, f"{unit}/(m·s)", "integral gain", source, 0.0, 1e6),
        Parameter(
            f"{law}.integral_zone",
            zone,
            "m",
            "error beyond which the integrator only unwinds",
            source,
            0.0,
            10.0,
        ),
    )


@kernel
def integrated(
    integrator: Integrator, integral: float, error: float, saturated: float, interval: float
) -> float:
    """Integral after ``interval`` s with ``error`` (m).

    ``saturated`` has the sign of the limit that the command was at, and is 0 between the limits.
    """
    if not abs(error) < integrator.zone:
        return unwound(integral, integrator.gain, integrator.zone, error, interval)
    return held_at_limit(integral, integral + integrator.gain * error * interval, saturated)
