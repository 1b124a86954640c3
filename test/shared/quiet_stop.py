"""A stop for commands that a test calls."""

from rodless_base.start import Stop


class Quiet(Stop):
    """A stop nobody requests, which leaves the test's own signal handlers alone."""

    def __init__(self) -> None:
        self.requested = False
