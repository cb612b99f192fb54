"""When a signal was missing while others went on."""

import numpy as np
import pytest

from tierod.core.recording import Aligned
from tierod.monitors.inputs import MissingStretches

RATE = 10.0
TIME = np.arange(1200) / RATE


def aligned(**gone):
    """120 s of two signals, with the stretches of each that are missing."""
    values = np.ones((len(TIME), 2))
    for column, name in enumerate(("angle", "rate")):
        for start, stop in gone.get(name, ()):
            values[(start - 1e-6 <= TIME) & (stop - 1e-6 > TIME), column] = np.nan
    return Aligned(TIME, values, ("angle", "rate"))


def pieces(whole, length):
    for at in range(0, len(whole.time), length):
        yield Aligned(whole.time[at : at + length], whole.values[at : at + length], whole.names)


def said(whole, length=1200, rates=None, others=()):
    found = MissingStretches(("angle", "rate"), RATE)
    for piece in pieces(whole, length):
        found.add(piece)
    return found.warnings({"angle": 100.0, "rate": 100.0} if rates is None else rates, others)


@pytest.mark.parametrize("length", [1, 7, 400, 1200])
def test_gap_begin_and_end_are_named_however_the_recording_is_cut(length):
    (gap,) = said(aligned(rate=[(40.0, 60.0)]), length)
    assert gap.startswith("rate is missing from 40.0 s to 60.0 s: estimates there rest on the other signals")
    (end,) = said(aligned(angle=[(10.0, 200.0)]), length)
    assert end.startswith("angle is missing from 10.0 s on (110 s to the end)")
    (begin,) = said(aligned(angle=[(0.0, 5.0)]), length)
    assert begin.startswith("angle is missing until 5.0 s")


def test_what_is_short_slow_absent_or_named_elsewhere_is_not_named():
    assert said(aligned(rate=[(40.0, 40.9)])) == ()
    # A signal at 0.1 Hz is there in one sample of the grid in a hundred, and not missing.
    slow = aligned(rate=[(10.0 * n + 0.1, 10.0 * n + 10.0) for n in range(12)])
    assert said(slow, rates={"angle": 100.0, "rate": 0.1}) == ()
    assert len(said(slow)) == 1
    assert said(aligned(rate=[(0.0, 200.0)])) == ()
    assert said(aligned(rate=[(40.0, 60.0)]), others=("rate",)) == ()
