# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a test gives as the value of a parameter, as files and messages take it."""

from collections.abc import Mapping

import numpy as np

from rodless_base.one_line import shown

KINDS = {bool, int, float, str}


def without_numpy(value: object) -> object:
    """Return what numpy holds, alone, in a list or by name, as Python has it; else as it is."""
    if isinstance(value, Mapping):
        return {_without_numpy(name): without_numpy(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_without_numpy(one) for one in value]
    return _without_numpy(value)


def _without_numpy(value: object) -> object:
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def check_value(name: object, value: object) -> None:
    """Raise TypeError for what no parameter of a file can be; of nested ones, for the first."""
    if isinstance(value, Mapping):
        for below, one in value.items():
            check_value(f"{name}.{below}", one)
        return
    plain = without_numpy(value)
    kinds = set(map(type, plain if isinstance(plain, list) else [plain]))
    if len(kinds) != 1 or not kinds <= KINDS:
        raise TypeError(is_no_value(name, value))


def is_no_value(name: object, value: object) -> str:
    """Say so of what no parameter can be."""
    return (
        f"{name}: {shown(value)} refused, must be a number, a text, true or false, or a list of "
        "one of these"
    )
