# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A ROS node that records topics into a bag."""

import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from rodless_base.ros.diagnostics import steady_clock
from rodless_base.ros.in_process import DirectNode
from rodless_base.ros.lasting_topics import (
    DURATION,
    DURATION_AT_THE_END,
    LOOK_PERIOD,
    LastingTopics,
)
from rodless_base.ros.message_info import Info, take_waiting, with_info
from rodless_base.ros.unheard import has_unheard_publisher, unheard_text
from rodless_base.topics import PRESSURES, VALVE_STATE
from rodless_lab.bags.clock import WAITING, Arrival, BagClock, TimeBase, Timed, leading_time
from rodless_lab.bags.metadata import BagError, BagTopic
from rodless_lab.bags.ros.clock_watch import ClockWatch, silent_clock_text, torn_clock_text
from rodless_lab.bags.ros.expected_topic import ExpectedTopic
from rodless_lab.bags.ros.publisher_counters import PublisherCounters
from rodless_lab.bags.ros.qos import matching_profile, recorded_profile
from rodless_lab.bags.ros.rig_clock import rig_clock
from rodless_lab.bags.ros.topic_discovery import Offer, TopicDiscovery
from rodless_lab.bags.writer import BagWriter

CLOCK_TOPIC = "/clock"
CLOCK_TYPE = "rosgraph_msgs/msg/Clock"

# How often (s, wall clock) new topics are looked for and messages put out of a crash's reach.
PERIOD = 0.1

# Numbers of messages that go back so often are those of several publishers.
MANY_TURNS = 20

# A bag without a publisher of /clock for this long (ns, wall clock) gets wall-clock times.
CLOCK_TIMEOUT = 2_000_000_000


