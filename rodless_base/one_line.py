# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What others have made, shown in one line of bounded length: values, exceptions, names."""

import math
import reprlib
from array import array
from collections.abc import Sequence
from pathlib import Path
from traceback import walk_tb

# Long enough for a path and a sentence; a log that repeats it stays readable.
LONGEST = 500

# Of an error that names several things, each in a line of its own length.
LONGEST_ERROR = 4000

# How many of many names are told, and how much of each.
MOST_LISTED = 20
LONGEST_NAME = 80

# Bits of the longest whole number whose first and last digits are shown.
LONGEST_WRITTEN = 10_000


class _Short(reprlib.Repr):
    def repr_array(self, x: "array[float]", level: int) -> str:
        """Return it as the list that it stands for in a message or a parameter."""
        return self.repr_list(x[: self.maxlist + 1].tolist(), level)


_short = _Short()
_short.maxstring = _short.maxother = _short.maxlong = 80
_short.maxlist = _short.maxtuple = _short.maxdict = 8


class OneLineError(ValueError):
    """An error whose text is one line, whatever file or value it names."""

    def __str__(self) -> str:
        return _line(" ".join(super().__str__().splitlines()), LONGEST_ERROR)


def shown(value: object) -> str:
    """Return ``repr(value)`` in one line of at most ``LONGEST`` characters; never raises."""
    try:
        if isinstance(value, int) and value.bit_length() > LONGEST_WRITTEN:
            # Python writes none of more than 4300 digits.
            return f"a whole number of some {round(value.bit_length() * math.log10(2))} digits"
        # Shortens long texts and deep containers before it spells them out.
        return in_one_line(_short.repr(value))
    except Exception:
        return f"<{type(value).__name__} that cannot be shown>"


def listed(names: Sequence[str]) -> str:
    """Return the names with commas between them, of many the first and how many there are more.

    Examples
    --------
    >>> listed(["/a", "/b"])
    '/a, /b'
    """
    first = ", ".join(_line(name, LONGEST_NAME) for name in names[:MOST_LISTED])
    rest = len(names) - MOST_LISTED
    return f"{first} and {rest} more" if rest > 0 else first


def has_half_character(text: str) -> bool:
    """Whether a text has a lone surrogate, which is no text in UTF-8."""
    return not text.isascii() and any("\ud800" <= letter <= "\udfff" for letter in text)


def function_name(function: object) -> str:
    """Return what messages call a function: its name, or what it is where it has none."""
    return str(getattr(function, "__name__", None) or shown(function))


def described(error: BaseException) -> str:
    """Return the text of an exception in one line of at most ``LONGEST``; never raises."""
    try:
        return in_one_line(str(error))
    except Exception:
        return "(its text cannot be shown)"


def traced(error: BaseException) -> str:
    """Return kind and text of an exception, with file and line it comes from; never raises."""
    files = [(frame.f_code.co_filename, line) for frame, line in walk_tb(error.__traceback__)]
    # Python's own way of importing lies between an import and what it says of it.
    files = [(file, line) for file, line in files if not file.startswith("<frozen importlib")]
    where = "".join(f" ({Path(file).name}, line {line})" for file, line in files[-1:])
    text = described(error)
    return f"{type(error).__name__}{': ' if text else ''}{text}{where}"


def in_one_line(text: str) -> str:
    """Return ``text`` without line breaks, cut in its middle beyond ``LONGEST`` characters.

    What is no letter is spelt out: a NUL would end a message of ROS, ESC commands a terminal.
    """
    return _line(" ".join(_cut(text, 10 * LONGEST).split()), LONGEST)


def _line(text: str, longest: int) -> str:
    return _cut("".join(map(_visible, _cut(text, longest))), longest)


def _cut(text: str, longest: int) -> str:
    if len(text) <= longest:
        return text
    half = (longest - 3) // 2
    return f"{text[:half]}...{text[-half:]}"


def _visible(letter: str) -> str:
    return letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii")
