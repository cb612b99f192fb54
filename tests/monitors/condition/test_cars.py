"""Cars with motion sensors alone: faults are named while they last; slides, tight turns and reversing are none."""

import json
import math

import numpy as np
import pytest

from monitors.condition.motion_alone import (
    SETS,
    at_the_limit,
    declared,
    drive,
    excerpts,
    hard,
    judged,
    outcome,
    with_slip,
)
from monitors.condition.small_car import (
    QUADRICYCLE,
    SCALE_CAR,
    STEP,
    SmallCar,
    backs_out,
    course,
    recordings,
    vehicle_of,
)
from said import said
from tierod.cli import main
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.io.writers import write
from tierod.monitors.condition.courses import FAULT
from tierod.monitors.condition.definition import rolling_monitor
from tierod.monitors.condition.limits import aligned
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import DRIFT, GAIN, OFFSET, STUCK, Injected
from tierod_lab.papers.own_car.cars import drawn

SEED = 3
LATE = {STUCK: 1.5, DRIFT: 4.5, OFFSET: 0.1}
"""Longest time from the deviation that shows to the declaration [s]."""


@pytest.fixture(scope="module")
def bank():
    return rolling_monitor(load("rav4"))


@pytest.fixture(scope="module")
def parts():
    return excerpts(drive(SEED, 120.0), 3, SEED)


@pytest.mark.parametrize(
    ("sensor", "kind"),
    [("wheel_speed_rear_left", STUCK), ("wheel_speed_front_right", DRIFT), ("wheel_speed_rear_left", OFFSET)],
)
def test_a_wheel_is_named_while_its_fault_lasts_and_nothing_else(bank, parts, sensor, kind):
    found = [outcome(bank, part, sensor, kind) for part in parts]
    shown = [each for each in found if each.shows > 1.0]
    assert shown
    assert all(each.kind == kind and each.declared - each.onset < LATE[kind] for each in shown)
    assert not any(each.wrong for each in found)
    assert all(not each.error > 0.15 for each in shown)


@pytest.mark.parametrize("only", SETS)
def test_nothing_is_declared_on_a_fault_free_drive_and_under_hard_drives_and_brakes(bank, only):
    assert not declared(judged(bank, drive(SEED, 120.0), SETS[only]))
    for driven in ("front", "rear"):
        assert not declared(judged(bank, with_slip(hard(SEED, driven, 60.0), 0.1, driven), SETS[only]))


@pytest.fixture(scope="module")
def spinning():
    """A quadricycle of rear drive, which spins."""
    return drawn(1, 41)


@pytest.mark.parametrize(
    ("name", "only"),
    [("dwell 0.6", "all"), ("slalom 0.35", "without accelerations"), ("ice in a bend", "without front wheels")],
)
def test_a_spin_accuses_no_sensor_and_is_seen(spinning, name, only):
    part, slip = at_the_limit(spinning, name, 41)
    assert slip > 60.0
    result = judged(rolling_monitor(spinning.brochure), part, SETS[only])
    assert not declared(result)
    assert result["low_grip"][800:].mean() > 0.2
    assert result["low_grip"][200:800].mean() < 0.1


def test_the_finding_says_that_tyres_slid_and_a_fault_on_the_straight_before_is_named(spinning):
    found = diagnose(at_the_limit(spinning, "dwell 0.6", 41)[0], spinning.brochure, "condition")
    assert not [each.name for each in found.elements if each.status in (Status.FAULT, Status.SUSPECT)]
    assert any("the tyres slid" in each for each in found.findings[0].warnings)
    part, _ = at_the_limit(spinning, "step 1.0", 41)
    first = part["yaw_rate"].time[0]
    wrong = injected(part, [Injected("yaw_rate", OFFSET, 0.1, first + 4.0, first + 7.0).fault])
    status = scan(rolling_monitor(spinning.brochure), aligned(wrong))["statements.yaw_rate.status"]
    assert (status[400:430] == FAULT).any()


@pytest.fixture(scope="module")
def straight():
    """Its yaw rate stays below 0.01 rad/s from 15 to 25 s."""
    return Recording(dict(drive(91).slice(0.0, 40.0).channels))


