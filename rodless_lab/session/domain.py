"""A ROS domain of one's own on loopback, so that runs side by side do not hear each other.

Also: whether the domain and the namespace that a user names are valid.
"""

import fcntl
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from rodless_lab.session.errors import HarnessError
from rodless_lab.session.network import this_machine

# Domain IDs above 101 run into the ephemeral ports of Linux (ROS 2 documentation, "The ROS
# domain ID"); 0 is everybody's default.
DOMAINS = range(1, 102)

# The greatest ID whose ports exist: they are numbered up to 65535.
GREATEST_DOMAIN = 232

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


def full_namespace(namespace: str) -> str:
    """Return ``namespace`` with one slash before it; raises HarnessError for one ROS refuses."""
    if not _NAMESPACE.fullmatch(namespace):
        raise HarnessError(
            f"--namespace {namespace!r}: letters, digits, _ and / only, no digit after a /"
        )
    return f"/{namespace.strip('/')}"


@contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """Claim a domain that no other such block on this machine holds; yield its environment.

    The claim is a file lock, which the kernel drops when the process ends, however it ends.
    Raises RuntimeError when all are taken.
    """
    for domain in DOMAINS:
        lock = _claim(domain)
        if lock is not None:
            with lock:
                yield domain_environment(domain)
            return
    raise RuntimeError(f"all ROS domains {DOMAINS.start}-{DOMAINS.stop - 1} are in use")


def _claim(domain: int) -> TextIO | None:
    folder = Path(tempfile.gettempdir())
    path = folder / f"rodless_sim-{os.getuid()}-domain-{domain}.lock"
    lock = path.open("w", encoding="utf-8")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.close()
        return None
    return lock
