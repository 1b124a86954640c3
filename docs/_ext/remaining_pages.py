# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The line `remaining-pages` of a table of contents: the pages beside it that no other line names.

So a new page needs no entry to be found; one that wants a better place gets a line of its own.
"""

import re

from sphinx.application import Sphinx

MARK = "remaining-pages"


def fill_in(app: Sphinx, docname: str, content: list[str]) -> None:
    """Put the remaining pages in place of the mark, in alphabetical order."""
    if MARK not in content[0]:
        return
    named = set(re.findall(r"^[\w-]+$", content[0], re.M)) | {docname}
    pages = sorted(page for page in app.env.found_docs if "/" not in page)
    content[0] = content[0].replace(MARK, "\n".join(p for p in pages if p not in named))


def setup(app: Sphinx) -> dict[str, bool]:
    """Join the build."""
    app.connect("source-read", fill_in)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
