"""Look up known vulnerabilities of what a lock file names: `make audit`.

Fails for a vulnerability only. To pip-audit a service out of reach is an error, and a project that
the service does not know is sound: here the first is said and let pass, the second counted.
"""

import json
import subprocess
import sys
from typing import Any

COMMAND = (
    *("-m", "pip_audit", "--require-hashes", "--disable-pip", "--timeout", "10"),
    *("--format", "json", "--progress-spinner", "off", "--requirement"),
)
TIMEOUT = 180  # s


def reported(lock: str) -> list[dict[str, Any]]:
    """Return what pip-audit says of each project of the file.

    Raises TimeoutError or ConnectionError, in pip-audit's words, if it does not come to an end.
    """
    command = [sys.executable, *COMMAND, lock]
    try:
        done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        raise TimeoutError(f"no answer within {TIMEOUT} s") from None
    try:
        return list(json.loads(done.stdout)["dependencies"])
    except json.JSONDecodeError:
        raise ConnectionError((done.stderr.strip().splitlines() or ["?"])[-1]) from None


def main() -> int:
    """Print what was found; return 1 for a vulnerability."""
    (lock,) = sys.argv[1:]
    try:
        projects = reported(lock)
    except (TimeoutError, ConnectionError) as error:
        print(f"{lock}: not audited: {error}")
        return 0
    unknown = sum("skip_reason" in project for project in projects)
    weak = [project for project in projects if project.get("vulns")]
    for project in weak:
        for one in project["vulns"]:
            fixed = ", ".join(one["fix_versions"]) or "no release yet"
            print(f"{project['name']} {project['version']}: {one['id']}, fixed in {fixed}")
    print(
        f"{lock}: {len(projects) - unknown} projects looked up, {len(weak)} of them vulnerable; "
        f"{unknown} unknown to the service"
    )
    return 1 if weak else 0


if __name__ == "__main__":
    sys.exit(main())
