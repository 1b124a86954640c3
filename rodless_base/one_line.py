"""What others have made, shown in one line of bounded length: values, exceptions, names."""

import reprlib

# Long enough for a path and a sentence; a log that repeats it stays readable.
LONGEST = 500

_short = reprlib.Repr()
_short.maxstring = _short.maxother = _short.maxlong = 80
_short.maxlist = _short.maxtuple = _short.maxdict = 8


def shown(value: object) -> str:
    """Return ``repr(value)`` in one line of at most ``LONGEST`` characters; never raises."""
    try:
        # Shortens long texts and deep containers before it spells them out.
        return in_one_line(_short.repr(value))
    except Exception:
        return f"<{type(value).__name__} that cannot be shown>"


def described(error: BaseException) -> str:
    """Return the text of an exception in one line of at most ``LONGEST``; never raises."""
    try:
        return in_one_line(str(error))
    except Exception:
        return "(its text cannot be shown)"


def in_one_line(text: str) -> str:
    """Return ``text`` without line breaks, cut in its middle beyond ``LONGEST`` characters."""
    if len(text) > 10 * LONGEST:
        text = f"{text[: 5 * LONGEST]} {text[-5 * LONGEST :]}"
        cut = True
    else:
        cut = False
    line = " ".join(text.split())
    if cut or len(line) > LONGEST:
        half = (LONGEST - 3) // 2
        line = f"{line[:half]}...{line[-half:]}"
    return line
