# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""What the server of the pages says of requests, which anybody on this machine may send."""

import subprocess
import sys

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
