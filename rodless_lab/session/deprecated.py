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
