"""Proposed maps of drives whose truth is known: names, units and signs, and the recording that they give."""

import csv
from pathlib import Path

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.errors import InputError
from tierod.core.units import split_name
from tierod.io.proposal import propose, text_of
from tierod.io.proposal.units import candidates
from tierod.io.proposal.words import counts_turns, meant_by
from tierod.io.readers import load_channel_map, read
from tierod.io.readers.source import Column
from tierod.io.signs import sign_warnings
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load

STEP, LENGTH, TRACK, WHEELBASE, RATIO = 0.02, 120.0, 1.55, 2.6, 1 / 16.0


def truth(fastest=25.0, seed=3):
    """Signals in SI units of a drive with turns, by canonical name."""
    time = np.arange(0.0, LENGTH, STEP)
    noise = np.random.default_rng(seed).normal
    speed = 0.6 * fastest + 0.4 * fastest * np.sin(0.11 * time)
    angle = (0.5 * np.sin(0.5 * time) + 0.3 * np.sin(1.3 * time)) * 12.0 / np.maximum(speed, 4.0)
    yaw = speed * angle * RATIO / (WHEELBASE + 0.002 * speed**2)
    size = len(time)
    return time, {
        "steering_wheel_angle": angle + noise(0.0, 0.005, size),
        "steering_wheel_rate": np.gradient(angle, STEP) + noise(0.0, 0.02, size),
        "yaw_rate": yaw + noise(0.0, 0.003, size),
        "lateral_acceleration": speed * yaw + 0.2 + noise(0.0, 0.1, size),
        "longitudinal_acceleration": np.gradient(speed, STEP) + noise(0.0, 0.1, size),
        "wheel_speed_rear_left": speed - 0.5 * TRACK * yaw + noise(0.0, 0.02, size),
        "wheel_speed_rear_right": speed + 0.5 * TRACK * yaw + noise(0.0, 0.02, size),
        "vehicle_speed": 1.02 * speed,
        "driver_torque": 0.8 * speed * yaw + noise(0.0, 0.2, size),
    }


TITLES = {
    "steering_wheel_angle": "Lenkradwinkel",
    "steering_wheel_rate": "Lenkradwinkelgeschwindigkeit",
    "yaw_rate": "Gierrate",
    "lateral_acceleration": "Querbeschleunigung",
    "longitudinal_acceleration": "Laengsbeschleunigung",
    "wheel_speed_rear_left": "Radgeschwindigkeit_HL",
    "wheel_speed_rear_right": "Radgeschwindigkeit_HR",
    "vehicle_speed": "Tachogeschwindigkeit",
    "driver_torque": "Handmoment",
}


def written(folder, signals, time, titles, factors):
    """A CSV file with foreign titles, whose values are the truth over the factor of each signal."""
    names = [name for name in titles if name in signals]
    table = np.column_stack([time, *(signals[name] / factors.get(name, 1.0) for name in names)])
    path = folder / "fahrt.csv"
    header = ",".join(["Zeit", *(titles[name] for name in names)])
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.6f")
    return path


DEGREES, KMH = np.pi / 180.0, 1.0 / 3.6

CASES = {
    "SI": {},
    "degrees and km/h": {
        "steering_wheel_angle": DEGREES,
        "steering_wheel_rate": DEGREES,
        "yaw_rate": DEGREES,
        **dict.fromkeys(("wheel_speed_rear_left", "wheel_speed_rear_right", "vehicle_speed"), KMH),
    },
    "wheels in km/h, speed in m/s": dict.fromkeys(("wheel_speed_rear_left", "wheel_speed_rear_right"), KMH),
    "yaw rate in rad/s, turned": {"steering_wheel_angle": DEGREES, "steering_wheel_rate": DEGREES, "yaw_rate": -1.0},
    "lateral acceleration in g, turned": {"lateral_acceleration": -9.80665, "steering_wheel_angle": DEGREES},
    "right is positive": {
        "steering_wheel_angle": -DEGREES, "steering_wheel_rate": -DEGREES, "yaw_rate": -DEGREES,
        "lateral_acceleration": -1.0, "driver_torque": -1.0,
    },
}  # fmt: skip
SLOWLY = ("degrees and km/h", "right is positive")
"""Those of which a drive at walking pace is looked at too: km/h might be m/s, and the motion shows the signs less."""


