from __future__ import annotations

import dataclasses

import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Recording
from tierod.methods.identification.vehicle import identify_vehicle
from tierod.methods.identification.vehicle_judgement import BOUND, LEARNT, NOT_SEEN, SHOWN
from tierod.models.lateral_motion import LateralParameters
from tierod.vehicles import load
from tierod.vehicles.vehicle import Parameter
from tierod_lab.ground.cars.catalogue import load as load_car
from tierod_lab.ground.courses.roads import City, Country
from tierod_lab.ground.run import CHANNELS, drive
from tierod_lab.ground.sensors import SensorSet

FREE = ("steering_ratio", "front_cornering_stiffness")
SENSORS = SensorSet.production().only((*CHANNELS, "longitudinal_acceleration"))


def driven(name="midsize-eps", seed=11, minutes=2.0):
    return drive(load_car(name).block, minutes, seed=seed, sensors=SENSORS, roads=(City(), Country()))


@pytest.fixture(scope="module")
def recording():
    return driven()


@pytest.fixture(scope="module")
def short(recording):
    return recording.slice(stop=recording.span[0] + 60.0)


def known_but(vehicle, *names):
    """The vehicle, of which all that is not named is known exactly."""
    exact = [name for name in SHOWN if name in vehicle and name not in names]
    vehicle = changed(vehicle, **{name: (vehicle[name], 0.0) for name in exact})
    defaults = LateralParameters(*(vehicle[each.name] for each in dataclasses.fields(LateralParameters)[:6]))
    added = {
        name: Parameter(name, getattr(defaults, name), "", 0.0, "exact")
        for name in SHOWN
        if name not in vehicle and name not in names
    }
    return dataclasses.replace(vehicle, parameters={**vehicle.parameters, **added})


def changed(vehicle, **values):
    parameters = {
        name: dataclasses.replace(vehicle.parameters[name], value=value, standard_deviation=deviation)
        for name, (value, deviation) in values.items()
    }
    return dataclasses.replace(vehicle, parameters={**vehicle.parameters, **parameters})


@pytest.fixture(scope="module")
def guess():
    return changed(
        known_but(load("midsize-eps"), *FREE), steering_ratio=(0.069, 0.0035), front_cornering_stiffness=(150e3, 30e3)
    )


@pytest.fixture(scope="module")
def found(recording, guess):
    return identify_vehicle({"drive": recording}, guess)


def test_ratio_and_stiffness_come_closer_than_the_guess_and_within_what_is_claimed(found):
    learnt = {each.name: each for each in found.found}
    ratio, stiffness = learnt["steering_ratio"], learnt["front_cornering_stiffness"]
    assert not found.doubt
    assert abs(ratio.value - 1.0 / 15.5) < 3.0 * ratio.deviation < 0.0022
    assert abs(stiffness.value - 110e3) < 3.0 * stiffness.deviation < 35e3
    assert ratio.before == 0.069


def test_what_a_drive_does_not_show_stays_and_says_what_to_drive(short):
    open_ = known_but(load("midsize-eps"), *FREE, "tyre_friction", "mass")
    result = identify_vehicle({"drive": short}, open_)
    kinds = {each.name: each for each in result.judged}
    assert kinds["steering_ratio"].kind == LEARNT
    assert kinds["tyre_friction"].kind == NOT_SEEN
    assert "limit of grip" in kinds["tyre_friction"].text
    assert "tyre_friction" not in {each.name for each in result.found}
    assert kinds["mass"].kind == BOUND
    assert "weigh the car" in kinds["mass"].text


def test_a_drive_at_the_limit_of_grip_is_refused(short, guess):
    tyres = Parameter("tyre_friction", 0.2, "", 0.0, "assumed")
    icy = dataclasses.replace(guess, parameters={**guess.parameters, "tyre_friction": tyres})
    result = identify_vehicle({"drive": short}, icy)
    assert result.doubt.startswith("drive is driven at the limit of grip")
    assert "identify from ordinary drives" in result.doubt


