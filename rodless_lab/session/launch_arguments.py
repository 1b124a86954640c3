# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the launch files make of arguments that they do not have."""

from collections.abc import Collection, Iterable, Iterator
from difflib import get_close_matches

# Share of its letters that a misspelt name has in common with the one that is meant.
NEAR = 0.8

# Arguments that launch files of others often have.
OTHERS = frozenset({"model"})


def misspelt(given: Iterable[str], declared: Collection[str], file: str) -> Iterator[str]:
    """Yield a line on each argument that is likely a misspelt one of the launch file ``file``.

    launch keeps what it is given under any name, and hands it on to every file that is included:
    what this file has not declared may be meant for another. So only a name that is near one of
    its own is told, and none is refused. A name of its own with a word before or behind it, such
    as ``left_preset``, is a name of another file.

    Examples
    --------
    >>> list(misspelt(["sped", "left_speed", "robot"], ["speed", "mode"], "rig.launch.py"))
    ['sped:= is no argument of rig.launch.py and changes nothing here; did you mean speed:=?']
    """
    for name in given:
        if name in declared or name in OTHERS:
            continue
        near = get_close_matches(name, declared, n=1, cutoff=NEAR)
        if near and not _is_longer(name, near[0]):
            yield (
                f"{name}:= is no argument of {file} and changes nothing here; "
                f"did you mean {near[0]}:=?"
            )


def _is_longer(one: str, other: str) -> bool:
    """Whether one of two names has all words of the other."""
    words, others = set(one.split("_")), set(other.split("_"))
    return words <= others or others <= words
