# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A ROS domain of one's own on loopback, so that runs side by side do not hear each other.

Also: whether the domain and the namespace that a user names are valid, and which one a launch
file's nodes have.
"""

import errno
import os
import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager

from rodless_base.one_line import shown
from rodless_base.ros.shared_memory import RANGE
from rodless_lab.session.errors import HarnessError
from rodless_lab.session.network import LOOPBACK, this_machine

# Domain IDs above 101 run into the ephemeral ports of Linux (ROS 2 documentation, "The ROS
# domain ID"); 0 is everybody's default.
DOMAINS = range(1, 102)

# A claim holds one TCP port, which nobody can connect to: no two processes can, whoever runs them,
# and the kernel takes it back however a process ends. It belongs to the network that DDS sees, so
# that containers with networks of their own have domains of their own. DDS leaves it free: of a
# domain's 250 ports it takes the first two, and those from the eleventh on (DDSI-RTPS, 9.6.1.1).
FIRST_PORT, PORTS_OF_A_DOMAIN, CLAIMED_PORT = 7400, 250, 5

# The greatest ID whose ports exist: they are numbered up to 65535.
GREATEST_DOMAIN = 232

# Leaves room for the longest name of a topic or service in it.
LONGEST_NAMESPACE = 190

_NAMESPACE = re.compile(r"/?|(/?[A-Za-z_][A-Za-z0-9_]*)(/[A-Za-z_][A-Za-z0-9_]*)*/?")


def domain_environment(domain: int) -> dict[str, str]:
    """Environment variables that keep a process in ``domain``, on this machine."""
    return {"ROS_DOMAIN_ID": str(domain), **this_machine()}


def named_domain() -> int | None:
    """Return the domain that the environment names, None for the default.

    Raises HarnessError for one that does not exist.
    """
    text = os.environ.get("ROS_DOMAIN_ID")
    if not text:
        return None
    if not (text.isascii() and text.isdigit() and int(text) <= GREATEST_DOMAIN):
        raise HarnessError(
            f"ROS_DOMAIN_ID={text!r}: must be a whole number from 0 to {GREATEST_DOMAIN}"
        )
    return int(text)


def domain_to_join() -> int | None:
    """Return :func:`named_domain`; raises HarnessError too where nodes find nobody in any."""
    domain = named_domain()
    if os.environ.get(RANGE) == "OFF":
        raise HarnessError(f"{RANGE}=OFF: nodes find nobody, not even here; unset it")
    return domain


def full_namespace(namespace: str) -> str:
    """Return ``namespace`` with one slash before it; raises HarnessError for one ROS refuses."""
    if not _NAMESPACE.fullmatch(namespace):
        raise HarnessError(
            f"--namespace {shown(namespace)}: letters, digits, _ and / only, no digit after a /"
        )
    if len(namespace) > LONGEST_NAMESPACE:
        raise HarnessError(
            f"--namespace {shown(namespace)}: {len(namespace)} characters refused, must be at most "
            f"{LONGEST_NAMESPACE}, as topics have names of 247 at most"
        )
    return f"/{namespace.strip('/')}"


def namespace_of_nodes(pushed: str, given: str) -> str:
    """Return the namespace of nodes that are ``given`` one, from the root on, as launch_ros does.

    It is below that which PushRosNamespace has ``pushed``, unless it begins with a slash.

    Examples
    --------
    >>> namespace_of_nodes("/cell", "left"), namespace_of_nodes("/cell", "/left")
    ('/cell/left', '/left')
    >>> namespace_of_nodes("", "")
    '/'
    """
    below = given if given.startswith("/") else f"{pushed}/{given}"
    return "/" + below.strip("/")


@contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """Claim a domain that no other such block on this machine holds; yield its environment.

    Whoever runs them; the claim ends with the process, however that ends. Raises RuntimeError when
    all are taken, HarnessError where this machine has no loopback.
    """
    for domain in DOMAINS:
        claim = _claim(domain)
        if claim is not None:
            with claim:
                yield domain_environment(domain)
            return
    raise RuntimeError(
        f"all ROS domains {DOMAINS.start}-{DOMAINS.stop - 1} are in use: end other sessions, or "
        "tests that hang"
    )


def _claim(domain: int) -> socket.socket | None:
    claim = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    port = FIRST_PORT + PORTS_OF_A_DOMAIN * domain + CLAIMED_PORT
    try:
        claim.bind((LOOPBACK, port))
    except OSError as error:
        claim.close()
        if error.errno == errno.EADDRINUSE:
            return None
        raise HarnessError(
            f"{LOOPBACK} port {port}: cannot be claimed for a ROS domain: {error.strerror}; nodes "
            "need the loopback interface too"
        ) from error
    return claim
