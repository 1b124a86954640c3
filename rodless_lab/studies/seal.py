# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Seals: whether a file or a line of results is as it was written, and where it belongs."""

import hashlib

# A file has it once, with its digest behind it; where the digest will stand there are zeros first.
_LABEL = b"sealed by sha256 "
_DIGITS = 64
_NONE = b"0" * _DIGITS
UNSEALED = (_LABEL + _NONE).decode()


class Seal:
    """The seal of a file of results: it depends on its name and on what they are results of."""

    def __init__(self, results_of: bytes, name: str) -> None:
        """Take what the results depend on, and the name of the file."""
        self._begun = hashlib.sha256(results_of + b"\n" + name.encode())

    def of(self, content: bytes) -> str:
        """Return the seal of ``content``, 64 digits to base 16."""
        digest = self._begun.copy()
        digest.update(content)
        return digest.hexdigest()

    def sealed(self, content: bytes) -> bytes:
        """Return a file that holds ``UNSEALED``, with its seal there instead."""
        return _with_digits(content, self.of(content).encode())

    def holds(self, content: bytes) -> bool:
        """Whether a file is what :meth:`sealed` has returned, to the bit."""
        return self.sealed(_with_digits(content, _NONE)) == content if _LABEL in content else False


def _with_digits(content: bytes, digits: bytes) -> bytes:
    place = content.rindex(_LABEL) + len(_LABEL)
    return content[:place] + digits + content[place + _DIGITS :]