@pytest.mark.parametrize(
    ("case", "fastest"),
    [
        *((case, 30.0) for case in CASES),
        *((case, 8.0) for case in SLOWLY),
        *(pytest.param(case, 8.0, marks=pytest.mark.slow) for case in CASES if case not in SLOWLY),
    ],
)
def test_the_proposed_map_gives_the_truth(case, fastest, tmp_path):
    time, signals = truth(fastest)
    path = written(tmp_path, signals, time, TITLES, CASES[case])
    target = tmp_path / "car.channels.toml"
    target.write_text(text_of(propose(path)), encoding="utf-8")
    found = read(path, channel_map=target)
    for name, values in signals.items():
        assert found[name].values == pytest.approx(values, abs=2e-4 * max(1.0, np.abs(values).max())), name


def test_turns_of_the_wheels_get_their_radius_from_the_speed(tmp_path):
    time, signals = truth()
    titles = TITLES | {"wheel_speed_rear_left": "n_HL", "wheel_speed_rear_right": "n_HR", "vehicle_speed": "v_kmh"}
    wheels = dict.fromkeys(("wheel_speed_rear_left", "wheel_speed_rear_right"), 0.29 * np.pi / 30.0)
    path = written(tmp_path, signals, time, titles, wheels | {"vehicle_speed": KMH})
    target = tmp_path / "car.channels.toml"
    proposal = propose(path)
    target.write_text(text_of(proposal), encoding="utf-8")
    found = read(path, channel_map=target)["wheel_speed_rear_left"]
    assert found.values == pytest.approx(1.02 * signals["wheel_speed_rear_left"], rel=0.01)


def test_a_wheel_that_turns_otherwise_than_its_axle_gets_no_factor_that_hides_it(tmp_path):
    time, signals = truth()
    titles = TITLES | {"wheel_speed_rear_left": "n_HL", "wheel_speed_rear_right": "n_HR", "vehicle_speed": "v_kmh"}
    turns = 0.29 * np.pi / 30.0
    factors = {"wheel_speed_rear_left": turns / 1.1, "wheel_speed_rear_right": turns, "vehicle_speed": KMH}
    path = written(tmp_path, signals, time, titles, factors)
    entries = {each.signal: each for each in propose(path).entries}
    left, right = (entries[f"wheel_speed_rear_{side}"] for side in ("left", "right"))
    assert left.factor == right.factor
    assert not left.unit.decided
    assert "this wheel turns 9% more: check" in left.unit.reason
    assert "this wheel turns" not in right.unit.reason


def test_without_wheels_the_odd_one_is_turned_and_the_side_is_left_to_check(tmp_path):
    time, signals = truth()
    kept = {name: each for name, each in signals.items() if "wheel_speed" not in name}
    proposal = propose(written(tmp_path, kept, time, TITLES, {"lateral_acceleration": -1.0}))
    signs = {entry.signal: entry.sign for entry in proposal.entries}
    assert signs["lateral_acceleration"].sign == -1
    assert signs["yaw_rate"].sign == 1
    assert "check that left is positive" in signs["yaw_rate"].reason


@pytest.mark.parametrize(("most", "unit", "says"), [(400.0, "m/s", "rpm of the wheel, radius 0.31 m?"),
                                                    (4e4, "count", "plausible in no usual unit")])  # fmt: skip
def test_no_unit_is_proposed_in_which_the_values_are_implausible(tmp_path, most, unit, says):
    time, signals = truth()
    wheels = {name: each * most / np.abs(each).max() for name, each in signals.items() if "wheel_speed" in name}
    path = written(tmp_path, wheels, time, TITLES, {})
    entries = propose(path).entries
    assert {each.unit.unit.name for each in entries} == {unit}
    assert all(each.doubtful and says in each.unit.reason for each in entries)
    target = tmp_path / "car.channels.toml"
    target.write_text(text_of(propose(path)), encoding="utf-8")
    for channel in read(path, channel_map=target).channels.values():
        assert channel.unit == "count" or np.abs(channel.values).max() < 90.0


def test_what_nothing_decides_is_marked(tmp_path):
    time, signals = truth()
    path = written(tmp_path, {"yaw_rate": 0.01 * signals["yaw_rate"]}, time, TITLES, {})
    (entry,) = propose(path).entries
    assert entry.doubtful
    assert "# To check: yaw_rate." in text_of(propose(path))


def test_unmatched_and_doubled_columns_stay_in_the_text_as_comments(tmp_path):
    path = tmp_path / "drive.csv"
    rows = [f"{0.01 * k},{0.1 * (k % 7)},{0.1 * (k % 5)},{k}" for k in range(500)]
    path.write_text("\n".join(['time,Gierrate,YawRate [deg/s],"Tank ""x"""', *rows]))
    proposal = propose(path)
    (entry,) = proposal.entries
    assert (entry.column.title or entry.column.name) == "Gierrate"
    text = text_of(proposal)
    assert "other candidates: 'YawRate" in text
    assert "#   " in text
    assert "Tank" in text


