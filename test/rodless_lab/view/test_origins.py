# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Who is answered by the server of the pages."""

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest

from rodless_lab.view.origins import OwnPagesOnly


async def _app(_scope: Any, _receive: Any, send: Any) -> None:
    await send({"type": "answered"})


def answers(host: str, kind: str, headers: Mapping[str, str | list[str]]) -> list[Any]:
    """Return what a server on ``host`` sends to a request."""
    given = [
        (name.encode(), value.encode())
        for name, values in headers.items()
        for value in ([values] if isinstance(values, str) else values)
    ]
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> None:
        raise AssertionError("nothing is read of a request that is refused")

    scope = {"type": kind, "headers": given}
    asyncio.run(OwnPagesOnly(_app, host)(scope, receive, send))
    return sent


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize(
    ("host", "headers"),
    [
        ("127.0.0.1", {"host": "127.0.0.1:8080"}),
        ("127.0.0.1", {"host": "localhost:8080", "origin": "http://localhost:8080"}),
        ("127.0.0.1", {"host": "[::1]:8080", "origin": "http://[::1]:8080"}),
        ("::1", {"host": "LOCALHOST:8080", "origin": "http://localhost:8080"}),
        ("0.0.0.0", {"host": "192.168.1.7:8080", "origin": "http://192.168.1.7:8080"}),
        ("rig.lab", {"host": "rig.lab:80", "origin": "http://rig.lab:80"}),
    ],
)
def test_pages_of_its_own_are_answered(host: str, headers: dict[str, str], kind: str) -> None:
    """By an address or a name of the machine, from a page of the same place or none."""
    assert answers(host, kind, headers) == [{"type": "answered"}]


@pytest.mark.parametrize(
    ("site", "mode", "dest", "answered"),
    [
        ("none", "navigate", "document", True),  # typed, or from the bookmarks
        ("same-origin", "no-cors", "script", True),  # our own page's parts
        ("cross-site", "navigate", "document", True),  # a link that the user follows
        ("same-site", "navigate", "document", True),
        ("cross-site", "no-cors", "image", False),
        ("cross-site", "no-cors", "empty", False),  # fetch() of any page
        ("same-site", "no-cors", "empty", False),  # of another server of this machine
        ("cross-site", "navigate", "iframe", False),
    ],
)
def test_a_foreign_page_does_not_load_ours_unseen(
    site: str, mode: str, dest: str, answered: bool
) -> None:
    """In a loop it would fill the server's memory: each page takes some for a minute."""
    headers = {
        "host": "127.0.0.1:8080",
        "sec-fetch-site": site,
        "sec-fetch-mode": mode,
        "sec-fetch-dest": dest,
    }
    first = answers("127.0.0.1", "http", headers)[0]
    assert first.get("status", 200) == (200 if answered else 403)


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"host": "rebound.example:8080"},
        {"host": "rebound.example:8080", "origin": "http://rebound.example:8080"},
        {"host": "127.0.0.1:8080", "origin": "http://elsewhere.example"},
        {"host": "127.0.0.1:8080", "origin": "http://127.0.0.1:9090"},
        {"host": "127.0.0.1:8080", "origin": "null"},
        {"host": "127.0.0.1:8080", "origin": ["http://127.0.0.1:8080", "http://a.example"]},
        {"host": ["127.0.0.1:8080", "a.example"]},
        {"host": "192.168.1.7:8080"},
        {"host": "127.0.0.1.a.example:8080"},
        {"host": "127.0.0.1@a.example:8080"},
        {"host": "a.example@127.0.0.1:8080"},
        {"host": "127.0.0.1:8080#a.example"},
        {"host": "127.0.0.1:8080/a"},
        {"host": "[::1"},
    ],
)
def test_others_are_refused(headers: dict[str, Any], kind: str) -> None:
    """A foreign page, a name that was made to lead here, and headers that contradict each other."""
    first = answers("127.0.0.1", kind, headers)[0]
    if kind == "http":
        assert (first["type"], first["status"]) == ("http.response.start", 403)
    else:
        assert first["type"] == "websocket.close"


def test_a_name_that_leads_to_an_open_server_is_refused_too() -> None:
    """On all addresses, too, a name must be this machine's."""
    headers = {"host": "rebound.example:8080", "origin": "http://rebound.example:8080"}
    assert answers("0.0.0.0", "websocket", headers)[0]["type"] == "websocket.close"


def test_what_is_no_request_passes() -> None:
    """The server's start and end have no headers."""
    assert answers("127.0.0.1", "lifespan", {}) == [{"type": "answered"}]
