# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The start of the installed `rodless`: a signal waits until what handles it has been imported."""

import signal


def main() -> None:
    """Run :func:`rodless_lab.cli.main.main`.

    The signals are not kept waiting by the import of this module, as processes that others start
    import it too.
    """
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM, signal.SIGHUP))

    from rodless_lab.cli.main import main as run  # noqa: PLC0415

    run()
