# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""What the server of the pages says of requests, which anybody on this machine may send."""

import logging
import subprocess
import sys

from rodless_lab.view import server
from rodless_lab.view.errors import ViewError
from rodless_lab.view.server_log import one_line_each

REQUEST = """
import http.client
from rodless_lab.view.server import Server

with Server(lambda: None, "127.0.0.1", 0) as server:
    connection = http.client.HTTPConnection(server.address.removeprefix("http://"))
    connection.request("GET", "/%00%1b[31mred")
    print(connection.getresponse().status)
"""


def test_a_path_is_logged_without_what_commands_a_terminal() -> None:
    """A NUL and an escape sequence come out spelt."""
    done = subprocess.run(
        [sys.executable, "-c", REQUEST], capture_output=True, timeout=120, check=True
    )
    assert done.stdout == b"404\n"
    assert rb"/\x00\x1b[31mred not found" in done.stderr
    assert not set(done.stderr) & (set(range(32)) - {ord("\n")})


NONSENSE = """
import json
import logging
import re
import time
import urllib.request
from websockets.sync.client import connect
from rodless_lab.view.server import Server

logged = []
handler = logging.Handler()
handler.emit = logged.append
for one in (handler, logging.StreamHandler()):
    logging.getLogger("asyncio").addHandler(one)

with Server(lambda: None, "127.0.0.1", 0) as server:
    page = urllib.request.urlopen(server.address, timeout=60).read().decode()
    host = server.address.removeprefix("http://")
    (client, *_) = re.findall(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}", page)
    path = f"/_nicegui_ws/socket.io/?EIO=4&transport=websocket&client_id={client}"
    path += "&next_message_id=0&document_id=d&tab_id=t"

    def say(*events):
        with connect(f"ws://{host}{path}", origin=server.address, proxy=None) as socket:
            socket.recv(60)
            socket.send("40")
            socket.recv(60)
            for event in events:
                socket.send(event)

    names = ("handshake", "event", "javascript_response", "ack", "log")
    odd = (None, 1, "x", [], {}, [[]], True, "\\0")
    say(*("42" + json.dumps([name, one]) for one in odd for name in names))
    for event in ("4", "9", "42[", "45", "451-[]"):
        say(event)
    for frame in ("", "\\0", "bx"):
        with connect(f"ws://{host}{path}", origin=server.address, proxy=None) as socket:
            socket.recv(60)
            socket.send(frame)
    deadline = time.monotonic() + 60.0
    while not logged and time.monotonic() < deadline:
        time.sleep(0.01)
    print(urllib.request.urlopen(server.address, timeout=60).status)
"""


def test_messages_that_are_none_are_counted_in_one_line() -> None:
    """Dozens of them make a line or two, no traceback, and the pages go on."""
    done = subprocess.run(
        [sys.executable, "-c", NONSENSE], capture_output=True, timeout=240, check=True
    )
    assert done.stdout == b"200\n"
    lines = done.stderr.decode().splitlines()
    assert any(
        "messages from a socket that were none of a page's, ignored: " in one for one in lines
    )
    assert len(lines) < 5, done.stderr.decode()


def test_an_error_of_our_own_keeps_its_traceback() -> None:
    """That is a fault to be found; of a library's the kind and the text are enough."""
    logger = logging.getLogger("asyncio")
    seen: list[logging.LogRecord] = []
    handler = logging.Handler()
    handler.emit = seen.append  # type: ignore[method-assign]
    logger.addHandler(handler)
    try:
        with one_line_each():
            for fail in (lambda: int("x"), lambda: int("y"), lambda: parsed_bound("x")):
                try:
                    fail()
                except (ValueError, ViewError):
                    logger.exception("failed\nhere")
    finally:
        logger.removeHandler(handler)
    assert [bool(record.exc_info) for record in seen] == [False, True]
    assert "ValueError: invalid literal for int() with base 10: 'x'" in seen[0].getMessage()
    assert seen[1].getMessage() == "failed here"


def parsed_bound(port: str) -> None:
    """Fail within the package."""
    server._bound(port, 0)