class Recorder:
    """Records ``topics``, or all that are not hidden, until :meth:`close`.

    It has a node rather than being one; whoever makes it spins :attr:`node`. Topics are taken up
    as they appear, with the quality of service their publishers offer; set-points, whose publisher
    may be gone the next moment, are listened to as soon as somebody else does. Where somebody
    publishes ``/clock``, the times in the bag are plant time (see :class:`BagClock`), of a rig in a
    namespace its own; elsewhere, or with ``wall_time``, they are those of the wall clock.
    :attr:`received` counts messages by topic, and :attr:`lost` those that a publisher sent between
    two of them and that never came.
    """

    def __init__(
        self,
        writer: BagWriter,
        topics: Sequence[str] = (),
        *,
        optional: Sequence[str] = (),
        wall_time: bool = False,
        on_topics: Callable[[list[str]], None] = lambda _: None,
        on_trouble: Callable[[str], None] = lambda _: None,
        on_failure: Callable[[], None] = lambda: None,
        **node_options: object,
    ) -> None:
        """Start looking for topics.

        ``optional`` topics are recorded besides where somebody publishes them.
        ``on_topics`` is told the topics being recorded once every wanted topic is, or something has
        come of it, and from then on those that join them. ``on_trouble`` is told in a line of
        topics of which nothing arrives, of those of a plant that several nodes publish, and of a
        clock that goes to and fro, or says nothing and so does not date the bag. ``on_failure`` is
        called when the bag cannot be written any more. ``node_options`` are rclpy's, such as
        ``context``.
        """
        self.node = DirectNode(
            "recorder", enable_rosout=False, start_parameter_services=False, **node_options
        )
        self._writer = writer
        names = [self.node.resolve_topic_name(topic) for topic in topics]
        self._wanted = set(names)
        further = [self.node.resolve_topic_name(topic) for topic in optional]
        self._optional = set(further) if names else set()
        # A launch file remaps it, in a namespace, to the clock of that rig.
        self._clock_topic = self.node.resolve_topic_name(CLOCK_TOPIC)
        clocks = [self._clock_topic, *filter(None, map(self._clock_of, names))]
        clocks = clocks if names and not wall_time else []
        self._discovery = TopicDiscovery(
            self.node, list(dict.fromkeys([*(further if names else ()), *names, *clocks]))
        )
        self._clock = BagClock(TimeBase.WALL if wall_time else TimeBase.UNKNOWN)
        self._subscriptions: dict[str, Subscription] = {}
        # Those that nobody has been seen to publish, and those that are in the bag.
        self._expected: dict[str, ExpectedTopic] = {}
        self._topics: list[str] = []
        self._counters: defaultdict[str, PublisherCounters] = defaultdict(PublisherCounters)
        self.received: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()
        self._on_topics = on_topics
        self._told: list[str] = []
        self._unheard = LastingTopics(partial(has_unheard_publisher, self.node))
        self._watch = ClockWatch()
        self._told_of_silent_clock = False
        self._on_trouble = on_trouble
        self._on_failure = on_failure
        self.node.create_timer(PERIOD, self._poll, clock=steady_clock())
        self.node.create_timer(LOOK_PERIOD, self._look, clock=steady_clock())
        self._subscribe_new()

    @property
    def topics(self) -> list[str]:
        """Topics being recorded."""
        return list(self._topics)

    @property
    def ready(self) -> bool:
        """Whether every wanted topic (or, without a list, some topic) is being recorded.

        A publisher may learn of it a moment later: it can see by ``get_subscription_count``.
        """
        topics = self._wanted or self._topics
        return bool(topics) and all(self._matched(topic) for topic in topics)

    @property
    def _has_begun(self) -> bool:
        """Whether each wanted topic is recorded, or something has come of a sender since gone."""
        topics = self._wanted or self._topics
        return all(self.received[topic] or self._matched(topic) for topic in topics)

    def _matched(self, topic: str) -> bool:
        subscription = self._subscriptions.get(topic)
        if subscription is None:
            return False
        publishers: int = self.node.count_publishers(topic)
        return 0 < publishers <= self.node.count_matched(subscription)

    def close(self) -> None:
        """Record what has arrived so far and destroy the node; the bag is still to be closed.

        Take the node out of its executor first.
        """
        now = time.time_ns()
        for subscription in self._subscriptions.values():
            take_waiting(subscription, now)
            self.node.deliver_waiting(subscription)
        self._write(self._clock.finish())
        self._look(DURATION_AT_THE_END)
        self.node.destroy_node()

    def _poll(self) -> None:
        self._subscribe_new()
        if self._clock.base is TimeBase.UNKNOWN and self._clock_is_missing():
            self._write(self._clock.finish())
        self._write(self._clock.poll())
        self._attempt(self._writer.flush)
        self._tell()

    def _tell(self) -> None:
        new = [topic for topic in self.topics if topic not in self._told]
        if new and (self._told or self._has_begun):
            self._told += new
            self._on_topics(new)

    def _look(self, duration: float = DURATION) -> None:
        silent = [topic for topic in self.topics if not self.received[topic]]
        if new := self._unheard.look(silent, duration):
            self._on_trouble(unheard_text(new))
        # Here, and not at once: the names of those who publish take a moment.
        if self._clock.base is not TimeBase.WALL and self._watch.look():
            self._on_trouble(torn_clock_text(self.node, self._clock_topic))
        if self._clock.gave_up and not self._told_of_silent_clock:
            self._told_of_silent_clock = True
            self._on_trouble(silent_clock_text(self._clock_topic, WAITING))

    @property
    def unheard(self) -> list[str]:
        """Topics that somebody publishes and of which nothing has arrived."""
        return [topic for topic in self._unheard.found if not self.received[topic]]

    @property
    def missing(self) -> list[str]:
        """Wanted topics that nobody has published yet."""
        return sorted(self._wanted.difference(self._topics))

    def _clock_is_missing(self) -> bool:
        timed_out = self._clock.waits_since(time.time_ns() - CLOCK_TIMEOUT)
        return timed_out and not self.node.count_publishers(self._clock_topic)

    def _subscribe_new(self) -> None:
        known = self._subscriptions.keys() - self._expected.keys()
        for offer in self._discovery.new_offers(known, self._expected):
            if offer.profiles:
                self._take_up(offer)
            else:
                self._expect(offer)

    def _take_up(self, offer: Offer) -> None:
        """Record what somebody publishes, as all its publishers offer it."""
        expected = self._expected.pop(offer.topic, None)
        profile = matching_profile(offer.profiles)
        if expected is None:
            self._subscribe(offer, self._receiver(offer), profile)
        elif not expected.serves(offer, profile):
            self.node.destroy_subscription(self._subscriptions[offer.topic])
            self._subscribe(offer, expected.without_repeats(self._receiver(offer)), profile)
        self._enter(offer, offer.profiles)

    def _expect(self, offer: Offer) -> None:
        """Listen to what nobody publishes yet; it enters the bag with its first message."""
        receive = self._receiver(offer)
        expected = self._expected[offer.topic] = ExpectedTopic(offer)

        def receive_first(data: bytes, info: Info) -> None:
            if self._expected.get(offer.topic) is expected:
                self._enter(offer, self._discovery.offered(offer.topic))
                expected.take(info)
            receive(data, info)

        self._subscribe(offer, receive_first, expected.profile)

    def _subscribe(
        self, offer: Offer, receive: Callable[[bytes, Info], None], profile: QoSProfile
    ) -> None:
        self._subscriptions[offer.topic] = self.node.create_subscription(
            offer.message_type, offer.topic, with_info(receive), profile, raw=True
        )

    def _enter(self, offer: Offer, offered: Iterable[QoSProfile]) -> None:
        """Announce a topic in the bag, unless that is done or it is only listened to."""
        if offer.topic not in self._topics and self._is_recorded(offer.topic):
            profiles = tuple(recorded_profile(profile) for profile in offered)
            self._writer.add_topic(BagTopic(offer.topic, offer.type_name, qos=profiles))
            self._topics.append(offer.topic)

    def _is_recorded(self, topic: str) -> bool:
        return not self._wanted or topic in self._wanted or topic in self._optional

    def _clock_of(self, topic: str) -> str:
        """Return the clock of a rig that has another one than the bag, else nothing."""
        clock = rig_clock(topic)
        return "" if clock == self._clock_topic else clock

    def _receiver(self, offer: Offer) -> Callable[[bytes, Info], None]:
        topic = offer.topic
        clock_of = self._clock_of(topic)
        is_bags_clock = topic == self._clock_topic
        is_clock = is_bags_clock or (topic == clock_of and offer.type_name == CLOCK_TYPE)
        recorded = self._is_recorded(topic)
        first_field = next(iter(offer.message_type.get_fields_and_field_types().values()), "")
        has_stamp = first_field == "std_msgs/Header"

        def receive(data: bytes, info: Info) -> None:
            received = info["received_timestamp"] or time.time_ns()
            # A publisher may send what is no time: DDS has a negative one for that.
            sent = max(info["source_timestamp"], 0) or received
            clock = leading_time(data) if is_clock else None
            if clock is not None and is_bags_clock:
                self._watch.take(clock)
            if not recorded:
                if clock is not None:
                    self._write(self._clock.tell(sent, clock, clock_of))
                return
            sequence = info["publication_sequence_number"] or 0
            self._count_lost(topic, sequence)
            arrival = Arrival(
                topic,
                data,
                sent,
                received,
                sequence,
                stamp=leading_time(data) if has_stamp else None,
                clock=clock,
                clock_of=clock_of,
            )
            dated = self._clock.put(arrival)
            if dated:
                self._write(dated)
            self.received[topic] += 1

        return receive

    def _count_lost(self, topic: str, sequence: int) -> None:
        counters = self._counters[topic]
        before = counters.turns
        missed = counters.take(sequence)
        # While several are there, a gap may be told of the wrong one.
        if missed and self.node.count_publishers(topic) <= 1:
            self.lost[topic] += missed
        if before < counters.turns == MANY_TURNS and _is_of_one_plant(topic):
            self._on_trouble(
                f"{topic}: several nodes publish on it, and the bag mixes what they say; stop all "
                "plants but one, and record anew"
            )

    def _write(self, messages: Iterable[Timed]) -> None:
        def write() -> None:
            for arrival, log_time, publish_time in messages:
                self._writer.write(
                    arrival.topic, arrival.data, log_time, publish_time, arrival.sequence
                )

        self._attempt(write)

    def _attempt(self, action: Callable[[], None]) -> None:
        """Report the first failure to write; the writer refuses everything after it."""
        failed_before = self._writer.failure is not None
        try:
            action()
        except BagError:
            if not failed_before:
                self._on_failure()


def _is_of_one_plant(topic: str) -> bool:
    """Whether ``topic`` is one that nobody but a plant publishes on."""
    return any(topic.endswith(f"/{own}") for own in (*PRESSURES.values(), VALVE_STATE))
