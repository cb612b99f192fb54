"""Text tables of all makes: delimiters, decimal comma, units in titles and rows, vendor headers, damage."""

import base64
import sys

import numpy as np
import pandas as pd
import pytest

from tierod.core.errors import InputError
from tierod.io.readers import csv, read
from tierod.io.readers.clocks import past_midnight
from tierod.io.readers.content import content_of


def written(tmp_path, text, name="drive.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path


def rows(pattern: str, count: int = 50) -> str:
    return "\n".join(pattern.format(t=0.01 * k, v=10.0 + k, k=k) for k in range(count)) + "\n"


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
def test_delimiters(tmp_path, delimiter):
    head = delimiter.join(["time", "yaw_rate [deg/s]", "vehicle_speed [km/h]"])
    path = written(tmp_path, head + "\n" + rows(delimiter.join(["{t:.2f}", "{k}", "{v}"])))
    found = read(path)
    assert found["yaw_rate"].values[3] == pytest.approx(np.radians(3.0))
    assert found["vehicle_speed"].values[0] == pytest.approx(10.0 / 3.6)
    assert found["vehicle_speed"].time[5] == pytest.approx(0.05)


@pytest.mark.parametrize("text", ["#,0", "#time,1\n#0,1\n#1,2\n", "#1;2\n" * 50])
def test_comments_are_no_table(tmp_path, text):
    with pytest.raises(InputError, match="holds no table of numbers"):
        read(written(tmp_path, text))


def test_decimal_comma(tmp_path):
    text = "Zeit [s];Speed [km/h]\n" + rows("{t:.2f};{v:.1f}").replace(".", ",")
    found = read(written(tmp_path, text))["vehicle_speed"]
    assert found.time[1] == pytest.approx(0.01)
    assert found.values[1] == pytest.approx(11.0 / 3.6)
    assert found.unit == "m/s"


def test_a_row_of_units(tmp_path):
    found = read(written(tmp_path, "Time,Speed,YawRate\nms,km/h,°/s\n" + rows("{k},{v},1")))
    assert found["vehicle_speed"].time[2] == pytest.approx(0.002)
    assert found["yaw_rate"].values[0] == pytest.approx(np.radians(1.0))


def test_units_in_the_ending_of_a_name(tmp_path):
    found = read(written(tmp_path, "time_ms,speed_km_h,yaw_rate_deg_s\n" + rows("{k},{v},1")))
    assert found["vehicle_speed"].values[0] == pytest.approx(10.0 / 3.6)
    assert found["yaw_rate"].time[1] == pytest.approx(0.001)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_encodings(tmp_path, encoding):
    found = read(written(tmp_path, "time,yaw_rate [°/s]\n" + rows("{t},1"), encoding=encoding))
    assert found["yaw_rate"].values[0] == pytest.approx(np.radians(1.0))


def test_a_header_of_a_vendor_with_a_clock_per_channel(tmp_path):
    head = "Timestamp,2020-03-16,Timestamp,2020-03-16\nInterval,0.01,Interval,0.02\n"
    head += 'Channel name,"Yaw rate",Channel name,"Speed"\nUnit,"deg/s",Unit,"km/h"\n'
    body = rows("{t},1,{k},36", 20) + "1.0,1,,\n"
    found = read(written(tmp_path, head + body))
    assert len(found["yaw_rate"].time) == 21
    assert len(found["vehicle_speed"].time) == 20
    assert "left out" not in found["vehicle_speed"].note  # rows that only fill the table up are no loss
    assert found["vehicle_speed"].time[1] == pytest.approx(1.0)
    assert found["vehicle_speed"].values[0] == pytest.approx(10.0)


def test_lines_above_the_header_and_text_columns(tmp_path):
    text = "Recorder 7\nDriver,somebody\n\ntime,comment,speed [m/s]\n" + rows('{t},"a, b",{v}')
    found = read(written(tmp_path, text))
    assert found.names == ("vehicle_speed",)
    assert found["vehicle_speed"].values[0] == 10.0


def test_calendar_time(tmp_path):
    body = "\n".join(f"2024-05-29 13:53:59.{k:03d},{k}" for k in range(100))
    found = read(written(tmp_path, "timestamp,speed [m/s]\n" + body + "\n"))
    assert found["vehicle_speed"].time[10] == pytest.approx(0.01, abs=1e-6)
    assert found.metadata["origin"] == pytest.approx(1716990839.0)


@pytest.mark.parametrize(("point", "delimiter"), [(".", ","), (",", ";")])
def test_times_of_a_day_go_onpast_midnight(tmp_path, point, delimiter):
    stamps = [f"23:59:59{point}{k:02d}0" for k in range(50, 100)] + [f"00:00:00{point}{k:02d}0" for k in range(50)]
    body = "\n".join(f"{stamp}{delimiter}{k}" for k, stamp in enumerate(stamps))
    found = read(written(tmp_path, f"Zeit{delimiter}speed [m/s]\n{body}\n"))["vehicle_speed"]
    assert found.time == pytest.approx(86399.5 + 0.01 * np.arange(100))
    assert past_midnight(np.array([0.01, np.nan, 0.02]), 86399.99)[[0, 2]] == pytest.approx([86400.01, 86400.02])


@pytest.mark.parametrize("counter", ["number,", "lap_time,"])
@pytest.mark.parametrize("stamp", ["29/05/2024 13:53:{:02d}", "05/29/2024 13:53:{:02d}", "13h53m{:02d}.5"])
def test_dates_in_other_notations_are_reported_and_nothing_takes_their_place(tmp_path, counter, stamp):
    body = "\n".join(f"{stamp.format(k)},{k},{2 * k}" for k in range(10, 60))
    path = written(tmp_path, f"time,{counter}speed [m/s]\n{body}\n")
    sentence = f"drive.csv: the time column 'time' is written as '{stamp[:6]}.*as a date that reads YYYY-MM-DD hh:mm:ss"
    with pytest.raises(InputError, match=sentence):
        read(path)


def test_a_date_that_is_none_is_shown(tmp_path):
    body = "\n".join(f"2024-05-29 13:53:{k},{k}" if k != 40 else "broken,40" for k in range(10, 60))
    with pytest.raises(InputError, match="the time column 'time' holds 'broken' where dates read YYYY-MM-DD hh:mm:ss"):
        read(written(tmp_path, f"time,speed [m/s]\n{body}\n"))


@pytest.mark.parametrize(
    "cell", ["2024-13-29 13:53:40", "2024-02-30 13:53:40", "2024-05-29 13:61:40", "0000-05-29 13:53:40"]
)
def test_a_date_that_does_not_exist_costs_its_row_and_is_counted(tmp_path, cell):
    body = "\n".join(f"{'2024-05-29 13:53:' + str(k) if k != 40 else cell},{k}" for k in range(10, 60))
    speed = read(written(tmp_path, f"time,speed [m/s]\n{body}\n"))["vehicle_speed"]
    assert len(speed.values) == 49
    assert 40.0 not in speed.values
    assert speed.time[-1] == 49.0
    assert f"1 time stamps do not exist, such as '{cell}'; 1 samples without a time stamp left out" in speed.note


def test_times_of_a_day_and_clocks_of_groups_count_what_does_not_exist(tmp_path):
    stamps = [f"13:53:{k}" for k in range(10, 60)]
    stamps[30] = "13:93:40"
    body = "\n".join(f"{stamp},{k},{stamp if k < 40 else ''},{k if k < 40 else ''}" for k, stamp in enumerate(stamps))
    found = read(written(tmp_path, f"time,speed [m/s],time.2,yaw_rate [rad/s]\n{body}\n"))
    assert (len(found["vehicle_speed"].values), len(found["yaw_rate"].values)) == (49, 39)
    assert "1 time stamps do not exist, such as '13:93:40'" in found["vehicle_speed"].note
    assert "1 time stamps do not exist, such as '13:93:40'" in found["yaw_rate"].note


def test_stamps_of_a_group_that_are_no_numbers_are_counted(tmp_path):
    cells = [f"{0.01 * k:.2f}" if k != 30 else "x" for k in range(60)]
    body = "\n".join(f"{cell},{k},{cell if k < 40 else ''},{k if k < 40 else ''}" for k, cell in enumerate(cells))
    found = read(written(tmp_path, f"time,speed [m/s],time.2,yaw_rate [rad/s]\n{body}\n"))
    for name, count in (("vehicle_speed", 59), ("yaw_rate", 39)):
        assert len(found[name].values) == count
        assert "1 time stamps are not numbers" in found[name].note


def test_a_date_in_words_beside_a_time_does_no_harm(tmp_path):
    text = "date,time zone,lap_time,speed [m/s]\n" + rows("29.05.2024,UTC,{t:.2f},{v}")
    assert read(written(tmp_path, text))["vehicle_speed"].time[2] == pytest.approx(0.02)


def test_missing_cells_and_infinity(tmp_path):
    text = "time,speed [m/s]\n0.0,1\n0.1,\n0.2,NaN\n0.3,inf\n0.4,n/a\n0.5,6\n0.6,7\n"
    found = read(written(tmp_path, text))["vehicle_speed"]
    assert np.isnan(found.values).tolist() == [False, True, True, True, True, False, False]
    assert "1 infinite values taken as missing" in found.note


def test_infinite_values_side_by_side_are_read_without_a_warning(tmp_path):
    found = read(written(tmp_path, "time,speed [m/s]\n0.0,inf\n0.1,inf\n0.2,3\n0.3,4\n"))["vehicle_speed"]
    assert np.isnan(found.values).tolist() == [True, True, False, False]


def test_half_a_file_gives_its_good_part(tmp_path):
    text = "time,speed [m/s],yaw_rate [rad/s]\n" + rows("{t:.2f},{v},0.1") + "0.50,1"
    found = read(written(tmp_path, text))
    assert len(found["vehicle_speed"].time) == 50
    assert found.warnings == ("1 of 51 lines are broken and were left out",)


def test_cells_of_several_lines(tmp_path):
    text = "time,speed [m/s],note\n" + rows("{t:.2f},{v},ab", 2000) + rows('2{t:.2f},{v},"a\nb"', 200_000)
    assert len(read(written(tmp_path, text))["vehicle_speed"].time) == 202_000


def test_a_quotation_mark_that_is_not_closed_costs_no_other_line(tmp_path):
    text = "time,speed [m/s],note\n" + rows("{t:.2f},{v},ab", 300) + '3.00,1,"ab\n' + rows("3{t:.2f},{v},ab", 300)
    assert len(read(written(tmp_path, text))["vehicle_speed"].time) == 601


def test_a_cell_that_is_no_number(tmp_path):
    text = "time,speed [m/s]\n" + rows("{t:.2f},{v}", 300).replace("0.05,15.0", "0.05,error")
    found = read(written(tmp_path, text))["vehicle_speed"]
    assert np.isnan(found.values[5])
    assert np.isfinite(np.delete(found.values, 5)).all()
    assert "1 cells are not numbers" in found.note


def test_only_the_column_with_the_bad_cell_is_read_as_text(tmp_path, monkeypatch):
    seen: list[int] = []
    by_cell = csv._cell_by_cell
    monkeypatch.setattr(csv, "_cell_by_cell", lambda cells, decimal: seen.append(len(cells)) or by_cell(cells, decimal))
    body = rows("{t:.2f};{v:.1f};{k};;{k}", 3000).replace(".", ",")
    text = "time;speed [m/s];count;empty;other\n" + body.replace(";2999;;2999\n", ";2999;;oops\n")
    found = read(written(tmp_path, text))
    assert seen == [3000]
    assert "1 cells are not numbers" in found["other"].note
    assert np.isnan(found["other"].values).tolist() == [False] * 2999 + [True]
    assert np.isnan(found["empty"].values).all()
    assert found["count"].values.tolist() == list(range(3000))
    assert found["vehicle_speed"].values[-1] == 3009.0
    assert found["vehicle_speed"].note == ""


def test_no_thread_of_the_library_holds_memory_of_python(tmp_path):
    """It would free it as the process ends, and abort it."""
    path = tmp_path / "drive.csv"
    path.write_bytes(b"time,yaw_rate,steps\n" + b"1,2,3\n" * 2000 + b"1,2\n")
    content = content_of(path, packed=False)
    table = csv.Table(content)
    (block,) = table.blocks()
    held = sys.getrefcount(block)
    for _ in range(400):
        rows = table.rows(block, ["time", "yaw_rate", "steps"])
        assert rows.broken == 1
        assert sys.getrefcount(block) == held


def test_without_names_the_counting_column_is_the_time(tmp_path):
    found = read(written(tmp_path, rows("{t},{v:.0f},1")))
    assert found.names == ("column 2", "column 3")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("some words\nand more of them\n", "holds no table of numbers"),
        ("speed,torque\n1,2\n1,1\n0,3\n", "there is no time column"),
        (
            "time,speed,torque\n0,00,1,5,2,5\n0,01,1,5,2,5\n",
            "3 names above 6 columns: its numbers have a decimal comma",
        ),
        (
            "Channel : Speed\nRange : 20000,0\n" + "".join(f"14:15:00.{k:02d}0,{k},0,1\n" for k in range(20)),
            "2 names above 4 columns; write one row of names above the numbers",
        ),
        ("time,comment\n0,a\n1,b\n2,c\n", "no other column of numbers|no table"),
        ("time [N],speed\n0,1\n1,2\n2,3\n", "the unit 'N' cannot become|cannot become 's'"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path, text, sentence):
    with pytest.raises(InputError, match=sentence):
        read(written(tmp_path, text))


@pytest.mark.parametrize("broken", [b"0.50,\xfcber,3\n", b"0.50,\xff\xfe\n", b"0.50,\xb0\xb0,\xb5\n"])
def test_bytes_that_are_no_unicode_do_no_harm(tmp_path, broken):
    rows = [f"{0.01 * k:.2f},{k},{2 * k}\n".encode() for k in range(60)]
    path = tmp_path / "drive.csv"
    path.write_bytes(b"time,yaw_rate [\xb0/s],b\n" + b"".join([*rows[:50], broken, *rows[51:]]))
    recording = read(path)
    assert recording["yaw_rate"].values[49] == pytest.approx(np.radians(49.0))
    assert recording["yaw_rate"].values[-1] == pytest.approx(np.radians(59.0))


def test_rows_of_empty_cells_in_the_heading_hide_neither_names_nor_units(tmp_path):
    rows = "".join(f"{k / 20},{50 + k % 3},{k % 5 / 10},{k % 7}\n" for k in range(100))
    heading = "Format,CSV File,,\n,,,\nTime,GPS Speed,GPS LatAcc,GPS Gyro\ns,km/h,g,deg/s\n,,,\n"
    (tmp_path / "kart.csv").write_text(heading + rows)
    recording = read(tmp_path / "kart.csv")
    assert recording.names == ("vehicle_speed", "lateral_acceleration", "yaw_rate")
    assert recording["vehicle_speed"].values.max() == pytest.approx(52 / 3.6)


@pytest.mark.parametrize("kind", ["csv", "parquet", "feather"])
def test_blank_cells_between_regular_samples_are_none_and_lost_ones_are_missing(tmp_path, kind):
    time = np.arange(0, 4000) * 0.01
    table = pd.DataFrame({"time": time, "steering_wheel_angle [rad]": np.sin(time)})
    slow = pd.DataFrame({"time": time[::5] + 0.003, "yaw_rate [rad/s]": 0.1 * np.sin(time[::5])})
    slow["vehicle_speed [m/s]"] = np.where(np.random.default_rng(1).random(800) < 0.1, np.nan, 20.0)
    table = pd.concat([table, slow]).sort_values("time", ignore_index=True)
    path = tmp_path / f"drive.{kind}"
    getattr(table, f"to_{kind}")(path, **({"index": False} if kind == "csv" else {}))
    found = read(path)
    assert len(found["steering_wheel_angle"].time) == 4000
    assert np.isfinite(found["steering_wheel_angle"].values).all()
    assert np.diff(found["yaw_rate"].time) == pytest.approx(0.05)
    assert np.isfinite(found["yaw_rate"].values).all()


@pytest.mark.parametrize("kind", ["tsv", "vbo", "parquet"])
def test_a_time_of_day_as_digits_of_one_number(tmp_path, kind):
    seconds = 9 * 3600 + 58 * 60 + np.arange(0, 1500) * 0.1
    hours, minutes = seconds // 3600, seconds // 60 % 60
    digits = [f"{1e4 * h + 1e2 * m + s % 60:09.2f}" for h, m, s in zip(hours, minutes, seconds, strict=True)]
    path = tmp_path / f"drive.{kind}"
    if kind == "parquet":
        pd.DataFrame({"time": np.array(digits, dtype=float), "velocity [km/h]": 54.0}).to_parquet(path)
    elif kind == "tsv":
        path.write_text("sats\ttime\tvelocity [km/h]\n" + "".join(f"8\t{t}\t54.0\n" for t in digits))
    else:
        head = (
            "[header]\nsatellites\ntime\nvelocity kmh\nYaw_Rate\n\n[channel units]\ndeg/s\n\n[comments]\nof a drive\n\n"
            "[column names]\nsats time velocity Yaw_Rate\n"
        )
        path.write_text(head + "\n[data]\n" + "".join(f"008 {t} +054.000 +1.80000E+01 \n" for t in digits))
        assert read(path)["yaw_rate"].values == pytest.approx(np.radians(18.0))
    found = read(path)["vehicle_speed"]
    assert found.time[-1] - found.time[0] == pytest.approx(149.9)
    assert np.diff(found.time) == pytest.approx(0.1)
    assert found.values == pytest.approx(15.0)
    assert "time of day" in found.note


def test_seconds_that_look_like_digits_of_a_day_stay_seconds(tmp_path):
    found = read(written(tmp_path, "time,speed [m/s]\n" + "".join(f"{120030 + 0.5 * k},{k}\n" for k in range(100))))
    assert np.diff(found["vehicle_speed"].time) == pytest.approx(0.5)


def test_channels_listed_above_the_data_name_the_columns(tmp_path):
    above = "%Log%\nChannel : Engine Speed\nRange : 20000,0\nChannel : Speed [km/h]\nRange : 400,0\n"
    found = read(written(tmp_path, above + "".join(f"14:15:{0.02 * k:06.3f},900,36\n" for k in range(100))))
    assert set(found.channels) == {"Engine Speed", "vehicle_speed"}
    assert found["vehicle_speed"].values == pytest.approx(10.0)


_DATABASE = """VERSION ""

BS_:

BU_: X

BO_ 288 STEER: 8 X
 SG_ SteeringWheelAngle : 0|16@1- (0.1,0) [-900|900] "deg" X
"""
_LAYOUTS = {
    "plain": ("time,addr,bus,data", "{t:.2f},0x120,0,0x{hex}"),
    "spaces": ("Time;CAN ID;DLC;Data", "{t:.2f};120h;8;{spaced}"),
    "savvycan": ("Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8", "{us},00000120,false,Rx,0,8,{cells},"),
    "epoch": (
        "TimestampEpoch;BusChannel;ID;IDE;DLC;DataLength;Dir;EDL;BRS;DataBytes",
        "{t:.2f};1;00000120;0;8;8;0;0;0;{hex}",
    ),
    "decimal bytes": (
        "Time,Channel,ID,Flags,DLC,Data0,Data1,Data2,Data3,Data4,Data5,Data6,Data7,Counter,AbsTime",
        "{t:.2f},1,288,0,8,{decimal},7,2024-05-13",
    ),
    "time of day": ("Time,Tx/Rx,Channel,Msg Type,ID,DLC,Data Byte(s)", "10:12:{t:05.2f},Rx,1,s,0x120,8,{spaced}"),
    "brackets": (
        "Timestamp,CAN ID,DLC,DATA[0],DATA[1],DATA[2],DATA[3],DATA[4],DATA[5],DATA[6],DATA[7],Flag",
        "{t:.2f},0120,8,{cells},R",
    ),
    "python-can": ("timestamp,arbitration_id,extended,remote,error,dlc,data", "{t:.2f},0x120,0,0,0,8,{coded}"),
}


@pytest.mark.parametrize("layout", _LAYOUTS)
def test_rows_that_are_can_frames(tmp_path, layout):
    heading, row = _LAYOUTS[layout]
    (tmp_path / "car.dbc").write_text(_DATABASE)
    lines = [heading]
    for k in range(200):
        data = (10 * k - 1000).to_bytes(2, "little", signed=True) + bytes(6)
        text = data.hex().upper()
        pairs = [text[at : at + 2] for at in range(0, 16, 2)]
        coded = base64.b64encode(data).decode()
        lines.append(
            row.format(
                t=0.01 * k,
                us=10000 * k,
                hex=text,
                spaced=" ".join(pairs),
                cells=",".join(pairs),
                coded=coded,
                decimal=",".join(map(str, data)),
            )
        )
    path = written(tmp_path, "\n".join([*lines, "broken,row"]) + "\n")
    found = read(path, dbc=tmp_path / "car.dbc")
    angle = found["steering_wheel_angle"]
    assert np.diff(angle.time) == pytest.approx(0.01)
    assert np.degrees(angle.values) == pytest.approx(np.arange(200) - 100.0)
    assert "1 of 201 rows are no CAN frames" in " ".join(found.metadata["warnings"])
    with pytest.raises(InputError, match=r"200 CAN frames of 1 identifiers \(0x120\); a DBC file"):
        read(path)


@pytest.mark.parametrize(
    "names",
    ["time,id,data,speed [m/s]", "time,id,d1,speed [m/s]", "time,name,value,speed [m/s]", "time,address,b1,speed"],
)
def test_usual_tables_with_names_of_frames_or_long_tables_stay_tables(tmp_path, names):
    found = read(written(tmp_path, names + "\n" + "".join(f"{0.05 * k:.2f},17,{1000 + k},12.5\n" for k in range(100))))
    assert len(found.channels) == 3
    assert found["vehicle_speed"].values == pytest.approx(12.5)
