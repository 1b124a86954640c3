# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The topics that a storage file names, as its channels and schemas describe them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import yaml

from rodless_base.one_line import shown
from rodless_lab.bags.mcap_file.index import McapIndex
from rodless_lab.bags.metadata import BagError, BagTopic, DescriptionLoader

if TYPE_CHECKING:  # mcap_file, imported above, says how to get a library that is not there
    from mcap.records import Channel

# Of one topic, in characters: rosbag2 writes some 300 for each publisher.
_LONGEST_PROFILES = 100_000

# Of a bag in all, in characters, each text once: they are read in 20 s.
_LONGEST_PROFILES_IN_ALL = 2_000_000


class Profiles:
    """Profiles of quality of service by their text, which a bag repeats: each is parsed once."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Mapping[str, object], ...]] = {}
        self._length = 0

    def of(self, channel: "Channel") -> tuple[Mapping[str, object], ...]:
        """Return those of a channel; raises :class:`BagError`."""
        text = channel.metadata.get("offered_qos_profiles", "")
        if text not in self._known:
            self._check_length(channel, len(text))
            self._known[text] = _profiles(channel, text)
        return self._known[text]

    def _check_length(self, channel: "Channel", length: int) -> None:
        self._length += length
        if length > _LONGEST_PROFILES:
            what = f"of {length} characters, more than {_LONGEST_PROFILES}"
        elif self._length > _LONGEST_PROFILES_IN_ALL:
            what = (
                f"with which those of the bag have more than {_LONGEST_PROFILES_IN_ALL} characters"
            )
        else:
            return
        raise BagError(f"{shown(channel.topic)}: profiles of quality of service {what}")


def _profiles(channel: "Channel", text: str) -> tuple[Mapping[str, object], ...]:
    try:
        profiles = yaml.load(text, DescriptionLoader) or []
    except (yaml.YAMLError, ValueError, TypeError):
        profiles = text
    if not isinstance(profiles, list) or not all(isinstance(one, dict) for one in profiles):
        raise BagError(
            f"{shown(channel.topic)}: {shown(text[:40])} are no profiles of quality of service"
        )
    return tuple(profiles)


class RecordedTopics(dict[int, BagTopic]):
    """The topics that a storage file names, by channel, each made when it is first asked for.

    To ask raises :class:`BagError`, and KeyError for a channel that ``index`` does not hold.
    """

    def __init__(self, index: McapIndex, profiles: Profiles) -> None:
        """Read ``profiles`` with those of the bag's other files."""
        self._index, self._profiles = index, profiles

    def __missing__(self, number: int) -> BagTopic:
        channel = self._index.channels[number]
        schema = self._index.schemas.get(channel.schema_id)
        self[number] = BagTopic(
            name=channel.topic,
            type_name="" if schema is None else schema.name,
            type_hash=channel.metadata.get("topic_type_hash", ""),
            qos=self._profiles.of(channel),
            encoding=channel.message_encoding,
        )
        return self[number]


def recorded_topics(index: McapIndex, profiles: Profiles) -> list[BagTopic]:
    """Return the topic of each channel of a storage file; raises as :class:`RecordedTopics`."""
    topics = RecordedTopics(index, profiles)
    return [topics[number] for number in index.channels]
