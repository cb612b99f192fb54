"""`diagnose` without the spread of the vehicle's parameters, for tests of what a monitor does with given ones."""

from functools import partial

from tierod.monitors import diagnose as running

diagnose = partial(running.diagnose, spread=False)
