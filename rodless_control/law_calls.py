# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A law that does not return is broken off where its process is asked to end."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

from rodless_base.start import Stop, StoppedError

# How long a law may go on once its node is asked to end, in wall-clock s.
LONGEST = 1.0


class LawBrokenOffError(BaseException):
    """Ends a law that does not return, and that may well catch every Exception."""


class LawCalls:
    """The calls of the law, in the thread that runs the node's callbacks and gets its signals."""

    under_way = False

    @classmethod
    def break_off_once_asked(cls, stop: Stop) -> None:
        """Have a law that goes on for ``LONGEST`` after a request to stop fail, in Python code.

        The node then closes the valve and ends. Compiled code hears no signal until it returns.
        """
        stop.asked = cls._watch

    @classmethod
    @contextmanager
    def making(cls) -> Iterator[None]:
        """Make a law in the block; raises StoppedError where that is broken off."""
        before, cls.under_way = cls.under_way, True  # a law may make another one
        try:
            yield
        except LawBrokenOffError as error:
            raise StoppedError(str(error)) from error
        finally:
            cls.under_way = before

    @classmethod
    def _watch(cls) -> None:
        signal.signal(signal.SIGALRM, lambda _number, _frame: cls._break_off())
        signal.setitimer(signal.ITIMER_REAL, LONGEST, LONGEST)

    @classmethod
    def _break_off(cls) -> None:
        if cls.under_way:
            raise LawBrokenOffError("it does not return, and the node is asked to end")
