# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Queues and stamps of the rig's topics, whose names are in :mod:`rodless_base.topics`."""

from builtin_interfaces.msg import Time
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from rodless_base.constants import NANOSECONDS_PER_SECOND

# Samples a slow reader, such as a recorder on a busy disk, may fall behind before it loses any.
QUEUE_DEPTH = 1000

# Answers that may wait for a slow reader. A controller that may answer in real time cannot let one
# hold it back, and a lock-step plant waits for a reader of its samples only where that is so far
# behind: 5000 in the reader's queue and as many in the plant's, as Fast DDS has them.
ANSWERS_DEPTH = 10_000

# A queue that never drops: a reader that falls behind holds the sender back instead.
LOSSLESS = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)

# Of what is only looked at, nothing but the last counts.
LAST_ONE = QoSProfile(depth=1)

# Whoever comes later gets the last.
LATCHED = QoSProfile(
    depth=100,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


def set_stamp(stamp: Time, nanoseconds: int) -> None:
    """Put a time in ns into the ``stamp`` that a message was made with: a new one costs more."""
    stamp.sec, stamp.nanosec = divmod(nanoseconds, NANOSECONDS_PER_SECOND)


def stamp_nanoseconds(stamp: Time) -> int:
    """Return a stamp in ns."""
    return int(stamp.sec) * NANOSECONDS_PER_SECOND + int(stamp.nanosec)
