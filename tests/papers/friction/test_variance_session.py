"""What the baseline monitor concludes from variances made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from papers.friction.test_variance_method import UNGATED
from tierod.core.statuses import Status
from tierod_lab.papers.friction.variance_session import NEEDED_WINDOWS, VarianceSession

WINDOW = UNGATED.block_samples * UNGATED.blocks


def concluded(windows, variance, enabled=1.0):
    session = VarianceSession("friction, baseline", replace(UNGATED, threshold=1000.0), 100.0)
    count = windows * WINDOW
    time = np.arange(count) / 100.0
    result = {
        "ready": np.ones(count),
        "variance": np.full(count, variance),
        "enabled": (np.arange(count) < enabled * count).astype(float),
    }
    for piece in np.array_split(np.arange(count), 3):
        session.collect(time[piece], {}, {name: values[piece] for name, values in result.items()})
    return session.conclude().verdict


@pytest.mark.parametrize("enabled", [0.25, 0.5, 1.0])
def test_the_share_of_the_time_that_was_enabled_is_that_of_all_samples(enabled):
    found = concluded(8, 500.0, enabled)
    assert found.status is Status.HEALTHY
    assert found.evidence["enabled_share"] == pytest.approx(enabled, abs=1e-3)
    assert found.evidence["windows"] == 8.0


def test_too_few_windows_are_said_with_the_share():
    found = concluded(NEEDED_WINDOWS - 1, 500.0, 0.4)
    assert found.status is Status.NOT_READY
    assert "40.0% of the drive" in found.cause


def test_a_variance_far_above_the_limit_is_a_fault():
    assert concluded(8, 1e5).status is Status.FAULT
