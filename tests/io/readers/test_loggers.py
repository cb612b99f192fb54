"""Exports of loggers and apps: rows of sources, dates apart, weeks of satellites, JSON, long tables."""

import json

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.io.readers import read

COUNT, STEP = 400, 0.05
TIME = STEP * np.arange(COUNT)
SPEED = 15.0 + 3.0 * np.sin(TIME / 9.0)
YAW = 0.1 * np.sin(TIME / 2.0)


def _records():
    return [
        {"timestamp": 1714557120.0 + t, "vehicle_speed": v, "imu": {"yaw_rate": r}}
        for t, v, r in zip(TIME, SPEED, YAW, strict=True)
    ]


def _long(row):
    return [row(t, name, x) for t, v, r in zip(TIME, SPEED, YAW, strict=True) for name, x in _both(v, r)]


def _both(speed, yaw):
    return ("vehicle_speed", speed), ("yaw_rate", yaw)


def _rows_of_numbers():
    return np.column_stack([TIME, SPEED, YAW]).tolist()


def _rows(row):
    lines = (row.format(t=t, v=v, r=r, deg=np.degrees(r)) for t, v, r in zip(TIME, SPEED, YAW, strict=True))
    return "".join(lines)


def _date(t):
    return f"01.05.2024;23:59:{50.0 + t:06.3f}" if t < 9.9999 else f"02.05.2024;00:00:{t - 9.9999:06.3f}"


