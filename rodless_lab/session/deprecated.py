# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Old names of options, which go on working for a while."""

import warnings
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def timeout_was_patience(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Take ``patience=``, with a DeprecationWarning, for the option ``timeout=``."""

    @wraps(function)
    def renamed(*arguments: Parameters.args, **options: Parameters.kwargs) -> Result:
        if "patience" in options:
            if "timeout" in options:
                raise TypeError("patience= is the old name of timeout=: give one of them")
            warnings.warn(
                "patience= is deprecated: its name is now timeout=",
                DeprecationWarning,
                stacklevel=2,
            )
            options["timeout"] = options.pop("patience")
        return function(*arguments, **options)

    return renamed
