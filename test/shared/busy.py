"""A machine that has no time: every core is kept busy."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

BURNER = "import sys, time; end = time.time() + float(sys.argv[1])\nwhile time.time() < end: pass"


@contextmanager
def busy_cores(longest: float) -> Iterator[None]:
    """Keep every core busy inside the block, and ``longest`` s at most whatever happens."""
    command = [sys.executable, "-I", "-S", "-c", BURNER, str(longest)]
    with ExitStack() as stack:
        for _ in range(os.cpu_count() or 1):
            burner = stack.enter_context(subprocess.Popen(command))
            stack.callback(burner.kill)
        yield
