"""Put the licence's header before every Python file that lacks it: `make headers`.

The text is that of LICENSE, appendix, in as few lines as it fits; ament_copyright accepts nothing
shorter and knows no SPDX lines, but does not mind where lines end.
"""

import subprocess
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COPYRIGHT = "Copyright 2026 rodless_sim contributors"
FIRST = 'Licensed under the Apache License, Version 2.0 (the "License");'
WIDTH = 100


def header() -> str:
    """Return the header as comment lines."""
    licence = (ROOT / "LICENSE").read_text(encoding="utf-8")
    notice = licence[licence.index(FIRST) :]
    lines = textwrap.wrap(" ".join(notice.split()), WIDTH - len("# "), break_on_hyphens=False)
    return "".join(f"# {line}\n" for line in (COPYRIGHT, *lines))


def files() -> list[Path]:
    """Return the Python files of the checkout, tracked or new, other than those of .ci."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.py"]
    names = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [ROOT / name for name in names.splitlines() if not name.startswith(".ci/")]


def lacking() -> list[Path]:
    """Return the files without a header; empty ones need none."""
    contents = {file: file.read_text(encoding="utf-8") for file in files()}
    return [file for file, text in contents.items() if text and not text.startswith("# Copyright ")]


def main() -> int:
    """Write the header; with --missing, name the files and return 1 if there are none."""
    found = lacking()
    if sys.argv[1:] == ["--missing"]:
        print("".join(f"{file}\n" for file in found), end="")
        return 0 if found else 1
    for file in found:
        content = file.read_text(encoding="utf-8")
        file.write_text(f"{header()}\n{content}", encoding="utf-8")
    print(f"{len(found)} files")
    return 0


if __name__ == "__main__":
    sys.exit(main())