def test_a_recording_without_a_known_name_is_an_error_that_lists_what_it_holds(tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text("\n".join(["time,foo,bar", *(f"{0.01 * k},1,2" for k in range(100))]))
    with pytest.raises(InputError, match=r"'foo', 'bar'.*write the map by hand"):
        propose(path)


def test_the_recorded_car_gets_the_map_that_was_written_by_hand():
    path = shared_data("revsted_slip_angle/obd.csv")
    entries = {entry.signal: entry for entry in propose(path).entries}
    assert entries["lateral_acceleration"].sign.sign == -1
    for name, unit in {"steering_wheel_angle": "deg", "yaw_rate": "deg/s", "wheel_speed_rear_left": "km/h"}.items():
        assert entries[name].unit.unit.name == unit
        assert not entries[name].doubtful


def test_a_bus_with_units_gets_the_signs_of_the_map_that_was_written_by_hand():
    path, car = shared_data("rav4_highway_minute/can.log"), load("rav4")
    entries = {entry.signal: entry for entry in propose(path, car.database).entries}
    by_hand = load_channel_map(car.channel_map).entries
    for name, entry in by_hand.items():
        assert entries[name].sign.sign == entry.sign, name
        assert (entries[name].unit.unit.name == "count") == (entry.unit == "count"), name


@pytest.mark.parametrize("read", [np.abs, np.asarray])
@pytest.mark.parametrize("wrong", ["none", "yaw_rate", "all"])
def test_parking_in_reverse_turns_no_sign(tmp_path, wrong, read):
    time = np.arange(0.0, LENGTH, STEP)
    speed = np.interp(time, [0, 2, 4, 50, 52, 60, 70, 118, 120], [0, 0, -2.5, -2.5, 0, 0, 12.0, 12.0, 0])
    angle = np.where(time < 55.0, 0.5, 0.01) * np.sin(0.5 * time)
    yaw = speed * np.tan(angle) / WHEELBASE + np.random.default_rng(5).normal(0.0, 0.003, len(time))
    signals = {"steering_wheel_angle": angle / RATIO, "yaw_rate": yaw, "lateral_acceleration": speed * yaw}
    for side, name in ((-0.5, "left"), (0.5, "right")):
        signals[f"wheel_speed_rear_{name}"] = read(speed + side * TRACK * yaw)
    signals["vehicle_speed"] = read(speed)
    turned = {"none": (), "yaw_rate": ("yaw_rate",), "all": TURNED}[wrong]
    path = written(tmp_path, signals, time, TITLES, dict.fromkeys(turned, -1.0))
    signs = {entry.signal: entry.sign.sign for entry in propose(path).entries}
    assert {name for name, sign in signs.items() if sign == -1} == set(turned)


TURNED = ("steering_wheel_angle", "yaw_rate", "lateral_acceleration")


def test_titles_of_public_databases_and_loggers_mean_what_they_say():
    """Titles with their sources; what is left out is asked, a wrong signal would be used."""
    with (Path(__file__).parent / "titles.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    found = {row["title"]: meant_by(Column(row["title"], row["unit"], split_name(row["title"])[0])) for row in rows}
    meant = {title: each.signal if each else "" for title, each in found.items()}
    assert [row["title"] for row in rows if meant[row["title"]] not in (row["signal"], "")] == []
    assert sum(meant[row["title"]] == row["signal"] for row in rows) >= 0.85 * len(rows)


@pytest.mark.parametrize(("fastest", "units"), [(100.0, ["rad/s", "rpm", "deg/s"]), (3000.0, ["rpm", "deg/s"])])
def test_a_motor_may_turn_in_rpm(fastest, units):
    assert [each.name for each in candidates("motor_speed", "", np.array([-fastest, 0.0, fastest]))] == units


def test_titles_of_turns():
    assert counts_turns("Raddrehzahl_VL")
    assert counts_turns("n_HL")
    assert not counts_turns("Radgeschwindigkeit_VL")


def test_a_column_that_stands_loses_against_one_that_moves_and_a_demand_is_named(tmp_path):
    time, signals = truth()
    still = {"yaw_rate_2": np.zeros(len(time)), "lateral_acceleration_2": 1.3 * signals["lateral_acceleration"]}
    titles = {
        "yaw_rate_2": "YawRate",
        "yaw_rate": "Gyro_Yaw",
        "vehicle_speed": "v",
        "lateral_acceleration_2": "LatAccDes",
    }
    path = written(tmp_path, signals | still, time, titles, {})
    proposal = propose(path)
    assert {each.signal: each.column.name for each in proposal.entries} == {
        "yaw_rate": "Gyro_Yaw",
        "vehicle_speed": "v",
    }
    assert "\"LatAccDes\"  holds 'des': a demand" in text_of(proposal)


def test_a_sign_bit_belongs_to_its_magnitude(tmp_path):
    time, signals = truth()
    angle, yaw = np.degrees(signals["steering_wheel_angle"]), np.degrees(signals["yaw_rate"])
    columns = {
        "Zeit": time,
        "LK_Lenkradwinkel [deg]": np.abs(angle),
        "LK_VZ_Lenkradwinkel": angle < 0.0,
        "LK_QBit_Lenkradwinkel": np.zeros(len(time)),
        "FD_Gierrate [deg/s]": np.abs(yaw),
        "FD_VZ_Gierrate": yaw < 0.0,
        "FD_Seite": np.sign(yaw),
        "FD_Querbeschleunigung [m/s2]": signals["lateral_acceleration"],
        "FD_v_Signal [km/h]": 3.6 * signals["vehicle_speed"],
    }
    path = tmp_path / "bus.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), "%.6f", ",", header=",".join(columns), comments="")
    proposal = propose(path)
    bits = {entry.signal: entry.sign_from for entry in proposal.entries if entry.sign_from}
    assert bits == {"steering_wheel_angle": "LK_VZ_Lenkradwinkel", "yaw_rate": "FD_VZ_Gierrate"}
    (tmp_path / "map.toml").write_text(text_of(proposal))
    found = read(path, channel_map=tmp_path / "map.toml")
    assert found["steering_wheel_angle"].values == pytest.approx(signals["steering_wheel_angle"], abs=1e-4)
    assert found["yaw_rate"].values == pytest.approx(signals["yaw_rate"], abs=1e-4)
    assert not any("sign" in each for each in sign_warnings(found))
    titles = {"lateral_acceleration": "FD_Querbeschleunigung [m/s2]", "yaw_rate": "FD_Gierrate [deg/s]"}
    plain = "".join(f'[signals.{signal}]\nsource = "{title}"\n' for signal, title in titles.items())
    (tmp_path / "plain.toml").write_text(plain)
    (warning,) = sign_warnings(
        read(path, channel_map=tmp_path / "plain.toml", names=["yaw_rate", "lateral_acceleration"])
    )
    assert warning.startswith("yaw_rate is never negative though lateral_acceleration goes to both sides")
    names = {"LK_Lenkradwinkel [deg]": "steering_wheel_angle", "FD_v_Signal [km/h]": "vehicle_speed"}
    (tmp_path / "all.toml").write_text(plain + "".join(f'[signals.{s}]\nsource = "{t}"\n' for t, s in names.items()))
    (finding,) = diagnose(
        read(path, channel_map=tmp_path / "all.toml"), load("midsize-eps"), monitor="sideslip"
    ).findings
    assert finding.headline.endswith("has no sign")
    assert "sign_from" in finding.action
    (tmp_path / "plain.toml").write_text(plain + 'sign_from = "FD_VZ_Gierate"\n')
    with pytest.raises(
        InputError, match="'FD_VZ_Gierate' for yaw_rate, which is not a column of the file; did you mean"
    ):
        read(path, channel_map=tmp_path / "plain.toml", names=["yaw_rate"])
    (tmp_path / "plain.toml").write_text(plain + 'sign_from = "FD_Seite"\n')
    with pytest.raises(InputError, match="'FD_Seite' of the sign of .* holds -1; sign_from takes a column that is 0"):
        read(path, channel_map=tmp_path / "plain.toml", names=["yaw_rate"])


def test_a_car_that_stands_does_not_turn(tmp_path):
    """An offset of -0.8 deg/s, as rad/s, would turn the standing car, and turns the sign of slow motion."""
    time = np.arange(0.0, 35.0, 0.02)
    speed = np.interp(time, [0, 11, 13, 15, 17.5, 24, 26.5, 29.5], [0, 0, 2.4, 2.5, 0, 0, -1.9, 0])
    yaw = speed * np.tan(np.radians(8.8) / 15) / 2.7
    columns = {"time [s]": time, "YAW_RATE": np.degrees(yaw) - 0.8}
    for name, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        columns[f"wheel_speed_{name} [km/h]"] = np.abs(speed + side * 0.78 * yaw) * 3.6
    path = tmp_path / "yard.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), "%.6f", ",", header=",".join(columns), comments="")
    entry = next(each for each in propose(path).entries if each.signal == "yaw_rate")
    assert (entry.unit.unit.name, entry.sign.sign) == ("deg/s", 1)
