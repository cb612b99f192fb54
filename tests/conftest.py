"""Settings of all tests: no time limit on a shared machine; the same examples each time where a change is checked."""

import os

from hypothesis import settings

settings.register_profile("tierod", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("tierod")
