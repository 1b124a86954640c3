# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Numbers as people and files write them, not as Python's own source may."""


def written_number(text: str) -> float:
    """Return the number that ``text`` is; raises ValueError, for ``1_0`` and other digits too.

    The underscore is a slip of the finger here, and files of parameters know none.
    """
    if not text.isascii() or "_" in text:
        raise ValueError(text)
    return float(text)
