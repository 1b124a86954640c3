# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant as a ROS node: samples out, valve voltage in, parameters changeable while running."""

import sys
from collections.abc import Sequence
from functools import partial

from rclpy.event_handler import QoSSubscriptionMatchedInfo, SubscriptionEventCallbacks
from rclpy.logging import get_logger
from std_msgs.msg import Float64

from rodless_base.measurement import Measurement
from rodless_base.ros.cdr import unpack_float64
from rodless_base.ros.diagnostics import steady_clock
from rodless_base.ros.in_process import DirectNode
from rodless_base.ros.logs import log_through
from rodless_base.ros.message_info import Info, with_info
from rodless_base.ros.own_time import tell_time, without_clock_topic
from rodless_base.ros.parameters import RosParameters
from rodless_base.ros.process import check_arguments, run_node
from rodless_base.ros.profiles import settle_transports
from rodless_base.ros.publish import NOT_RECEIVED
from rodless_base.ros.topic_types import check_topic_types
from rodless_base.ros.topics import QUEUE_DEPTH
from rodless_base.start import Stop, StoppedError
from rodless_base.topics import VALVE_VOLTAGE
from rodless_sim.node.awake_clock import AwakeClock, RunningClock
from rodless_sim.node.command_publishers import CommandPublishers
from rodless_sim.node.engine import Engine
from rodless_sim.node.equations import Equations
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.node.plant_diagnostics import PlantDiagnostics
from rodless_sim.node.ready import ready_line
from rodless_sim.node.realtime import POLL_PERIOD, Realtime
from rodless_sim.node.sample_publishers import SamplePublishers
from rodless_sim.node.services import PlantServices
from rodless_sim.node.time_keeper import TimeKeeper
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.state import State
from rodless_sim.precompile import compile_changes, compile_unless_stopped
from rodless_sim.scenario import as_scenario
from rodless_sim.scenario_player import ScenarioPlayer
from rodless_sim.timing import nanoseconds


