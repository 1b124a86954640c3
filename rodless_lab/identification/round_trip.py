"""See :mod:`rodless_lab.identification.coverage`, whose command this still is."""

import sys

from rodless_lab.identification.coverage import main

if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
