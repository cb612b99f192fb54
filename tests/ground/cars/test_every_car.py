import pytest

from tierod.core.graph.trace import trace
from tierod.core.signals import SIGNALS
from tierod_lab.ground.cars.active_front_car import ActiveFrontCar
from tierod_lab.ground.cars.column_bench import ColumnBench
from tierod_lab.ground.cars.demonstrator_car import DemonstratorCar
from tierod_lab.ground.cars.eps_car import EpsCar, PmEpsCar
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.cars.steer_by_wire_car import SteerByWireCar
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.faults import Sluggish
from tierod_lab.ground.faults.elements import Reach
from tierod_lab.ground.recorder import channel_names
from tierod_lab.ground.sensors import SensorSet

ROAD = (ActiveFrontCar, DemonstratorCar, EpsCar, PmEpsCar, SteerByWireCar)
PLANTS = [kind(chassis=chassis()) for kind in ROAD for chassis in (SingleTrack, TwoTrack)]
PLANTS += [ColumnBench(), MotorBench()]


def named(plant):
    return f"{type(plant).__name__} {type(getattr(plant, 'chassis', None)).__name__}"


@pytest.mark.parametrize("plant", PLANTS, ids=named)
def test_channels_are_canonical_and_no_two_share_a_name(plant):
    columns = channel_names(plant)
    assert [name for name in columns if name not in SIGNALS and not name.startswith("truth_")] == []
    paths = trace(plant).output
    for name, places in columns.items():
        prefixes = {paths[place].rsplit(name, 1)[0] for place in places}
        assert len(prefixes) == 1, name


@pytest.mark.parametrize("plant", PLANTS, ids=named)
def test_faults_reach_its_actuators_and_what_its_units_read(plant):
    reach = Reach(plant, SensorSet.ideal())
    assert reach.actuators
    assert reach.actuators <= reach.ports
    in_loops = reach.ports - reach.actuators - {"motor_lock"}
    assert in_loops <= set(reach.outputs)


@pytest.mark.parametrize("plant", [plant for plant in PLANTS if not isinstance(plant, ColumnBench)], ids=named)
def test_every_actuator_can_be_sluggish_by_itself(plant):
    reach = Reach(plant, SensorSet.ideal())
    lags = [target.name for name in reach.actuators for target in reach.targets(f"actuator.{name}", Sluggish(0.03))]
    assert len(set(lags)) == len(reach.actuators)
    assert all(reach.parameters[lag].unit == "s" for lag in lags)
