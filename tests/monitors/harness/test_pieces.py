import pytest

from tierod.core.errors import InputError
from tierod.monitors.harness.pieces import LEAP, refuse_leap


def test_a_night_is_borne_and_a_clock_that_leaps_is_not():
    refuse_leap(100.0, 100.0 + LEAP)
    with pytest.raises(InputError, match=r"jumps ahead from about 100 s by 1\.5 days; cut the recording there"):
        refuse_leap(100.0, 100.0 + 1.5 * LEAP)
