# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A text with changes: where in it, how much of it goes, and what comes."""

from collections.abc import Callable

from draw import Draw
from target import Change


def drawn(draw: Draw, text: str, new: Callable[[], str]) -> list[Change]:
    """Return changes of ``text``, each of which lets ``new`` draw what comes."""
    changes: list[Change] = []
    for _ in range(draw.choice((1, 1, 1, 2, 3))):
        start, end = sorted(draw.randrange(len(text) + 1) for _ in range(2))
        size = draw.choice((0, 1, 4, 20, end - start))
        changes.append((start, size, new()))
    return changes


def changed(text: str, changes: list[Change]) -> bytes:
    """Return ``text`` with all ``changes`` made, surrogates included."""
    for at, size, new in changes:
        text = text[:at] + new + text[at + size :]
    return text.encode("utf-8", "surrogatepass")
