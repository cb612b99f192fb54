import math

from models.friction_paper import CAR
from tierod.models.friction_estimation import FrictionParameters
from tierod.models.steering_wheel import BelowBarParameters
from tierod.vehicles import load


def test_what_is_below_the_bar_is_what_the_wheel_leaves():
    below = BelowBarParameters(0.10, 0.8, 0.035, 0.2, 140.0)
    assert math.isclose(below.inertia, 0.065)
    assert math.isclose(below.damping, 0.6)


def test_a_file_without_a_bar_means_a_rigid_one_and_all_below_it():
    assert CAR.below_bar == BelowBarParameters(CAR.column_inertia, CAR.column_damping, 0.0, 0.0, math.inf)
    assert math.isinf(load("rav4").parameters_for(FrictionParameters).torsion_bar_stiffness)


def test_both_ways_to_the_same_car_agree():
    car = load("midsize-eps")
    assert car.parameters_for(FrictionParameters).below_bar == car.parameters_for(BelowBarParameters)
