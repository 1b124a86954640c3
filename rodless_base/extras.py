# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What is asked for and not installed: how to get it."""


def missing_extra(what: str, library: str | None, extra: str) -> ModuleNotFoundError:
    """Return the error that ``what`` needs a ``library``, which an ``extra`` of ours brings."""
    return ModuleNotFoundError(
        f"{what} needs {library}, which is not installed: pip install 'rodless_sim[{extra}]'",
        name=library,
    )
