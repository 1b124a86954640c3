# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the drawing shows, in words: what is stuck, what slips, what is lost."""

from rodless_lab.view.samples import Row, spool_of, value
from rodless_sim import RigParameters

# Lag (m) at which the magnets part, of a rig that does not say it.
SLIP_DISTANCE = RigParameters().number("coupling.slip_distance")

# Nearer to its closed position the spool opens nothing that shows, in V.
CLOSED_BAND = 0.005


def is_lost(row: Row, slip_distance: float = SLIP_DISTANCE) -> bool:
    """Whether the piston is farther from the carriage than the magnets reach."""
    carriage, piston = value(row, "position"), value(row, "piston_position")
    if carriage is None or piston is None:
        return False
    return abs(piston - carriage) > slip_distance


def motion(row: Row, lost: bool = False, seized: bool = False) -> str:
    """Say of the carriage, and of a piston that is a mass of its own, whether they slip."""
    carriage = _slipping(value(row, "velocity"))
    if seized and carriage:
        carriage = "■ seized"
    piston = _slipping(value(row, "piston_velocity"))
    if not piston:
        return carriage
    words = f"carriage {carriage}; piston {piston}"
    return f"lost {words}" if lost else words


def _slipping(velocity: float | None) -> str:
    if velocity is None:
        return ""
    if velocity == 0.0:
        return "■ stuck"
    speed = abs(velocity * 1e3)
    digits = 2 if speed < 1.0 else 1
    return f"{'▶' if velocity > 0.0 else '◀'} slipping, {speed:.{digits}f} mm/s"


def valve(row: Row, closed_voltage: float, stuck: bool = False) -> str:
    """Say what the spool opens."""
    spool = spool_of(row)
    if spool is None:
        return ""
    away = spool - closed_voltage
    opened = "A fills, B empties" if away > 0.0 else "B fills, A empties"
    if abs(away) < CLOSED_BAND:
        opened = "closed"
    return f"spool stuck: {opened}" if stuck else opened