@pytest.fixture(scope="module")
def bends():
    return Recording(dict(drive(11, 60.0).channels))


def state(found, name):
    return next(each for each in found.elements if each.name == name)


def changed(recording, name, change):
    read = recording[name]
    return recording.with_channels([Channel(name, read.time, change(read.time, read.values), read.unit)])


def test_fault_free_roads_are_healthy_and_state_their_smallest_fault(bends, straight):
    for made in (bends, straight):
        found = diagnose(made, "rav4", "condition", spread=False)
        assert found.findings[0].status is Status.HEALTHY
    found = diagnose(bends, "rav4", "condition", spread=False)
    assert [each.smallest for each in found.elements if each.status is not Status.HEALTHY] == [None] * 6
    assert (state(found, "yaw_rate").unit, 0.02 < state(found, "yaw_rate").smallest < 0.2) == ("rad/s", True)


@pytest.mark.parametrize("name", ["yaw_rate", "wheel_speed_rear_left"])
def test_an_offset_of_the_stated_size_is_seen(bends, name):
    size = state(diagnose(bends, "rav4", "condition", spread=False), name).smallest
    wrong = injected(bends, [Injected(name, OFFSET, size, 25.0, 35.0).fault])
    assert state(diagnose(wrong, "rav4", "condition", spread=False), name).status is Status.FAULT


@pytest.mark.parametrize(("end", "until"), [(25.0, "to 24.99 s"), (41.0, "on")])
def test_a_yaw_rate_that_rests_is_not_called_fault_free_and_its_span_is_whole(straight, end, until):
    """From 20 s on the car stands, where a frozen reading says nothing, but does not end what began before."""
    made = straight.slice(stop=26.0) if end > 40.0 else straight
    wrong = changed(
        made, "yaw_rate", lambda time, values: np.where((time > 14.995) & (time < end - 0.005), 0.0, values)
    )
    found = diagnose(wrong, "rav4", "condition", spread=False)
    yaw, finding = state(found, "yaw_rate"), found.findings[0]
    assert (yaw.status, finding.status) == (Status.NOT_TESTABLE, Status.NOT_TESTABLE)
    cause = f"its reading stayed the same from 15.00 s {until}"
    assert yaw.cause.startswith(cause)
    assert finding.cause.startswith(f"yaw rate: {cause}")


@pytest.mark.parametrize("sensor", ["yaw_rate", "steering_wheel_angle"])
def test_a_signal_without_values_for_some_seconds_is_named_with_its_times(bends, sensor):
    gap = changed(bends, sensor, lambda time, values: np.where((time >= 25.0) & (time < 30.0), math.nan, values))
    found = diagnose(gap, "rav4", "condition", spread=False)
    assert state(found, sensor).status is Status.NOT_TESTABLE
    assert state(found, sensor).cause.startswith("no reading from 25.0")
    assert found.status.exit_code == 2
    assert "5 of 12 are fault-free" in said(found.findings[0])


@pytest.mark.parametrize(("sensor", "start"), [("yaw_rate", 12.0), ("wheel_speed_front_right", 28.0)])
def test_a_sensor_with_noise_that_is_stuck_for_three_seconds_is_never_fault_free(bends, sensor, start):
    found = diagnose(
        injected(bends, [Injected(sensor, STUCK, math.nan, start, start + 3.0).fault]), "rav4", "condition"
    )
    stuck = state(found, sensor)
    assert stuck.status is Status.FAULT or f"stayed the same from {start - 0.01:.2f} s" in stuck.cause
    assert found.status.exit_code in (1, 2)


def test_a_fault_of_a_car_names_no_torques(bends):
    finding = diagnose(injected(bends, [Injected("yaw_rate", OFFSET, 0.3, 20.0, 30.0).fault]), "rav4", "condition")
    assert finding.findings[0].status is Status.FAULT
    assert "residuals of the readings exceed" in finding.findings[0].cause
    assert "torque" not in finding.findings[0].cause


