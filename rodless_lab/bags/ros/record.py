# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Record topics until told to stop, in a process of its own or beside the nodes that publish."""

import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from rclpy.exceptions import InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_topic_name import validate_topic_name

from rodless_base.one_line import shown
from rodless_base.ros.process import RunningNode, run_nodes
from rodless_base.start import Stop
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.ros.recorder import Recorder
from rodless_lab.bags.writer import BagWriter

# With a slash before it; ROS 2 keeps 8 of 255 characters for itself.
LONGEST_TOPIC = 246


def check_topic_name(text: str) -> str:
    """Return ``text``; raises ValueError where it is no topic name."""
    if len(text) > LONGEST_TOPIC:
        raise ValueError(f"{shown(text)} is no topic name: longer than {LONGEST_TOPIC} characters")
    try:
        validate_topic_name(text)
        # It overlooks repeated slashes, and a substitution that there is not.
        validate_full_topic_name(expand_topic_name(text, "recorder", "/"))
    except (InvalidTopicNameException, ValueError) as error:
        # What it is comes first, and then the place.
        cause = str(error).splitlines()[0].partition(", at /")[0].rstrip(":")
        raise ValueError(f"{shown(text)} is no topic name: {cause}") from error
    return text


def record(
    path: Path,
    topics: Sequence[str],
    stop: Stop,
    wall_time: bool = False,
    optional: Sequence[str] = (),
    beside: Sequence[Callable[[], RunningNode]] = (),
) -> int:
    """Record ``topics`` into a new bag at ``path`` until ``stop``, and print what comes of it.

    ``optional`` topics are recorded besides where somebody publishes them.
    ``beside`` makes nodes that share the process: what they publish reaches the bag without the
    middleware, where that can be kept from delivering inside the process. Returns 2 for a bag that
    cannot be begun, 1 for one that is not whole, lacks topics that were published, or a node that
    cannot be made.
    """
    # From here on there is a bag to close, whenever the request to stop comes.
    stop.from_now_on_wait()
    try:
        writer = BagWriter(path)
    except BagError as error:
        print(error, file=sys.stderr)
        return 2
    if not beside:
        print(
            f"{writer.path}: waiting for {', '.join(topics) or 'topics'}, until Ctrl-C", flush=True
        )
    recorders: list[Recorder] = []

    def end() -> None:
        stop.requested = True

    def make() -> Recorder:
        recorders.append(
            Recorder(
                writer,
                topics,
                optional=optional,
                wall_time=wall_time,
                on_topics=_tell_topics,
                on_trouble=partial(print, file=sys.stderr),
                on_failure=end,
            )
        )
        return recorders[0]

    with writer:
        # The recorder first: it is closed last, and has the last that the others send.
        code = run_nodes([make, *beside], stop, end_anyway=None)
    if code and not any(writer.counts.values()):  # the start was refused, and that is told
        writer.remove()
        return code
    # At once: who reads both streams wants it before what is missing.
    print(f"{sum(writer.counts.values())} messages in {writer.path}", flush=True)
    for recorder in recorders:
        _tell_what_is_missing(recorder)
    if writer.failure is not None:
        print(writer.failure, file=sys.stderr)
        return 1
    return code or int(any(recorder.unheard for recorder in recorders))


def _tell_topics(new: list[str]) -> None:
    print(f"recording {', '.join(new)}", flush=True)


def _tell_what_is_missing(recorder: Recorder) -> None:
    for topic in recorder.missing:
        print(f"{topic}: nobody published it", file=sys.stderr)
    for topic, count in recorder.lost.items():
        print(f"{topic}: {count} messages lost on the way", file=sys.stderr)
