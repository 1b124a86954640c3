# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The numbers of one joint, out of messages in any order of joints, and of other rigs' joints."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rodless_base.frames import joint_among
from rodless_base.one_line import listed
from rodless_lab.bags.reader import TopicMessages
from rodless_lab.runs.measured_run import RunError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class JointMessages:
    """The messages that carry one joint, and its place in each."""

    messages: TopicMessages
    places: Sequence[int]

    def values(self, field: str) -> Array:
        """Return position, velocity or effort, shape (n,): NaN where a message has none."""
        rows = [getattr(message, field) for message in self.messages.messages]
        return np.array(
            [
                row[place] if place < len(row) else np.nan
                for row, place in zip(rows, self.places, strict=True)
            ]
        )


def messages_of(messages: TopicMessages, joint: str) -> JointMessages | None:
    """Return the messages that carry ``joint``, None where none does.

    The name of the joint may have a prefix, one and the same in all messages. Each message orders
    its joints as its publisher does; what does not name this one is another publisher's, and left
    out. Raises RunError where several joints may be meant, and for messages without joints.
    """
    names = _names(messages)
    known = {name for one in names for name in one}
    name = joint_among(joint, tuple(known))
    if name is not None:
        chosen = [k for k, one in enumerate(names) if name in one]
        return JointMessages(messages.at(chosen), [names[k].index(name) for k in chosen])
    if several := sorted(name for name in known if name.endswith(joint)):
        raise RunError(
            f"{messages.topic.name}: {listed(several)} may each be the {joint}; record one rig "
            "alone"
        )
    return None


def joint_messages(messages: TopicMessages, joint: str) -> JointMessages:
    """Return :func:`messages_of`, or all messages where they have one joint alone, of any name.

    Raises RunError, with the joints that there are, where ``joint`` is not among several.
    """
    found = messages_of(messages, joint)
    if found is not None:
        return found
    names = set(_names(messages))
    alone = len(names) == 1 and len(next(iter(names))) <= 1
    if alone and all(len(message.position) <= 1 for message in messages.messages):
        return JointMessages(messages, [0] * len(messages))
    among = listed(sorted({name for one in names for name in one})) or "those without a name"
    raise RunError(f"{messages.topic.name}: no joint {joint!r} among {among}")


def _names(messages: TopicMessages) -> list[tuple[str, ...]]:
    if not hasattr(messages.messages[0], "name"):
        raise RunError(f"{messages.topic.name}: {messages.topic.type_name} has no joints")
    return [tuple(message.name) for message in messages.messages]


def joint_values(found: JointMessages, field: str) -> Array:
    """Return its :meth:`~JointMessages.values`; raises RunError where no message has any."""
    values = found.values(field)
    if np.isnan(values).all():
        raise RunError(f"{found.messages.topic.name}: its messages carry no {field}")
    return values
