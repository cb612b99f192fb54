"""Channel maps and guesses: signs, factors, units, and errors that name file, key and nearest names."""

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.io.readers import LACKING, load_channel_map, parse_channel_map, read
from tierod.io.writers import write

TABLE = "time,T_hand,SWA,speed [km/h],ay [g],b_raw,foo [bananas]\n" + "".join(
    f"{0.01 * k:.2f},{k},{k % 7},36,1,{2 * k},{k}\n" for k in range(50)
)


@pytest.fixture
def drive(tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text(TABLE)
    return path


def mapped(tmp_path, text):
    path = tmp_path / "car.toml"
    path.write_text(text)
    return path


def test_sign_factor_offset_and_unit(drive, tmp_path):
    text = '[signals.driver_torque]\nsource = "T_hand"\nunit = "N*m"\nsign = -1\nfactor = 0.5\noffset = 2.0\n'
    text += 'note = "why"\n'
    found = read(drive, channel_map=mapped(tmp_path, text))["driver_torque"]
    assert found.values[:3].tolist() == [2.0, 1.5, 1.0]
    assert found.unit == "N*m"
    assert found.source == "T_hand"
    assert found.note == "why; sign turned, times 0.5, offset +2 N*m"


def test_the_offset_is_in_the_unit_of_the_source(drive, tmp_path):
    text = '[signals.steering_wheel_angle]\nsource = "SWA"\nunit = "deg"\noffset = 180.0\n'
    found = read(drive, channel_map=mapped(tmp_path, text))["steering_wheel_angle"]
    assert found.values[0] == pytest.approx(np.pi)


def test_a_sum_of_sources(drive, tmp_path):
    text = '[signals.steering_wheel_angle]\nsource = ["SWA", "b_raw"]\nunit = "rad"\n'
    found = read(drive, channel_map=mapped(tmp_path, text))["steering_wheel_angle"]
    assert found.values[:3].tolist() == [0.0, 3.0, 6.0]
    assert found.source == "SWA + b_raw"


def test_counts_stay_counts(drive, tmp_path):
    text = '[signals.motor_torque]\nsource = "b_raw"\nunit = "count"\n'
    found = read(drive, channel_map=mapped(tmp_path, text))["motor_torque"]
    assert found.unit == "count"
    assert found.note == "raw counts, not calibrated"


def test_the_rest_is_guessed_beside_a_map(drive, tmp_path):
    found = read(drive, channel_map=mapped(tmp_path, '[signals.motor_torque]\nsource = "b_raw"\nunit = "count"\n'))
    assert found["vehicle_speed"].values[0] == pytest.approx(10.0)
    assert found["lateral_acceleration"].values[0] == pytest.approx(9.80665)
    assert "b_raw" not in found


def test_names_choose_what_is_loaded(drive):
    assert read(drive, names=["vehicle_speed"]).names == ("vehicle_speed",)
    assert read(drive, names=["T_hand", "yaw_rate"]).names == ("T_hand",)


def test_an_unknown_unit_leaves_the_column_under_its_own_name(drive):
    found = read(drive)
    assert found["foo [bananas]"].unit == "bananas"
    assert "is not known" in found["foo [bananas]"].note


def test_unknown_unit_of_a_wanted_signal(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("time [s],yaw_rate [bananas],speed [m/s]\n" + "".join(f"{k},1,2\n" for k in range(9)))
    sentence = (
        "'yaw_rate .bananas.' could be yaw_rate, but the unit 'bananas' is not known.*give its unit in a channel map"
    )
    with pytest.raises(InputError, match=sentence):
        read(path, names=["yaw_rate"])
    assert "could be yaw_rate" in read(path).warnings[0]
    mapping = mapped(tmp_path, '[signals.yaw_rate]\nsource = "yaw_rate [bananas]"\nunit = "bananas"\n')
    with pytest.raises(InputError, match=r"car.toml: \[signals.yaw_rate\] the unit 'bananas' is not known"):
        read(path, channel_map=mapping)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            '[signals.driver_torqe]\nsource = "T"\n',
            "'driver_torqe' is not a canonical signal; did you mean 'driver_torque'",
        ),
        (
            '[signals.driver_torque]\nsorce = "T"\n',
            r"\[signals.driver_torque\] the key 'sorce' is not known; did you mean 'source'",
        ),
        (
            '[signals.driver_torque]\nsource = "T_hnd"\n',
            "csv: .*source 'T_hnd' is not in the file; did you mean 'T_hand'",
        ),
        ('[signals.driver_torque]\nunit = "N*m"\n', "needs source"),
        ('[signals.driver_torque]\nsource = "T_hand"\nsign = 2\n', "must be 1 or -1"),
        ('[signals.driver_torque]\nsource = "T_hand"\nsign = true\n', "sign = True is not a number"),
        ('[signals.driver_torque]\nsource = "T_hand"\nunit = 3\n', "unit = 3 is not a text"),
        ('[signals.driver_torque]\nsource = "T_hand"\nunit = "deg"\n', r"'deg' cannot become 'N\*m'"),
        ('[sgnals.driver_torque]\nsource = "T_hand"\n', "the key 'sgnals' is not known; did you mean 'signals'"),
        ("signals = 3\n", "no signals"),
        ("[signals\n", "is not valid TOML"),
    ],
)
def test_wrong_maps(drive, tmp_path, text, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        read(drive, channel_map=mapped(tmp_path, text))
    assert "car.toml" in str(caught.value)


def test_no_map(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        load_channel_map(tmp_path / "absent.toml")


def test_an_optional_source_may_be_absent(drive, tmp_path):
    text = '[signals.motor_torque]\nsource = "absent"\nunit = "N*m"\noptional = true\n'
    assert "motor_torque" not in read(drive, channel_map=mapped(tmp_path, text))


BOTH = (
    '[signals.driver_torque]\nsource = "T_hnd"\nunit = "N*m"\n'
    '[signals.steering_wheel_angle]\nsource = "SWA"\nunit = "deg"\n'
)


def test_a_source_that_the_file_lacks_leaves_the_others(drive, tmp_path):
    found = read(drive, channel_map=mapped(tmp_path, BOTH))
    assert "driver_torque" not in found
    assert "steering_wheel_angle" in found
    (warning,) = [each for each in found.warnings if "driver_torque" in each]
    assert (
        "car.toml names 'T_hnd' for driver_torque, which is not a column of the file; did you mean 'T_hand'?" in warning
    )
    assert "optional = true below [signals.driver_torque]" in warning
    optional = mapped(tmp_path, BOTH.replace('"T_hnd"', '"T_hnd"\noptional = true'))
    assert not any("driver_torque" in each for each in read(drive, channel_map=optional).warnings)
    unasked = read(drive, channel_map=mapped(tmp_path, BOTH), names=["steering_wheel_angle"])
    assert not any("driver_torque" in each for each in unasked.warnings)


def test_no_column_is_proposed_that_the_map_uses_already(drive, tmp_path):
    text = BOTH + '[signals.motor_torque]\nsource = "T_hand"\nunit = "N*m"\n'
    (warning,) = [each for each in read(drive, channel_map=mapped(tmp_path, text)).warnings if "T_hnd" in each]
    assert "T_hand" not in warning


def test_a_sum_that_lacks_a_source_is_left_out(drive, tmp_path):
    text = BOTH.replace('"T_hnd"', '["T_hand", "absent"]')
    found = read(drive, channel_map=mapped(tmp_path, text))
    assert "driver_torque" not in found
    assert any("names 'absent' for driver_torque" in each for each in found.warnings)


def test_where_all_that_is_asked_for_is_lacking_the_column_is_named(drive, tmp_path):
    with pytest.raises(InputError, match=r"drive.csv: .*names 'T_hnd' for driver_torque"):
        read(drive, channel_map=mapped(tmp_path, BOTH), names=["driver_torque"])


def test_a_written_recording_lacks_nothing_of_a_map(drive, tmp_path):
    write(read(drive, channel_map=mapped(tmp_path, BOTH)), tmp_path / "again.parquet")
    assert LACKING not in read(tmp_path / "again.parquet").metadata


def test_a_source_is_found_without_regard_to_case_and_punctuation(drive):
    found = read(
        drive, channel_map=parse_channel_map({"signals": {"driver_torque": {"source": "t-HAND", "unit": "Nm"}}})
    )
    assert found["driver_torque"].source == "T_hand"


def test_general_words_of_other_components_are_not_taken_for_the_vehicle(tmp_path):
    path = tmp_path / "x.csv"
    titles = "time,Engine.Speed [rpm],Wiper.v,Brake.speed_km_h,Fan.speed_deg"
    path.write_text(titles + "\n" + "".join(f"{k},900,1,36,5\n" for k in range(9)))
    found = read(path)
    assert found["vehicle_speed"].source == "Brake.speed_km_h"
    assert found["vehicle_speed"].values[0] == pytest.approx(10.0)
    assert {"Engine.Speed [rpm]", "Wiper.v", "Fan.speed_deg"} < set(found.names)
    assert found.warnings == ()


def test_a_wrong_wanted_name(drive):
    with pytest.raises(
        InputError, match="'yaw_rte' is neither a signal nor a column of the file; did you mean 'yaw_rate'"
    ):
        read(drive, names=["yaw_rte"])


def test_none_of_the_wanted_signals(drive):
    with pytest.raises(InputError, match="holds none of yaw_rate; it holds 'T_hand'.*write a channel map"):
        read(drive, names=["yaw_rate"])


def test_a_missing_unit_is_taken_as_si_and_said(drive):
    found = read(drive)
    assert found["steering_wheel_angle"].note == "unit not given, taken as rad"
    assert any("steering_wheel_angle" in warning and "confirm it" in warning for warning in found.warnings)


def test_a_missing_unit_that_looks_like_degrees(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("time,SWA\n" + "".join(f"{0.01 * k:.2f},{5 * k}\n" for k in range(50)))
    (warning,) = read(path).warnings
    assert 'reaches 245 and looks like deg: give unit = "deg"' in warning


@pytest.mark.parametrize(
    ("top", "sentence"),
    [(30.0, "was taken as m/s: confirm it"), (120.0, 'reaches 120 m/s: if it is km/h, give unit = "km/h"')],
)
def test_a_speed_without_a_unit_is_a_guess_that_is_reported(tmp_path, top, sentence):
    path = tmp_path / "x.csv"
    path.write_text("time,speed\n" + "".join(f"{0.1 * k:.1f},{top * k / 49}\n" for k in range(50)))
    (warning,) = read(path).warnings
    assert sentence in warning


def test_the_unit_is_that_of_the_value_after_the_factor(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("time,I_q [A]\n" + "".join(f"{0.1 * k:.1f},{k}\n" for k in range(50)))
    text = '[signals.motor_torque]\nsource = "I_q [A]"\nfactor = 0.05\n'
    found = read(path, channel_map=mapped(tmp_path, text + 'unit = "N*m"\n'))["motor_torque"]
    assert found.unit == "N*m"
    assert found.values[-1] == pytest.approx(49 * 0.05)
    for unit in ("", 'unit = "A"\n'):
        with pytest.raises(InputError, match=r"'A' cannot become 'N\*m'.*offset: give unit = \"N\*m\""):
            read(path, channel_map=mapped(tmp_path, text + unit))


def test_two_columns_that_could_be_the_same_signal(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("time,speed [m/s],velocity [m/s]\n" + "".join(f"{k},1,2\n" for k in range(9)))
    found = read(path)
    assert found["vehicle_speed"].values[0] == 1.0
    assert found["velocity [m/s]"].values[0] == 2.0
    assert "vehicle_speed is taken from 'speed [m/s]'; 'velocity [m/s]' could be this signal too" in found.warnings[0]


@pytest.mark.parametrize(("line", "sentence"), [("factor = 0", "other than 0"), ("offset = nan", "must be a finite")])
def test_a_map_that_makes_nothing_of_a_signal_is_refused(drive, tmp_path, line, sentence):
    with pytest.raises(InputError, match=sentence):
        read(drive, channel_map=mapped(tmp_path, f'[signals.driver_torque]\nsource = "T_hand"\n{line}\n'))


def test_sources_of_different_units_are_not_summed(drive, tmp_path):
    text = '[signals.vehicle_speed]\nsource = ["speed [km/h]", "ay [g]"]\n'
    with pytest.raises(InputError, match=r"units of the sources differ \(km/h, g\)"):
        read(drive, channel_map=mapped(tmp_path, text))


def test_a_map_for_the_bus_does_not_hinder_a_converted_file(tmp_path):
    path = tmp_path / "converted.csv"
    path.write_text("time,yaw_rate [rad/s]\n0,0.1\n1,0.2\n2,0.3\n")
    text = '[signals.yaw_rate]\nsource = "BUS.YAW"\nunit = "deg/s"\nsign = -1\n'
    recording = read(path, channel_map=mapped(tmp_path, text))
    assert recording["yaw_rate"].values.tolist() == [0.1, 0.2, 0.3]
    assert any("names no column of this file" in warning for warning in recording.warnings)


def test_a_mapped_signal_is_not_taken_raw_where_its_column_has_the_same_name(tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text("time,yaw_rate\n" + "".join(f"{0.01 * k:.2f},{k}\n" for k in range(50)))
    text = '[signals.yaw_rate]\nsource = "yaw_rate"\nunit = "deg/s"\n'
    found = read(path, channel_map=mapped(tmp_path, text), names=["yaw_rate"])["yaw_rate"]
    assert found.unit == "rad/s"
    assert found.values[-1] == pytest.approx(np.radians(49.0))


def test_a_truth_that_is_asked_for_may_be_absent(drive):
    assert "truth_sideslip_angle" not in read(drive, names=["steering_wheel_angle", "truth_sideslip_angle"])
