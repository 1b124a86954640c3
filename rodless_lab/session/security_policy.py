# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The SROS2 policy of a rig: what its nodes publish, subscribe, serve and call, and nothing else.

The format is that of sros2's ``policy.xsd``, as ``ros2 security generate_policy`` writes it.
"""

from xml.etree import ElementTree

from rclpy.node import Node

VERSION = "0.2.0"

# Where `ros2 security` keeps the keys of a rig's nodes: one enclave for each.
ENCLAVES = "/rodless"

# Elements of a profile, with the method of a node that lists what stands in them.
RULES = (
    ("topic", "publish", "get_publisher_names_and_types_by_node"),
    ("topic", "subscribe", "get_subscriber_names_and_types_by_node"),
    ("service", "reply", "get_service_names_and_types_by_node"),
    ("service", "request", "get_client_names_and_types_by_node"),
)


def policy(observer: Node, nodes: list[str], namespace: str = "/") -> str:
    """Return the policy of ``nodes`` in ``namespace``, each of which ``observer`` must know."""
    root = ElementTree.Element("policy", version=VERSION)
    enclaves = ElementTree.SubElement(root, "enclaves")
    for node in nodes:
        path = f"{ENCLAVES}{namespace.rstrip('/')}/{node}"
        enclave = ElementTree.SubElement(enclaves, "enclave", path=path)
        profiles = ElementTree.SubElement(enclave, "profiles")
        profile = ElementTree.SubElement(profiles, "profile", ns=namespace, node=node)
        _add_rules(profile, observer, node, namespace)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _add_rules(profile: ElementTree.Element, observer: Node, node: str, namespace: str) -> None:
    for element, action, listing in RULES:
        names = sorted(name for name, _ in getattr(observer, listing)(node, namespace))
        if names:
            group = ElementTree.SubElement(profile, f"{element}s", {action: "ALLOW"})
            for name in names:
                ElementTree.SubElement(group, element).text = _expression(name, node, namespace)


def _expression(name: str, node: str, namespace: str) -> str:
    """Return a full name as policies have it: ``~/`` for the node's own, relative where it is."""
    place = namespace.rstrip("/")
    own = f"{place}/{node}/"
    if name.startswith(own):
        return f"~/{name.removeprefix(own)}"
    return name.removeprefix(f"{place}/") if name.startswith(f"{place}/") else name
