# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
