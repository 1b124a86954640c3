# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What pages show: one state in this process, whoever changes it and however many look."""

import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field

from rodless_base.constants import CLOSED_VOLTAGE, STANDARD_ATMOSPHERE, STROKE
from rodless_base.parameters import ParameterError
from rodless_lab.session.travel import BY_THEMSELVES
from rodless_lab.view.playback import Playback
from rodless_lab.view.samples import History, spool_of, value
from rodless_lab.view.valve_flows import EdgeFlows, ValveFlows
from rodless_lab.view.words import SLIP_DISTANCE

PLANT, CONTROLLER = "plant", "controller"


@dataclass(frozen=True)
class NodeState:
    """What a node says of itself; ``level`` is OK, WARN, ERROR or missing."""

    level: str = "missing"
    message: str = "not found yet"
    values: Mapping[str, str] = field(default_factory=dict)


class ViewState:
    """A rig as it is now, and what is played of bags."""

    def __init__(self, namespace: str = "/", live: bool = True) -> None:
        """Know nothing of the rig in ``namespace`` yet; without ``live`` there is none."""
        self.namespace = namespace
        self.live = live
        self.history = History()
        self.nodes = {PLANT: NodeState(), CONTROLLER: NodeState()}
        self.parameters: dict[str, dict[str, object]] = {PLANT: {}, CONTROLLER: {}}
        self.terms: tuple[str, ...] = ()
        self.target: float | None = None  # m, the last set-point heard,
        self.target_heard = 0.0  # at this time.monotonic()
        self.recording: str | None = None
        self.playback: Playback | None = None
        self.problem: str | None = None  # of the view itself
        self.unheard: str | None = None  # why nothing arrives of a rig that is there
        self._flows: ValveFlows | None = None
        self._lock = threading.Lock()

    def take_parameters(self, node: str, values: Mapping[str, object], whole: bool = False) -> None:
        """Take what a node's parameters are now; ``whole``: it has no others."""
        with self._lock:
            before = self.parameters[node]
            self.parameters[node] = dict(values) if whole else {**before, **values}
            if node == PLANT:
                self._flows = _valve_flows(self.parameters[PLANT])

    def parameter(self, name: str) -> object:
        """Return a parameter of either node, None where it is not known."""
        for values in self.parameters.values():
            if name in values:
                return values[name]
        return None

    def number(self, name: str, default: float) -> float:
        """Return a number among the parameters."""
        value = self.parameter(name)
        return float(value) if isinstance(value, int | float) else default

    @property
    def notice(self) -> str | None:
        """What stands above the drawing: what is wrong, or what is waited for."""
        if self.problem is None and self.live and not self.playback and self.history.last is None:
            return self.unheard or (
                f"waiting for a plant in {self.namespace}: one that starts for the first time "
                "compiles for a minute"
            )
        return self.problem

    @property
    def stroke(self) -> float:
        """Stroke in m."""
        return self.number("cylinder.stroke", STROKE)

    @property
    def atmosphere(self) -> float:
        """Absolute pressure (Pa) that the valve exhausts to."""
        return self.number("atmosphere.pressure", STANDARD_ATMOSPHERE)

    @property
    def closed_voltage(self) -> float:
        """The voltage (V) that closes the valve."""
        return self.number("valve.closed_voltage", CLOSED_VOLTAGE)

    @property
    def slip_distance(self) -> float:
        """Lag (m) of the carriage at which the magnets part."""
        return self.number("coupling.slip_distance", SLIP_DISTANCE)

    @property
    def takes_set_points(self) -> bool:
        """Whether the reference goes by set-points."""
        return self.parameter("reference.type") not in BY_THEMSELVES

    @property
    def paused(self) -> bool:
        """Whether plant time stands still by request."""
        return self.nodes[PLANT].values.get("paused") == "True"

    @property
    def enabled(self) -> bool:
        """Whether the controller controls, or would but for what is to be mended elsewhere.

        One whose law has failed does so when it is enabled anew.
        """
        said = self.nodes[CONTROLLER]
        return said.values.get("enabled") != "False" and "~/enable" not in said.message

    @property
    def time(self) -> float | None:
        """Plant time in s."""
        row = self.history.last
        return None if row is None else row[0]

    @property
    def speed_factor(self) -> float | None:
        """Plant s per wall-clock s, as far as the plant says."""
        return number_in(self.nodes[PLANT].values.get("speed factor"))

    def flows(self) -> EdgeFlows | None:
        """Return what flows past the valve's edges now, None where that is not known."""
        row = self.history.last
        if row is None or self._flows is None:
            return None
        spool, supply = spool_of(row), value(row, "supply_pressure")
        pressure_a, pressure_b = value(row, "pressure_a"), value(row, "pressure_b")
        if pressure_a is None or pressure_b is None or supply is None or spool is None:
            return None
        return self._flows.at(spool, pressure_a, pressure_b, supply)


def _valve_flows(parameters: Mapping[str, object]) -> ValveFlows | None:
    try:
        return ValveFlows(parameters)
    except (KeyError, ParameterError):  # a plant of another kind, or half of one's parameters
        return None


def number_in(text: str | None) -> float | None:
    """Return the finite number that a node gives in a text, None where it is none."""
    try:
        number = float(text) if text is not None else math.nan
    except ValueError:
        return None
    return number if math.isfinite(number) else None
