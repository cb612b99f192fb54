"""`python -m tierod` is the command line."""

import sys

from tierod.cli import main

if __name__ == "__main__":
    sys.exit(main())