FILES = {
    "rows of units and sources": (
        "lap.csv",
        "Format,3\nCreated,01/05/2024,10:12\n\ntimestamp,lap,speed,yaw_rate\nunix time,,m/s,deg/s\n,,100: gps,101\n"
        + _rows("{t:.3f},1,{v:.6f},{deg:.6f}\n"),
    ),
    "date and time of a day apart, past midnight": (
        "fahrt.csv",
        "Datum;Uhrzeit;Fahrgeschwindigkeit [km/h];yaw_rate [Grad/s]\n"
        + "".join(
            f"{_date(t)};" + f"{3.6 * v:.6f};{np.degrees(r):.6f}\n".replace(".", ",")
            for t, v, r in zip(TIME, SPEED, YAW, strict=True)
        ),
    ),
    "seconds of a week that ends": (
        "gnss.csv",
        "GPS_week,GPS_TOW[s],speed [m/s],yaw_rate [rad/s]\n"
        + "".join(
            f"2300,{(604790.0 + t) % 604800.0:.3f},{v:.6f},{r:.6f}\n" for t, v, r in zip(TIME, SPEED, YAW, strict=True)
        ),
    ),
    "month in words": (
        "phone.csv",
        "GPS Time, Device Time,GPS Speed (Meters/second),yaw_rate(rad/s)\n"
        + _rows("Wed May 01 10:12:00 GMT+02:00 2024,01-May-2024 10:12:{t:06.3f},{v:.6f},{r:.6f}\n"),
    ),
    "JSON lines": ("drive.jsonl", "".join(json.dumps(each) + "\n" for each in _records())),
    "JSON of records": ("drive.json", json.dumps({"data": _records()})),
    "JSON of columns": ("drive.json", json.dumps({"t": list(TIME), "speed": list(SPEED), "yaw_rate": list(YAW)})),
    "JSON of samples": (
        "drive.json",
        "".join(_long(lambda t, name, x: json.dumps({"timestamp": t, "name": name, "value": x}) + "\n")),
    ),
    "long table": (
        "drive.csv", "time [s];signal;value;unit\n" + "".join(_long(lambda t, name, x: f"{t:.3f};{name};{x:.6f};\n")),
    ),
    "JSON of columns and rows": (
        "drive.json",
        json.dumps({"columns": ["time", "vehicle_speed", "yaw_rate"], "index": [], "data": _rows_of_numbers()}),
    ),
    "JSON with a structure for each signal": (
        "drive.json", json.dumps({n: {"t": list(TIME), "v": list(x)} for n, x in _both(SPEED, YAW)}),
    ),
    "JSON with a list of signals": (
        "drive.json",
        json.dumps(
            {"a": 1, "b": [{"name": n, "time": list(TIME), "values": list(x)} for n, x in _both(SPEED, YAW)]}
        ),
    ),
    "JSON lines of rows": (
        "drive.jsonl",
        "".join(json.dumps(row) + "\n" for row in [["time", "vehicle_speed", "yaw_rate"], *_rows_of_numbers()]),
    ),
    "JSON of quantities with the stamps of ROS": (
        "drive.jsonl",
        "".join(
            f'{{"stamp": {{"secs": 7, "nsecs": {round(1e9 * t)}}}, "speed": {{"value": {v}, "unit": "m/s"}}, '
            f'"yaw_rate": {r}}}\n'
            for t, v, r in _rows_of_numbers()
        ),
    ),
    "a time before each signal": (
        "drive.csv",
        "Time_Speed [s];Speed [m/s];Time_Yaw [s];yaw_rate [rad/s]\n"
        + "".join(f"{2.0 * t:.3f};{v:.6f};{t:.3f};{r:.6f}\n" for t, v, r in _rows_of_numbers()),
    ),
    "date and time of a day as digits": (
        "drive.csv",
        "Date,UTC Time,speed [m/s],yaw_rate [rad/s]\n"
        + "".join(f"130524,0905{t:06.3f},{v:.6f},{r:.6f}\n" for t, v, r in _rows_of_numbers()),
    ),
    "titles in comments": (
        "drive.txt", "# of NumPy\n# time speed yaw_rate\n# s m/s rad/s\n" + _rows("{t:.3f} {v:.6f} {r:.6f}\n"),
    ),
    "a comment above titles": (
        "drive.csv", "# time of test, a, b\ntime,speed [m/s],yaw_rate\n" + _rows("{t:.3f},{v:.6f},{r:.6f}\n"),
    ),
    "titles of several words apart by spaces": (
        "drive.txt", "Time(s)   Vehicle Speed (m/s)  Yaw Rate (deg/s)\n" + _rows("  {t:.3f}   {v:.6f}  {deg:.6f}\n"),
    ),
    "units apart by spaces": (
        "drive.txt", "time [s] speed [m/s] yaw_rate [rad/s]\n" + _rows("{t:.3f} {v:.6f} {r:.6f}\n"),
    ),
    "blank cells between tabs, below a preamble": (
        "drive.lvm",
        "LabVIEW Measurement\t\nTime\t10:12:00\t10:12:00\t\nDelta_X\t0.05\t0.05\t\n***End_of_Header***\t\t\t\n"
        "X_Value\tvehicle_speed [m/s]\tyaw_rate\tComment\n" + _rows("{t:.3f}\t{v:.6f}\t{r:.6f}\t\n"),
    ),
    "comma at the end of lines": ("drive.csv", "time,speed [m/s],yaw_rate,\n" + _rows("{t:.3f},{v:.6f},{r:.6f},\n")),
    "units after a preposition": (
        "fahrt.txt",
        "Zeit\tspeed\tGierrate\nin s\tin m/s\tin °/s\n" + _rows("{t:.3f}\t{v:.6f}\t{deg:.6f}\n"),
    ),
    "JSON lines with vectors": (
        "drive.jsonl",
        "".join(
            json.dumps({"time": t, "speed [m/s]": v, "angular_velocity": [0, 0, r]}) + "\n"
            for t, v, r in _rows_of_numbers()
        ),
    ),
    "long table in German": (
        "fahrt.csv",
        "Zeit;Signal;Wert;Einheit\n"
        + "".join(_long(lambda t, name, x: f"{t:.3f};{name};{x:.6f};\n".replace(".", ","))),
    ),
    "long table with other columns below a comment": (
        "drive.csv",
        "#group,false\n_time,ecu,_field,_value,unit,quality,a\n"
        + "".join(_long(lambda t, name, x: f"{t:.3f},EPS,{name},{x:.6f},,0,\n")),
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", FILES)
def test_usual_exports_are_read(tmp_path, kind):
    name, text = FILES[kind]
    (tmp_path / name).write_text(text)
    found = read(tmp_path / name)
    speed = next(each for each in found.channels.values() if "speed" in each.name.lower() or "geschw" in each.name)
    yaw = found["yaw_rate"]
    assert len(yaw.time) == COUNT
    assert np.diff(yaw.time) == pytest.approx(STEP, abs=2e-3)
    assert yaw.values == pytest.approx(YAW, abs=1e-5)
    assert speed.values == pytest.approx(SPEED if speed.unit == "m/s" else 3.6 * SPEED, abs=1e-4)


def test_bytes_of_frames_in_json_are_lists_or_digits(tmp_path):
    (tmp_path / "car.dbc").write_text(
        'VERSION ""\n\nBS_:\n\nBU_: X\n\nBO_ 288 A: 8 X\n SG_ Angle : 0|16@1- (1,0) [0|0] "deg" X\n'
    )
    for data in (list, bytes.hex):
        frames = [
            {"timestamp": t, "arbitration_id": 288, "dlc": 8, "data": data(bytes([16, k % 100, *range(6)]))}
            for k, t in enumerate(TIME)
        ]
        (tmp_path / "can.json").write_text(json.dumps(frames))
        found = read(tmp_path / "can.json", dbc=tmp_path / "car.dbc")["A.Angle"]
        assert found.values == pytest.approx(16 + 256 * (np.arange(COUNT) % 100))


def test_can_frames_in_json_need_their_database(tmp_path):
    lines = [json.dumps({"timestamp": t, "id": 288, "bus": 0, "data": [1, 2, 3, 4, 5, 6, 7, 8]}) for t in TIME]
    (tmp_path / "can.jsonl").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"400 CAN frames of 1 identifiers \(0x120\); a DBC file"):
        read(tmp_path / "can.jsonl")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('{"a": [1, 2', "is no JSON that can be read to its end"),
        ('[{"a": 1}]', "no record with a time and a number"),
        ('{"time": 1}\n{"time": 2}\n', "no record with a time and a number"),
    ],
)
def test_json_without_a_recording_is_one_sentence(tmp_path, text, sentence):
    (tmp_path / "drive.json").write_text(text)
    with pytest.raises(InputError, match=sentence):
        read(tmp_path / "drive.json")


def test_broken_lines_are_counted(tmp_path):
    lines = [json.dumps(each) for each in _records()]
    lines[7] = lines[7][:20]
    (tmp_path / "drive.jsonl").write_text("\n".join(lines))
    assert "1 of 400 records have no time" in " ".join(read(tmp_path / "drive.jsonl").warnings)
