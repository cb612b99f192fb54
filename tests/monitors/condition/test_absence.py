"""Since when something lacks, against what was taken away."""

import numpy as np
import pytest

from tierod.core.findings import Status
from tierod.monitors.condition.coverage import Absence

PERIOD, BORNE = 0.01, 1.0
TIME = np.arange(3000) * PERIOD


def followed(there, parked=None, cuts=(), others=None):
    absence = Absence(PERIOD, BORNE)
    parked = np.zeros(len(TIME), bool) if parked is None else parked
    rest = np.zeros(len(TIME), bool) if others is None else others
    for time, some, stands, each in zip(*(np.split(each, cuts) for each in (TIME, there, parked, rest)), strict=True):
        absence.add(time, some, stands, each)
    return absence


@pytest.mark.parametrize("cuts", [(), (700, 1500), (1100, 1101)])
def test_what_ends_is_gone_since_its_last_reading(cuts):
    absence = followed(TIME < 11.0 - 1e-9, cuts=cuts)
    assert absence.since == pytest.approx(10.0)
    assert absence.loss(Status.NOT_AVAILABLE, "no reading", "read").cause == "no reading since 10.00 s"


def test_what_comes_back_has_lacked_for_most_of_the_drive_or_not():
    rare, often = followed((TIME < 5.0) | (TIME > 25.0)), followed((TIME < 10.0) | (TIME > 15.0))
    assert (rare.since, often.since) == (None, None)
    assert rare.loss(Status.NOT_AVAILABLE, "", "read").cause == "read for only 10 of 30 s of driving"
    assert often.loss(Status.NOT_AVAILABLE, "", "read") is None


@pytest.mark.parametrize("cuts", [(), (700, 1500), (1100, 1101)])
def test_what_lacks_alone_and_comes_back_has_the_times_of_its_gap(cuts):
    there, alone = (TIME < 11.0 - 1e-9) | (TIME > 15.0 - 1e-9), np.ones(len(TIME), bool)
    gap = followed(there, cuts=cuts, others=alone).loss(Status.NOT_AVAILABLE, "no reading", "read")
    assert (gap.status, gap.cause) == (Status.NOT_TESTABLE, "no reading from 10.00 s to 15.00 s")
    # Where all signals pause together, nothing was judged, and none of them was lost.
    assert followed(there, cuts=cuts, others=there).loss(Status.NOT_AVAILABLE, "no reading", "read") is None


def test_nothing_lacks_while_the_vehicle_is_parked_nor_what_never_came():
    assert followed(TIME < 11.0, TIME > 10.5).loss(Status.NOT_AVAILABLE, "", "") is None
    assert followed(TIME < 0.0).loss(Status.NOT_AVAILABLE, "", "") is None


def test_a_short_end_is_no_loss():
    assert followed(TIME < 29.5).since is None
