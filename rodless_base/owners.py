# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Which of the rig's nodes a parameter belongs to, by the first part of its name."""

# A file's section for all nodes (``/**``), or `ros2 param load`, gives each node the others'
# parameters too. Plant and controller do not import each other, so what they declare stands here
# a second time; a test compares.
GROUPS = {
    "plant": (
        "air",
        "atmosphere",
        "chambers",
        "coupling",
        "cylinder",
        "end_stop",
        "fault",
        "friction",
        "leak",
        "rail",
        "sensors",
        "supply",
        "time",
        "tubes",
        "valve",
    ),
    "controller": (
        "adrc",
        "cascade",
        "controller",
        "mode_switching",
        "reference",
        "sliding_mode",
        "state_feedback",
    ),
}

_OWNERS = {group: node for node, groups in GROUPS.items() for group in groups}


def owner(name: str) -> str | None:
    """Return the node that parameter ``name`` belongs to, or None where its name does not tell.

    Examples
    --------
    >>> owner("supply.pressure"), owner("reference.type"), owner("frame_prefix")
    ('plant', 'controller', None)
    """
    return _OWNERS.get(name.partition(".")[0])
