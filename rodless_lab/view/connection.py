# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A connection to the pages' server, which is for those who ask for something."""

import asyncio

from uvicorn.protocols.http.h11_impl import H11Protocol

# For a request to come, in s. uvicorn itself waits for ever for the first, and for a later one that
# has begun; each connection takes one of the files that the process may open.
REQUEST_TIMEOUT = 10.0


class Connection(H11Protocol):
    """An HTTP connection that ends where no request comes."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait."""
        super().connection_made(transport)
        self._await_request(transport)

    def on_response_complete(self) -> None:
        """Begin to wait for the next."""
        last = self.cycle
        super().on_response_complete()  # which begins with the next where that is there
        self._await_request(self.transport, last)

    def _await_request(self, transport: asyncio.Transport, last: object = None) -> None:
        self.loop.call_later(REQUEST_TIMEOUT, self._end_unless_asked, transport, last)

    def _end_unless_asked(self, transport: asyncio.Transport, last: object) -> None:
        """End it; one that has become a WebSocket has a protocol of its own."""
        if self.cycle is last and transport.get_protocol() is self:
            transport.abort()
