import numpy as np
import pytest

from chassis_replay import unresisted
from ground.chassis.bench import drive
from tierod.physics.tyre import parking_torque
from tierod_lab.ground.chassis import SingleTrack

CAR = SingleTrack()


def test_loads_are_the_static_ones():
    loads = drive(CAR, 1.0, 20.0, steer=0.05).at(-1).reaction.loads
    assert sum(loads) == pytest.approx(CAR.mass * 9.81)
    assert loads.front_left == loads.front_right == pytest.approx(0.5 * CAR.front_load)


def test_trail_falls_as_the_tyres_slip():
    out = drive(unresisted(CAR), 8.0, 14.0, steer=lambda t: 0.04 * t)
    trail = out["reaction.self_aligning_torque"][1000:] / out["reaction.front_lateral_force"][1000:]
    assert trail[0] == pytest.approx(CAR.mechanical_trail + CAR.contact_half_length / 3.0, rel=0.1)
    assert trail[-1] < 0.8 * trail[0]


def test_the_standing_scrub_is_the_parking_torque():
    out = drive(CAR, 3.0, 0.0, steer=lambda t: 0.3 * np.minimum(t, 1.0), brake=500.0)
    expected = 2.0 * parking_torque(0.5 * CAR.front_load, CAR.adhesion, CAR.tyre_pressure)
    assert out.at(-1).reaction.scrub_torque == pytest.approx(expected, rel=0.01)


def test_the_force_along_stays_within_adhesion():
    out = drive(CAR, 2.0, 20.0, brake=5000.0, adhesion_left=0.4, adhesion_right=0.4)
    assert out["reaction.longitudinal_acceleration"].min() == pytest.approx(-0.4 * 9.81, rel=0.03)
