# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the plant reports of itself: how well it keeps up, whom it waits for, what went wrong."""

from rodless_base.fault_counts import WINDOW, lately_text
from rodless_base.ros.diagnostics import (
    ACTUAL_RATE,
    ATMOSPHERE,
    COMMANDED_BY,
    MODE,
    PERIOD,
    PRESET,
    SUBSCRIBERS,
    TARGET_RATE,
    Diagnostics,
    judge,
    steady_clock,
)
from rodless_base.ros.guarded_node import GuardedNode
from rodless_base.ros.parameters import RosParameters
from rodless_base.ros.publish import LOST
from rodless_base.ros.rivals import Rivals
from rodless_sim.node.awake_clock import RunningClock, StopNews
from rodless_sim.node.engine import Engine
from rodless_sim.node.fault_publisher import fault_status, faults_text
from rodless_sim.node.pace import PaceMeter, PaceNews
from rodless_sim.node.ready import preset_text
from rodless_sim.node.sample_publishers import SamplePublishers
from rodless_sim.node.time_keeper import TimeKeeper
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.state import State, piston_of
from rodless_sim.timing import nanoseconds

# The share of late periods above which they are a fault: an ordinary machine is late now and then.
TOLERATED_OVERRUNS = 0.01

# What the fault of late periods is called.
OVERRUNS = "overruns"


class PlantDiagnostics:
    """Reports once a second, and at once what the controller must know of."""

    def __init__(
        self,
        node: GuardedNode,
        parameters: RosParameters[RigParameters],
        engine: Engine,
        time: TimeKeeper,
        publishers: SamplePublishers,
        commands: str,
        clock: RunningClock,
    ) -> None:
        """Report of these from now on; ``commands`` is the topic's full name.

        ``clock`` is what ``time`` goes by, where it goes by one.
        """
        self._node = node
        self._parameters = parameters
        self._engine = engine
        self._time = time
        self._publishers = publishers
        self._rivals = Rivals(node, commands)
        self._diagnostics = Diagnostics(node, self._faults)
        values = parameters.values
        self._lockstep = values.in_lockstep
        self._period = values.number("time.period")  # s
        self._speed = values.number("time.speed")
        speed = 0.0 if self._lockstep else self._speed
        self._meter = PaceMeter(speed, nanoseconds(self._period), clock)
        self._stops = StopNews(clock)
        self._news = PaceNews(self._speed, self._period)
        self._pace = self._meter.report()
        self._announced: tuple[object, ...] = ()
        node.create_timer(PERIOD, self._report, clock=steady_clock())

    def clear(self) -> None:
        """Count faults from now on, and judge the pace anew."""
        self._diagnostics.clear()
        self._news.clear()

    def poll(self) -> None:
        """Follow plant time; to be called often."""
        self._meter.observe(self._engine.rig.nanoseconds, self._time.running)
        self.announce()

    def announce(self) -> None:
        """Report at once what the controller must know of: pauses, and whether samples are due.

        Faults that come and go, too; and a new subscriber of the samples is told.
        """
        faults = faults_text(self._engine.rig.parameters)
        lost = carriage_lost(self._engine.state) is not None
        state = (self._time.paused, self._time.running, self._publishers.listeners(), faults, lost)
        if state != self._announced:
            self._announced = state
            self._publish()

    def _report(self) -> None:
        self._take_pace()
        self._publishers.clock.check()
        if not self._lockstep:  # which says so itself, and holds
            self._rivals.check()
        self._publish()

    def _take_pace(self) -> None:
        self._pace = self._meter.report()
        stop = self._stops.hear()
        if stop is not None and self._time.running:
            self._node.get_logger().warning(stop)
        news = self._news.hear(self._pace)
        if news is not None and self._news.behind:
            self._node.get_logger().warning(news)
        elif news is not None:
            self._node.get_logger().info(news)

    def _publish(self) -> None:
        values = self._parameters.values
        faults = self._diagnostics.count()
        flow = self._engine.free_air_flow * 6e4
        self._diagnostics.publish(
            self._engine.rig.nanoseconds,
            self._judge(),
            {
                MODE: values.text("time.mode"),
                PRESET: preset_text(values),
                "paused": self._time.paused,
                TARGET_RATE: f"{self._target_rate:g}",
                ACTUAL_RATE: f"{self._pace.speed_factor / self._period:.3f}",
                "speed factor": f"{self._pace.speed_factor:.3f}",
                "lag (s)": f"{self._pace.lag:.3f}",
                "commands received": self._engine.command.received,
                SUBSCRIBERS: self._publishers.listeners(),
                COMMANDED_BY: self._rivals.everybody,
                **faults,
                "free-air supply flow (L/min)": f"{flow:.2f}",
                ATMOSPHERE: f"{values.number('atmosphere.pressure'):g}",
                "faults": faults_text(self._engine.rig.parameters),
            },
            (cylinder_name(values),),
            (fault_status(self._node, self._engine.rig.parameters),),
        )

    @property
    def _target_rate(self) -> float:
        """Samples due per wall-clock s; 0 where none is, as in lock-step."""
        if self._lockstep or not self._time.running:
            return 0.0
        return self._speed / self._period

    def _faults(self) -> dict[str, int]:
        """Return how often each fault has happened since the start."""
        command = self._engine.command
        return {
            "commands lost": command.timeouts,
            "commands not finite": command.not_finite,
            "commands clamped": command.clamped,
            OVERRUNS: self._time.overruns,
            LOST: self._publishers.outbox.lost,
        }

    def _judge(self) -> tuple[bytes, str]:
        # Nothing that a plant at its end lacks is a fault.
        ended = self._engine.ended and self._engine.failure is None
        state = "ended" if ended else "paused" if self._time.paused else None
        behind = self._news.behind and state is None
        return judge(
            None if ended else self._time.problem,
            state,
            (
                self._diagnostics.namesakes.problem,
                self._publishers.clock.problem,
                self._rivals.problem,
                "plant time falls behind" if behind else None,
                carriage_lost(self._engine.state),
                lately_text(self._faults_lately()),
            ),
            "running" if self._engine.command.received else "waiting for commands, valve closed",
        )

    def _faults_lately(self) -> dict[str, int]:
        lately = self._diagnostics.lately()
        periods = WINDOW * self._speed / self._period
        if lately.get(OVERRUNS, 0) <= TOLERATED_OVERRUNS * periods:
            lately.pop(OVERRUNS, None)
        return lately


def carriage_lost(state: State) -> str | None:
    """Say that the piston has left the carriage behind, and where both are; None if it has not."""
    if getattr(state, "coupled", 1.0) > 0.5:
        return None
    piston, _ = piston_of(state)
    return (
        f"carriage lost: it is at {state.position * 1e3:.1f} mm, the piston at "
        f"{piston * 1e3:.1f} mm"
    )


def cylinder_name(values: RigParameters) -> str:
    """Bore and stroke, as makers name cylinders."""
    bore, stroke = (values.number(f"cylinder.{name}") for name in ("bore", "stroke"))
    return f"cylinder {bore * 1e3:g}-{stroke * 1e3:g} mm"
