"""Put the licence's header before every Python file that lacks it: `make headers`.

The text is that of LICENSE, appendix; the holder is the maintainer in package.xml. ament_copyright
accepts nothing shorter: it knows no SPDX lines.
"""

import subprocess
import sys
from datetime import datetime, timezone
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
FIRST, LAST = "Copyright [yyyy] [name of copyright owner]", "limitations under the License."


def header() -> str:
    """Return the header as comment lines."""
    lines = [line.strip() for line in (ROOT / "LICENSE").read_text(encoding="utf-8").splitlines()]
    text = lines[lines.index(FIRST) : lines.index(LAST) + 1]
    # The address stands apart.
    address = next(k for k, line in enumerate(text) if line.startswith("http"))
    text[address] = "    " + text[address]
    holder = ElementTree.parse(ROOT / "package.xml").findtext("maintainer")
    text[0] = f"Copyright {datetime.now(timezone.utc).year} {holder}"
    return "".join(f"# {line}".rstrip() + "\n" for line in text)


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
        print(*found, sep="\n")
        return 0 if found else 1
    for file in found:
        content = file.read_text(encoding="utf-8")
        file.write_text(f"{header()}\n{content}", encoding="utf-8")
    print(f"{len(found)} files")
    return 0


if __name__ == "__main__":
    sys.exit(main())
