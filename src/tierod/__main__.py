"""`python -m tierod` is the command line."""

import sys

from tierod.cli import main

sys.exit(main())