def test_an_angle_in_degrees_is_named_as_such_with_its_remedy(bends):
    wrong = changed(bends, "steering_wheel_angle", lambda time, values: np.degrees(values))
    finding = diagnose(wrong, "rav4", "condition", spread=False).findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert "steering wheel angle" in finding.cause
    assert "degrees" in finding.cause
    assert "wiring" not in finding.action
    assert "unit" in finding.action
    assert "channel map" in finding.action


def test_a_lateral_acceleration_that_is_frozen_is_called_so(bends):
    wrong = changed(bends, "lateral_acceleration", lambda time, values: np.where(time < 20.0, values, values[2000]))
    found = diagnose(wrong, "rav4", "condition", spread=False)
    (episode,) = state(found, "lateral_acceleration").episodes
    assert episode.kind == "stuck"
    assert 19.4 < episode.start < 21.0
    assert "lateral acceleration sensor: stuck from" in said(found.findings[0])
    assert "deviation" not in said(found.findings[0])


GENTLE = SmallCar(1100.0, 1600.0, 0.95, 1.5, 1.45, 40e3, 0.95, zero=0.01)
FAST = GENTLE._replace(stiffness=34e3, ratio=1.0 / 15.0)
TIGHT = tuple(car for car in (QUADRICYCLE, SCALE_CAR) for _ in range(2))


@pytest.fixture(scope="module")
def small():
    """Drives of small cars, simulated together, by name; those in reverse have speeds without sign."""
    time = np.arange(0.0, 60.0, STEP)
    # At 21 to 24 m/s the car turns about 0.6 times as much as by geometry.
    understeers = 22.5 + 1.5 * np.sin(0.15 * time), 0.018 * (np.sin(0.9 * time) + 0.5 * np.sin(1.63 * time + 1.0))
    ways = {
        "slalom": (GENTLE, (np.full(len(time), 12.0), 0.03 * np.sin(0.6 * time))),
        "fast": (FAST, understeers),
        "slow quadricycle": (QUADRICYCLE, course(5010, 1.7, 30.0)),
        "slow scale car": (SCALE_CAR, course(5010, 0.65, 30.0)),
    }
    ways |= {f"tight {k}": (car, course(5000 + k, car.front + car.rear, 45.0)) for k, car in enumerate(TIGHT)}
    signed = len(ways)
    ways |= {"out": (QUADRICYCLE, backs_out()), "forward": (QUADRICYCLE, backs_out(-1.0))}
    turns = [course(5000 + k, car.front + car.rear, 45.0, reverse=True) for k, car in enumerate(TIGHT)]
    ways |= {f"reverse {k}": each for k, each in enumerate(zip(TIGHT, turns, strict=True))}
    made = recordings(list(ways.values()), 5, unsigned=[k >= signed for k in range(len(ways))])
    return dict(zip(ways, made, strict=True))


def test_a_steering_angle_that_related_signals_call_stuck_is_neither_fault_free_nor_a_fault_of_the_yaw_rate(small):
    """A steering angle that rests in a slalom, whose yaw rate then looks wrong to the filters."""
    read = small["slalom"]
    yaw, speed = read["yaw_rate"], read["vehicle_speed"]
    across = Channel("lateral_acceleration", yaw.time, np.round(yaw.values * speed.values / 0.03) * 0.03, "m/s**2")
    held = Injected("steering_wheel_angle", STUCK, math.nan, 42.0, 52.0).fault
    found = diagnose(injected(read.with_channels([across]), [held]), vehicle_of(GENTLE, "small"), "condition")
    cause = "its reading stayed the same from 42.00 s to 52.00 s while related signals moved"
    yaw, angle = (state(found, name) for name in ("yaw_rate", "steering_wheel_angle"))
    assert (angle.status, yaw.status) == (Status.NOT_TESTABLE,) * 2
    assert angle.cause.startswith(cause)
    assert yaw.cause.startswith("a sensor that stood still contradicted it from 42.00 s to 53.00 s")
    assert f"steering wheel angle: {cause}" in found.findings[0].cause
    assert "bus" not in found.findings[0].action


