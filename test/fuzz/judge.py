# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Whether an input ended well: in success, or in a refusal of our own, within its bounds."""

import dis
import math
import resource
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from traceback import walk_tb

import numpy as np
from numba.core.compiler_lock import global_compiler_lock

# Bounds of one input: processor time (s), and growth of the process's largest size (kB).
SECONDS = 20.0
GROWTH = 300_000

# A refusal is a line that fits a log.
LONGEST = 1500


class FoundError(Exception):
    """What should not have happened with an input; the text says what."""


class TooSlowError(BaseException):
    """An input takes longer than its bound; nothing on its way catches it."""


@contextmanager
def bounded() -> Iterator[None]:
    """Raise :class:`FoundError` where the block takes too long or too much memory."""

    def end(_number: int, _frame: object) -> None:
        # Interrupted, numba leaves a function half compiled, which fails for every later input: the
        # bound begins anew.
        if global_compiler_lock.is_locked():
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            return
        raise TooSlowError

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    others = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        yield
    except TooSlowError as error:
        raise FoundError(f"not done after {SECONDS:g} s of processor time") from error
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, others)
    growth = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    if growth > GROWTH:
        raise FoundError(f"takes {growth // 1000} MB of memory")


def accepted(run: Callable[[], object]) -> bool:
    """Run an input; return whether it was accepted, and not refused.

    Raises :class:`FoundError` for an error that is no refusal of our own, a refusal that is not one
    line, and a result with numbers that are not finite.
    """
    try:
        result = run()
    except FoundError:
        raise
    except Exception as error:
        check_refusal(error)
        return False
    number = not_finite(result)
    if number is not None:
        raise FoundError(f"accepted, with {number} in {type(result).__name__}")
    return True


def check_refusal(error: BaseException) -> None:
    """Raise :class:`FoundError` for an error that we have not raised, or not in one line."""
    text = str(error)
    if not raised_by_us(error):
        raise FoundError(f"{type(error).__name__} out of no raise statement of ours") from error
    if not text.strip() or "\n" in text or len(text) > LONGEST:
        raise FoundError(f"refused in {text.count(chr(10)) + 1} lines, {len(text)} characters")


def raised_by_us(error: BaseException) -> bool:
    """Whether a ``raise`` in this project's code has raised an error, and nothing below it."""
    *_, (frame, _) = walk_tb(error.__traceback__)
    traceback = error.__traceback__
    while traceback is not None and traceback.tb_next is not None:
        traceback = traceback.tb_next
    assert traceback is not None
    name = str(frame.f_globals.get("__name__"))
    instruction = frame.f_code.co_code[traceback.tb_lasti]
    return name.startswith("rodless_") and dis.opname[instruction] in ("RAISE_VARARGS", "RERAISE")


def not_finite(result: object) -> float | None:
    """Return a number in a result that is not finite, if there is one."""
    if isinstance(result, float):
        return None if math.isfinite(result) else result
    if isinstance(result, np.ndarray):
        if result.dtype.kind != "f" or np.isfinite(result).all():
            return None
        return float(result[~np.isfinite(result)][0])
    if isinstance(result, Mapping):
        parts: list[object] = list(result.values())
    elif isinstance(result, tuple | list):
        parts = list(result)
    elif is_dataclass(result) and not isinstance(result, type):
        parts = [getattr(result, field.name) for field in fields(result)]
    else:
        return None
    return next((bad for bad in map(not_finite, parts) if bad is not None), None)
