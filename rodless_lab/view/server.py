# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The server of the pages, in a thread of its own; it answers its own pages only."""

import asyncio
import logging
import socket
import threading
from collections.abc import Callable

import uvicorn
from fastapi import FastAPI
from nicegui import ui

from rodless_base.closing import Closing
from rodless_lab.view.connection import Connection
from rodless_lab.view.errors import ViewError
from rodless_lab.view.origins import OwnPagesOnly
from rodless_lab.view.server_log import one_line_each

# Messages kept for a page whose connection breaks for a moment: 10 s of frames.
HISTORY = 200

# For a page to come back whose connection has broken, in wall-clock s.
RECONNECT_TIMEOUT = 30.0

# Connections that wait to be taken. Where no file can be opened any more, asyncio fails to take
# them up to this many times a second, each with a line in the log.
BACKLOG = 32

# For pages to be told good-bye, in wall-clock s; and for the server to end without.
END_TIMEOUT = 2
CLOSE_TIMEOUT = 30.0


class Server(Closing):
    """Serves pages that ``build`` makes on one address; there is one in a process."""

    def __init__(self, build: Callable[[], None], host: str, port: int) -> None:
        """Begin to listen; port 0 takes a free one. Raises :class:`ViewError` where it cannot."""
        self._socket = _bound(host, port)
        name = f"[{host}]" if ":" in host else host
        self.address = f"http://{name}:{self._socket.getsockname()[1]}"
        ui.page("/", title="rodless view")(build)
        app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        ui.run_with(
            app,
            dark=False,
            tailwind=False,
            message_history_length=HISTORY,
            reconnect_timeout=RECONNECT_TIMEOUT,
            show_welcome_message=False,
        )
        config = uvicorn.Config(
            OwnPagesOnly(app, host),
            log_level="error",
            lifespan="on",
            http=Connection,
            backlog=BACKLOG,
            timeout_graceful_shutdown=END_TIMEOUT,
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._run, name="view pages", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        # Outside the main thread uvicorn leaves signals alone.
        with one_line_each():
            asyncio.run(self._server.serve(sockets=[self._socket]))

    def check(self) -> None:
        """Raise :class:`ViewError` if it serves no more."""
        if not self._thread.is_alive():
            raise ViewError(f"{self.address}: the server of the pages has ended")

    def close(self) -> None:
        """Say good-bye to the pages and stop listening."""
        # A page that does not answer in time is cut off, which is no error then.
        for name in ("uvicorn.error", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self._server.should_exit = True
        self._thread.join(2.0 * END_TIMEOUT)
        # Left running, on a busy machine, it would still use what is gone.
        self._server.force_exit = True
        self._thread.join(CLOSE_TIMEOUT)
        self._socket.close()


def _bound(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        found = socket.socket(family, kind, protocol)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(address)
        found.listen()
    except (OSError, UnicodeError) as error:
        cause = error.strerror if isinstance(error, OSError) else "no name that a host can have"
        raise ViewError(
            f"{host}:{port}: cannot be listened on: {cause}; choose another --port or --host"
        ) from error
    return found
