# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which set-points a running controller takes, as far as its parameters say."""

from collections.abc import Mapping

from rodless_control.setpoint import FROM_PARAMETERS

# Reference types that take none. No set of them: a stranger's parameter may be of any type.
BY_THEMSELVES = tuple(FROM_PARAMETERS)


def outside_travel(target: float, parameters: Mapping[str, object]) -> str:
    """Say so where a controller with these ``parameters`` does not take ``target`` (m).

    Empty where it does, or has no such limits and judges for itself.
    """
    low, high = parameters.get("reference.minimum"), parameters.get("reference.maximum")
    if not isinstance(low, float) or not isinstance(high, float) or low <= target <= high:
        return ""
    return (
        f"{target * 1e3:.12g} mm refused: the controller takes {low * 1e3:.12g} to "
        f"{high * 1e3:.12g} mm (reference.minimum, reference.maximum)"
    )
