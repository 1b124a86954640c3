# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Connections to the pages that ask for nothing, and more of them than the process may have."""

import subprocess
import sys

import pytest
from extent import extensive

pytest.importorskip("nicegui")

IDLE = r"""
import re
import socket
import urllib.request
from websockets.sync.client import connect
from rodless_lab.view import connection
from rodless_lab.view.server import Server

def ended(host, before=b""):
    with socket.create_connection(host.split(":"), timeout=60) as idle:
        idle.sendall(before)
        if before:  # a first request, and its answer whole
            with idle.makefile("rb") as answer:
                (length,) = [int(line.split()[1]) for line in iter(answer.readline, b"\r\n")
                             if line.lower().startswith(b"content-length")]
                answer.read(length)
        idle.sendall(b"GET")
        try:
            return idle.recv(1) == b""
        except ConnectionResetError:
            return True

with Server(lambda: None, "127.0.0.1", 0) as server:
    page = urllib.request.urlopen(server.address, timeout=60).read().decode()
    (client, *_) = re.findall(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}", page)
    host = server.address.removeprefix("http://")
    path = f"/_nicegui_ws/socket.io/?EIO=4&transport=websocket&client_id={client}"
    with connect(f"ws://{host}{path}", origin=server.address, proxy=None) as page:
        page.recv(60)
        connection.REQUEST_TIMEOUT = 0.2
        whole = f"GET / HTTP/1.1\r\nHost: {host}\r\n\r\n".encode()
        print(ended(host), ended(host, whole))
        page.send("40")
        print(page.recv(60)[:2])
"""


def run(program: str) -> subprocess.CompletedProcess[str]:
    """Run a program of its own: there is one server in a process."""
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=240, check=True
    )


def test_a_connection_without_a_request_ends_and_that_of_a_page_stays() -> None:
    """Half a request is none, the second neither; a WebSocket older than both outlives them."""
    assert run(IDLE).stdout == "True True\n40\n"


CROWD = """
import resource
import socket
import sys

_, most = resource.getrlimit(resource.RLIMIT_NOFILE)
resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
host = sys.argv[1].split(":")
crowd = [socket.create_connection(host, timeout=60) for _ in range(60)]
for one in crowd:
    try:
        one.recv(1)
    except ConnectionResetError:
        pass
"""

CROWDED = f"""
import os
import resource
import subprocess
import sys
import urllib.request
from rodless_lab.view import connection
from rodless_lab.view.server import Server

connection.REQUEST_TIMEOUT = 5.0
_, most = resource.getrlimit(resource.RLIMIT_NOFILE)

with Server(lambda: None, "127.0.0.1", 0) as server:
    urllib.request.urlopen(server.address, timeout=60).read()
    # Room for few of the crowd, however slowly it comes.
    room = len(os.listdir("/proc/self/fd")) + 20
    resource.setrlimit(resource.RLIMIT_NOFILE, (room, most))
    host = server.address.removeprefix("http://")
    crowd = [sys.executable, "-c", {CROWD!r}, host]
    subprocess.run(crowd, check=True)
    print(urllib.request.urlopen(server.address, timeout=60).status)
"""


@extensive
def test_more_connections_than_files_make_a_line_and_the_pages_go_on() -> None:
    """Each try to take one was a line: 9,000 in a second. All end, and then a page is served."""
    done = run(CROWDED)
    assert done.stdout == "200\n"
    lines = done.stderr.splitlines()
    assert any("more connections than can be served wait" in line for line in lines), lines
    assert len(lines) < 20, done.stderr[:2000]
