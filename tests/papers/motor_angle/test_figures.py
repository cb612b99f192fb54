import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.content import Chart
from tierod_lab.papers.motor_angle.figures import CAR, FAST, HELD, PRINTED, car_drive, items
from tierod_lab.papers.motor_angle.observer_drives import methods
from tierod_lab.studies.effort import Effort


def test_the_sections_are_what_they_are_called():
    parking = car_drive("parking", 30.0)
    fast = (parking.time > FAST[0] + 0.2) & (parking.time < FAST[1] - 1.0)
    held = (parking.time > HELD[0] + 0.2) & (parking.time < HELD[1])
    assert np.abs(parking.speed[fast]).min() > 35.0
    assert np.abs(parking.speed[held]).max() < 1.0
    assert np.hypot(*parking.samples[:, :2].T)[parking.places[held]].mean() > 3.0


def test_truth_and_samples_belong_to_the_same_instants():
    slalom = car_drive("slalom", 12.0)
    away = slalom.samples[slalom.places, 4] - slalom.angle
    assert np.std(away) == pytest.approx(8.7e-4, rel=0.2)
    assert slalom.observed(methods(CAR)["default"])["motor_angle"].shape == (len(slalom.samples),)


def test_four_figures_show_the_four_methods_and_the_claims_hold():
    found = list(items(Effort(quick=True)))
    charts = [item for item in found if isinstance(item, Chart)]
    assert [chart.name[-1] for chart in charts] == ["4", "5", "6", "7"]
    for chart in charts:
        assert {"measured", *PRINTED} <= {mark.name for mark in chart.panels[0].marks}
    claims = [item for item in found if isinstance(item, Claim)]
    # The printed observers leave the angle of the car by more than the monitor's own goal, and keep what they lost.
    failing = {claim.id for claim in claims if claim.met is False}
    assert "car.observers-follow" in failing
    assert failing <= {"car.observers-follow", "car.feedforward-fast"}
