# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a forked process must not keep of its parent: files whose end somebody waits for."""

import os
from typing import Protocol
from weakref import WeakSet


class Holder(Protocol):
    """Something that holds such a file."""

    def leave_to_parent(self) -> None:
        """Let go of it, in the forked process."""


_holders: "WeakSet[Holder]" = WeakSet()


def left_to_parent(holder: Holder) -> None:
    """See that ``holder`` lets go in each process that is forked from this one."""
    _holders.add(holder)


def _leave_to_parent() -> None:
    for holder in _holders:
        holder.leave_to_parent()


os.register_at_fork(after_in_child=_leave_to_parent)
