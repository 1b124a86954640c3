# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Records a session into a bag, from sample 0 on."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rodless_base.topics import JOINT_STATES, OPTIONAL_TOPICS, RIG_TOPICS, VALVE_VOLTAGE
from rodless_lab.bags.ros.recorder import Recorder
from rodless_lab.bags.writer import BagWriter
from rodless_lab.session.errors import WaitTimeoutError
from rodless_lab.session.observer import Observer
from rodless_lab.session.samples import LostSampleError

# How long (wall-clock s) a session that ends waits for the next command in its bag, which has
# queues of its own.
CATCH_UP_TIMEOUT = 5.0


class SessionBag:
    """A recorder that runs while the session's observer spins."""

    def __init__(self, path: Path, topics: Sequence[str], observer: Observer) -> None:
        """Begin a bag of ``RIG_TOPICS`` and ``topics``; raises BagError if ``path`` exists."""
        self._writer = BagWriter(path)
        self._observer = observer
        self._recorder = Recorder(
            self._writer,
            # A plant waits for recorders on each of its topics, so all of them are recorded.
            [*RIG_TOPICS, *topics],
            optional=OPTIONAL_TOPICS,
            context=observer.context,
            use_global_arguments=False,
        )
        self._samples = self._recorder.node.resolve_topic_name(JOINT_STATES)
        observer.add_node(self._recorder.node)

    @property
    def ready(self) -> bool:
        """Whether every topic is being recorded."""
        return self._recorder.ready

    @property
    def missing(self) -> list[str]:
        """Topics that nobody publishes, once the rig publishes its own; none before."""
        missing = self._recorder.missing
        own = map(self._recorder.node.resolve_topic_name, RIG_TOPICS)
        return [] if set(own).intersection(missing) else missing

    def has(self, commands: int) -> bool:
        """Whether so many commands have been recorded."""
        return self._commands >= commands

    @property
    def _commands(self) -> int:
        topic = self._recorder.node.resolve_topic_name(VALVE_VOLTAGE)
        return self._recorder.received[topic]

    def catch_up(self, commands: int) -> None:
        """Wait until the bag has the commands that the session has heard.

        Raises LostSampleError where they do not come.
        """
        try:
            while not self.has(commands):
                more = self._commands + 1
                self._observer.wait(partial(self.has, more), "the next", CATCH_UP_TIMEOUT)
        except WaitTimeoutError as error:
            self.check()
            raise LostSampleError(
                f"the bag lacks commands that the session has heard: {error}"
            ) from error

    def close(self, has_begun: bool) -> None:
        """Record what has arrived and close the bag; remove it unless the run ``has_begun``.

        What else is recorded, such as the faults in force, may have had messages before.
        """
        try:
            self._observer.remove_node(self._recorder.node)
            self._recorder.close()
        finally:  # a second Ctrl-C costs what is on its way, and no bag
            self._writer.close()
            has_samples = bool(self._writer.counts.get(self._samples))
            # A failure to write says where the bag is.
            if not (has_begun or has_samples or self._writer.failure):
                self._writer.remove()

    def check(self) -> None:
        """Raise BagError if the bag cannot be written, LostSampleError if messages are missing."""
        if self._writer.failure is not None:
            raise self._writer.failure
        for topic, count in self._recorder.lost.items():
            raise LostSampleError(f"{count} messages of {topic} are missing in the bag")