@pytest.mark.parametrize("factor", [1.0, 1.6, 0.3])
def test_understeer_is_not_called_a_wrong_steering_ratio_and_a_wrong_one_is(small, factor):
    vehicle = vehicle_of(FAST._replace(ratio=factor * FAST.ratio), "small")
    finding = diagnose(small["fast"].slice(10.0, 50.0), vehicle, "condition").findings[0]
    assert ("the steering ratio of the vehicle file" in finding.cause) == (factor != 1.0)
    assert (finding.status is Status.HEALTHY) == (factor == 1.0)


@pytest.fixture(scope="module")
def quadricycle(tmp_path_factory):
    """Vehicle file as a user begins it."""
    path = tmp_path_factory.mktemp("small") / "quadricycle.toml"
    known = {"mass": QUADRICYCLE.mass, "wheelbase": QUADRICYCLE.front + QUADRICYCLE.rear}
    known |= {"track_width": QUADRICYCLE.track, "steering_ratio": QUADRICYCLE.ratio}
    assert (
        main(["new", str(path), "--class", "quadricycle", *(f"{name}={value}" for name, value in known.items())]) == 0
    )
    return path


def test_a_car_that_backs_out_with_unsigned_speeds_has_no_fault_and_one_that_drives_out_does_not_reverse(
    small, quadricycle, tmp_path, capsys
):
    out, forward = small["out"], small["forward"]
    write(out, tmp_path / "out.csv")
    capsys.readouterr()
    chosen = ["--vehicle", str(quadricycle), "--monitor", "condition", "--no-report", "--json"]
    assert main(["diagnose", str(tmp_path / "out.csv"), *chosen]) == 0
    warnings = json.loads(capsys.readouterr().out)["findings"][0]["warnings"]
    (reversing,) = (each for each in warnings if each.startswith("the car reversed"))
    assert reversing == "the car reversed from 4.4 s to 9.0 s; its speeds have no sign"
    finding = diagnose(forward, load(quadricycle), "condition").findings[0]
    assert finding.status is Status.HEALTHY
    assert not any("revers" in each for each in finding.warnings)
    # Where every turn is mirrored, both causes are named and nothing is fault-free.
    mirrored = diagnose(out.slice(stop=10.0), load(quadricycle), "condition").findings[0]
    assert mirrored.status is Status.NOT_TESTABLE
    assert "the car reversed all the time, or the yaw rate has the wrong sign" in mirrored.cause


@pytest.mark.parametrize("way", ["tight", "reverse"])
def test_tight_turns_at_walking_pace_are_no_faults(small, way):
    for k, car in enumerate(TIGHT):
        finding = diagnose(small[f"{way} {k}"], vehicle_of(car), "condition").findings[0]
        assert finding.status not in (Status.FAULT, Status.SUSPECT), finding.headline


@pytest.mark.parametrize(
    ("name", "car", "sensor", "kind", "size"),
    [
        ("slow quadricycle", QUADRICYCLE, "yaw_rate", GAIN, 1.6),
        ("slow scale car", SCALE_CAR, "wheel_speed_front_left", OFFSET, 1.5),
    ],
)
def test_a_fault_of_a_slow_car_is_still_named(small, name, car, sensor, kind, size):
    wrong = injected(small[name], [Injected(sensor, kind, size, 15.0, 25.0).fault])
    found = diagnose(wrong, vehicle_of(car), "condition")
    assert [each.name for each in found.elements if each.status is Status.FAULT] == [sensor]


@pytest.mark.parametrize(
    "heads", [("time", "lateral_acceleration"), ("time", "vehicle_speed", "longitudinal_acceleration")]
)
def test_accelerations_alone_are_too_few_sensors_and_no_crash(heads, tmp_path, capsys):
    rows = ((0.01 * k, *(12.0 + math.sin(0.01 * k),) * (len(heads) - 1)) for k in range(1001))
    lines = (",".join(heads), *(",".join(f"{value:.3f}" for value in row) for row in rows))
    (tmp_path / "few.csv").write_text("\n".join(lines) + "\n")
    assert main(["new", str(tmp_path / "own.toml"), "--class", "midsize", "mass=1500"]) == 0
    assert main(["diagnose", str(tmp_path / "few.csv"), "--vehicle", str(tmp_path / "own.toml"), "--no-report"]) == 3
    assert "fewer than 4 sensors give a reading; the recording has no wheel speed" in capsys.readouterr().err
