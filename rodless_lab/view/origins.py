# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who may talk to the server: pages that it has sent itself, under a name of this machine.

A page from elsewhere could otherwise reach it through the user's browser, by its address or by a
name of its own that leads here.
"""

import ipaddress
import socket
from collections.abc import Awaitable, Callable, Iterable, Mapping, MutableMapping
from typing import Any
from urllib.parse import urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Any]]
Send = Callable[[Any], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

REFUSED = "refused: this server answers only its own pages, under a name of its own machine"


class OwnPagesOnly:
    """Passes on what comes from the server's own pages, and refuses the rest with 403."""

    def __init__(self, app: App, host: str) -> None:
        """Guard ``app``, which listens on ``host``."""
        self.app = app
        self._names = {"localhost", host.lower()}
        # A server on loopback is nobody's but this machine's.
        self._is_local = is_loopback(host)
        if not self._is_local:
            self._names |= {socket.gethostname().lower(), socket.getfqdn().lower()}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or let ``app`` do so."""
        if scope["type"] in ("http", "websocket") and not self.admits(scope.get("headers", ())):
            await _refuse(scope["type"], send)
        else:
            await self.app(scope, receive, send)

    def admits(self, headers: Iterable[tuple[bytes, bytes]]) -> bool:
        """Whether a request with these headers is one of our own pages'."""
        found: dict[bytes, list[str]] = {}
        for name, value in headers:
            found.setdefault(name.lower(), []).append(value.decode("latin-1").lower())
        hosts, origins = found.get(b"host", []), found.get(b"origin", [])
        if len(hosts) != 1 or len(origins) > 1 or not self._is_ours(hosts[0]):
            return False
        # A request for the page itself has no origin; a socket's, and whatever a page sends, has.
        if origins:
            return origins[0] in (f"http://{hosts[0]}", f"https://{hosts[0]}")
        return _is_asked_by_the_user(found)

    def _is_ours(self, host: str) -> bool:
        """Whether a Host header names this machine: an address cannot be made to lead here."""
        try:
            name = urlsplit(f"//{host}").hostname
        except ValueError:
            return False
        # No browser sends a user or a fragment here.
        if name is None or set(host) & set("@#?/\\"):
            return False
        return name in self._names or (is_loopback(name) if self._is_local else _is_address(name))


def _is_asked_by_the_user(headers: Mapping[bytes, list[str]]) -> bool:
    """Whether a browser asks without another site's page behind it, or follows a link of one.

    Such a page could load ours without end, unseen (W3C, Fetch Metadata Request Headers). Not every
    browser says where a request comes from, and none to a name that is not of its own machine.
    """
    site, mode, to = (
        headers.get(b"sec-fetch-" + name, [""])[0] for name in (b"site", b"mode", b"dest")
    )
    return site in ("", "none", "same-origin") or (mode, to) == ("navigate", "document")


def is_loopback(host: str) -> bool:
    """Whether a host is reached from this machine alone."""
    return host.lower() == "localhost" or (
        _is_address(host) and ipaddress.ip_address(host).is_loopback
    )


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


async def _refuse(kind: str, send: Send) -> None:
    if kind == "websocket":  # before it is accepted: the server answers 403
        await send({"type": "websocket.close", "code": 1008, "reason": REFUSED})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": REFUSED.encode()})