class PlantNode:
    """A rig in plant time, which the wall clock or the commands drive."""

    def __init__(self, stop: Stop | None = None, **node_options: object) -> None:
        """Settle and start; raises ParameterError for parameters that are no rig's.

        Where the equations have to be compiled first, ``stop`` ends that by StoppedError.
        """
        self.node = DirectNode(
            "plant", automatically_declare_parameters_from_overrides=True, **node_options
        )
        check_topic_types(self.node)
        self._clock = without_clock_topic(self.node)
        self._parameters = RosParameters(
            self.node, RigParameters, self._configure, refresh=self._follow_scenario
        )
        values = self._parameters.values
        self._publishers = SamplePublishers(self.node, values)
        scenario = as_scenario(values.text("time.scenario") or None)
        ahead = [values]
        if scenario is not None:
            # What it makes of the plant, too, before time runs.
            ahead += ScenarioPlayer(scenario, values).ahead(values)
        self._await_equations(ahead, stop)
        self._engine = Engine(values, self._publish, scenario, self._publishers.configure)
        self._equations = Equations(self.node.get_logger().info)
        self._equations.load(values, ahead)
        self._present = values
        # What of a run has been told: of its scenario, and why it stands still.
        self._resets = self._told = 0
        self._failure: str | None = None
        self._commands = self.node.create_subscription(
            Float64,
            VALVE_VOLTAGE,
            with_info(self._take_command),
            QUEUE_DEPTH,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(matched=self._connect),
        )
        clock = RunningClock()
        self._time = self._make_time_keeper(values, clock)
        self._diagnostics = PlantDiagnostics(
            self.node,
            self._parameters,
            self._engine,
            self._time,
            self._publishers,
            self._commands.topic_name,
            clock,
        )
        PlantServices(
            self.node,
            self._time,
            self._diagnostics.clear,
            self._diagnostics.announce,
            lambda: stop is not None and stop.requested,
        )
        self.node.make_safe = self._engine.fail
        self.node.create_timer(POLL_PERIOD, self._poll, clock=steady_clock())
        line = ready_line(values, self._publishers.topic, self._commands.topic_name)
        self.node.get_logger().info(line)

    def _await_equations(self, needed: Sequence[RigParameters], stop: Stop | None) -> None:
        """See that a request to stop need not wait for the compiler; the first is this rig's."""
        if stop is None:
            return
        try:
            compile_unless_stopped(needed[0], needed, stop, self.node.get_logger().info)
        except StoppedError:
            self.node.destroy_node()
            raise

    def close(self) -> None:
        """Stop the plant, give its readers time, and destroy the node."""
        self._time.close()
        self._equations.close()
        if not self._publishers.wait_for_readers(self.node.end_by):
            self.node.get_logger().warning(NOT_RECEIVED)
        self.node.destroy_node()

    def _make_time_keeper(self, values: RigParameters, clock: RunningClock) -> TimeKeeper:
        outbox = self._publishers.outbox
        if values.in_lockstep:
            timeout = values.number("time.command_timeout")
            commanders = CommandPublishers(self.node, self._commands.topic_name)
            matched = partial(self.node.count_matched, self._commands)
            return Lockstep(
                self._engine, timeout, self._ready, commanders, matched, outbox, AwakeClock()
            )
        wall_period = nanoseconds(values.number("time.period") / values.number("time.speed"))
        return Realtime(self._engine, wall_period, self._ready, outbox, clock)

    def _ready(self) -> bool:
        """Whether everybody listens whom the run must not start without."""
        values = self._parameters.values
        recorders = int(values.number("time.recorders"))
        # In real time without recorders, too: this polls whom the first sample goes to.
        listening = self._publishers.all_listen(recorders)
        return listening or not (recorders or values.in_lockstep)

    def _poll(self) -> None:
        tell_time(self._clock, self._engine.rig.nanoseconds)
        self._publishers.poll()
        self._time.poll()
        if self._time.paused and self._publishers.outbox.is_empty:
            # A paused simulation shows that it lives, and what time it is to whoever joins. Not
            # where a reader is held for: ticks would push its sample out of what waits.
            self._publishers.clock.publish(self._engine.rig.nanoseconds)
        self._follow_scenario()
        self._equations.poll()
        self._report_failure()
        self._diagnostics.poll()

    def _report_failure(self) -> None:
        """Say once why the plant stands still."""
        failure = self._engine.failure
        if failure is not None and failure != self._failure:
            self.node.get_logger().error(failure)
        self._failure = failure

    def _publish(self, seen: Measurement, state: State) -> None:
        self._publishers.publish(seen, state, lambda: self._engine.rig.truth)

    def _notice_reset(self) -> None:
        """Tell all of a new run; to be called before what there is to tell is looked at."""
        resets = self._engine.resets
        if resets != self._resets:
            self._resets, self._told, self._failure = resets, 0, None

    def _follow_scenario(self) -> None:
        """Show the parameters that the scenario has changed, and say which."""
        self._notice_reset()
        present, played = self._engine.rig.parameters, self._engine.rig.played
        if present is not self._present:
            self._present = present
            self._parameters.follow(present)
        for entry in played[self._told :]:
            self.node.get_logger().warning(f"scenario at {entry.text}")
        self._told = len(played)

    def _configure(self, values: RigParameters) -> None:
        changes = values.differences(self._parameters.values)
        self._equations.require(self._engine.rig, changes)
        self._engine.change(changes)

    def _connect(self, publishers: QoSSubscriptionMatchedInfo) -> None:
        self._time.connect(publishers.total_count)

    def _take_command(self, message: bytes, info: Info) -> None:
        self._time.receive(unpack_float64(message), info.get("publication_sequence_number"))


def load() -> None:
    """Load the compiled plant, so that the first sample does not wait for it."""
    log_through("plant")
    get_logger("plant").info("loading the compiled plant")
    paper = RigParameters()
    compile_changes(paper, [paper])


def main(stop: Stop) -> int:
    """Run the plant until ``stop``."""
    check_arguments("plant")
    settle_transports(sys.argv)
    load()
    return run_node(partial(PlantNode, stop), stop)
