# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What is fuzzed: something good, and changes to it, of which the fewest that fail are reported."""

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

from draw import Draw

# One change to something good; any value that says enough to make it.
Change = Any


class Target(ABC):
    """One way into the product. Without changes, an input is good and must be accepted."""

    def __init__(self, folder: Path) -> None:
        """Prepare; files of its own go into ``folder``."""
        self.folder = folder

    @abstractmethod
    def draw(self, draw: Draw) -> list[Change]:
        """Return the changes of one input."""

    @abstractmethod
    def run(self, changes: list[Change]) -> object:
        """Use the product; return what is to be finite, and raise what it raises."""

    def weight(self, changes: list[Change]) -> int:  # noqa: ARG002
        """Return how many inputs this is."""
        return 1

    def close(self) -> None:  # noqa: B027  most have nothing to end
        """End what was prepared."""
