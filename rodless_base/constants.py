# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Numbers and names that plant, controller and lab share; each is said here alone."""

NANOSECONDS_PER_SECOND = 1_000_000_000

# Multiplying by this and dividing by the above differ in the last bit.
SECONDS_PER_NANOSECOND = 1e-9

# Name of the joint in joint_states.
CARRIAGE = "carriage"

# Name of the piston's joint there, where it is a mass of its own.
PISTON = "piston"

# Name of the joint in valve/state.
SPOOL = "valve_spool"

# Standard atmosphere, Pa: what a gauge pressure counts from.
STANDARD_ATMOSPHERE = 101325.0

# Proportional valve MPYE-5-...-010-B (Festo data sheet): the range of its command, in V; it
# saturates beyond.
MINIMUM_VOLTAGE = 0.0
MAXIMUM_VOLTAGE = 10.0

# The command in V at which that valve is closed (Zhang et al. 2022, 3.5).
CLOSED_VOLTAGE = 5.08

# Stroke of the cylinder CY3R25-200 in m.
STROKE = 0.2


def absolute(gauge_pressure: float) -> float:
    """Return the absolute pressure in Pa of a gauge pressure in Pa."""
    return gauge_pressure + STANDARD_ATMOSPHERE


# Supply of the paper's step and sine (6.2, 6.3), Pa absolute; its reading is taken as gauge.
SUPPLY_PRESSURE = absolute(0.52e6)