def test_a_file_that_contradicts_the_drives_is_said_with_both_values(short, guess):
    wrong = changed(guess, steering_ratio=(0.045, 0.0005))
    result = identify_vehicle({"drive": short}, wrong)
    assert "steering_ratio is 0.045 ± 0.0005 before, 0.06" in result.doubt
    assert "channel map" in result.doubt


def test_drives_of_two_cars_are_found_and_the_odd_one_is_named(recording, guess):
    begin = recording.span[0]
    first, second = (recording.slice(begin + start, begin + start + 45.0) for start in (0.0, 60.0))
    drives = {"first": first, "other": driven("small-eps", 12, 0.75), "second": second}
    result = identify_vehicle(drives, guess)
    assert result.doubt.startswith("other is of another car")
    assert result.odd is not None
    assert result.odd.certain
    result = identify_vehicle({each: drives[each] for each in ("first", "second")}, guess)
    assert result.odd is None
    assert len(result.zeros) == 2


def test_slips(recording, guess):
    with pytest.raises(InputError, match="same drive"):
        identify_vehicle({"a": recording, "b": recording}, guess)
    without = Recording({name: each for name, each in recording.channels.items() if name != "yaw_rate"})
    with pytest.raises(InputError, match="no 'yaw_rate'"):
        identify_vehicle({"a": without}, guess)
    with pytest.raises(InputError, match="needs 30 s"):
        identify_vehicle({"a": recording.slice(stop=recording.span[0] + 20.0)}, guess)
    with pytest.raises(ParameterError, match="not identified from ordinary drives"):
        identify_vehicle({"a": recording}, guess, ("column_inertia",))
    with pytest.raises(ParameterError, match="mass"):
        identify_vehicle({"a": recording}, load("motor-bench"))


def other_channel(recording, factor, name="steering_wheel_angle"):
    """Another export of the drive: half the rate, a clock that begins elsewhere, the angle of another place."""
    channels = {}
    for each in recording.channels.values():
        values = each.values * (factor if "angle" in each.name else 1.0)
        kept = dataclasses.replace(each, time=each.time[::2] + 100.0, values=values[::2])
        own = name if each.name == "steering_wheel_angle" else each.name
        channels[own] = dataclasses.replace(kept, name=own)
    return Recording(channels)


@pytest.mark.parametrize(
    ("factor", "name", "said"),
    [
        (1.0, "steering_wheel_angle", "counts once: leave one out"),
        (1.0 / 15.0, "steering_wheel_angle", "differ by a factor of 15"),
        (1.0 / 15.0, "road_wheel_angle", "differ by a factor of 15"),
        (-1.0, "steering_wheel_angle", "their steering angles have opposite signs; the drive counts once"),
        (-1.0 / 15.0, "steering_wheel_angle", "have opposite signs and differ by a factor of 15"),
    ],
)
def test_one_drive_in_two_exports_counts_once(recording, guess, factor, name, said):
    later = other_channel(recording.slice(recording.span[0] + 10.0), factor, name)
    with pytest.raises(InputError, match="hold the same drive") as refused:
        identify_vehicle({"one": recording, "other": later}, guess)
    assert said in str(refused.value)
    assert "another car" not in str(refused.value)


def test_a_road_wheel_angle_that_is_called_the_steering_wheel_s_gives_no_mass(short, guess):
    with pytest.raises(InputError, match=r"steering_wheel_angle is 0\.0\d+ times .* at another place, such as"):
        identify_vehicle({"drive": other_channel(short, 1.0 / 15.0)}, guess)


def test_a_steering_angle_of_the_wrong_sign_is_not_said_to_be_of_another_place(short, guess):
    with pytest.raises(InputError, match="steering_wheel_angle and yaw_rate have opposite signs") as refused:
        identify_vehicle({"drive": other_channel(short, -1.0)}, guess)
    assert "another place" not in str(refused.value)
    assert "channel map" in str(refused.value)
    with pytest.raises(InputError, match=r"opposite signs .* is 0\.0\d+ times .* at another place, such as"):
        identify_vehicle({"drive": other_channel(short, -1.0 / 15.0)}, guess)
