"""A car is never green over a drive that is not healthy: terminal, JSON, report page and web page say the same."""

import datetime as dt
import json
import re

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tierod.cli import main
from tierod.fleet.schema import findings, ledger
from tierod.web.fleets import Fleets, drives_of, key_of, work_out

MONDAY = dt.datetime(2026, 6, 1, 8, tzinfo=dt.UTC)
DAYS = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")


def driven(statuses, vehicle="car-1", judged="", monitor="friction", apart=1.0, deviation=0.1, **more):
    """One row per drive, a day apart from Monday on; of pairs the second is the friction [N*m]."""
    for number, each in enumerate(statuses):
        status, value = each if isinstance(each, tuple) else (each, None)
        name = DAYS[number] if number < len(DAYS) else number
        row = {"vehicle": vehicle, "recording_name": f"/drives/{vehicle}/{name}.parquet", "span": 0,
               "start": MONDAY + dt.timedelta(days=apart * number), "monitor": monitor, "judged": judged,
               "role": "sensor" if judged else "", "status": status, "word": status}  # fmt: skip
        if value is not None:
            row |= {"quantity": "friction torque", "unit": "N*m", "estimate": value, "deviation": deviation,
                    "nominal": 2.6, "limit": 7.5}  # fmt: skip
        yield row | more


@pytest.fixture
def reported(tmp_path, capsys):
    """The exit code, the terminal, the JSON document, the page, and the table of the web page of some findings."""

    def reported(*rows):
        folder = tmp_path / "results"
        for name, table in (("findings", findings()), ("ledger", ledger())):
            (folder / name).mkdir(parents=True)
            content = pa.Table.from_pylist(list(rows) if name == "findings" else [], schema=table)
            pq.write_table(content, folder / name / "a.parquet")
        code = main(["fleet", "report", str(folder)])
        terminal = " ".join(capsys.readouterr().out.split())
        document = json.loads((folder / "fleet.json").read_text())
        work_out(folder, tmp_path, key_of(folder))
        web = Fleets(tmp_path).loaded(key_of(folder))
        page = (folder / "fleet.html").read_text()
        assert document["title"] in terminal
        assert document["title"] in page
        assert web["title"] == document["title"]
        return code, terminal, document, page, web["rows"]

    return reported


def test_one_fault_and_one_suspect_drive_are_to_be_confirmed(reported):
    drives = [("healthy", 2.6), ("healthy", 2.6), ("fault", 6.3), ("suspect", 6.1)]
    code, terminal, document, page, (row,) = reported(*driven(drives))
    state = "to confirm: 1 fault, 1 suspect"
    assert (code, document["status"], document["symbol"], document["colour"]) == (1, state, "▲", "watch")
    assert document["title"] == "1 of 1 car to look at: 1 to confirm (1 fault, 1 suspect)"
    assert state in page
    (car,) = document["cars"]
    assert (car["state"], car["summary"]) == ("to confirm", state)
    shown = "(Wed.parquet, 2026-06-03: fault; Thu.parquet, 2026-06-04: suspect)"
    assert shown in car["reasons"][0]["text"]
    assert shown in terminal
    assert [each["status"] for each in car["reasons"][0]["drives"]] == ["suspect", "fault"]
    assert (row["state"], row["summary"]) == ("to confirm", state)
    assert "needs a look" not in page + terminal
    assert "✓" not in terminal
    said = re.search(r"([\d.]+) ± ([\d.]+) N·m", terminal)
    level = document["quantities"][0]["levels"]["car-1"]
    assert (float(said[1]), float(said[2])) == pytest.approx(level, abs=0.01), "± is one standard deviation"


@pytest.mark.parametrize(
    ("statuses", "state"),
    [
        (["healthy", "healthy", "fault"], "to confirm: 1 fault"),
        (["fault", "healthy", "healthy"], "to confirm: 1 fault"),
        (["healthy", "rising", "suspect"], "to confirm: 1 rising, 1 suspect"),
        (["suspect"], "to confirm: 1 suspect"),
        (["rising", "rising", "rising"], "to confirm: 3 rising"),
        (["fault", "not enabled", "not identifiable", "healthy", "not available"], "to confirm: 1 fault"),
        (["healthy", "fault", "fault"], "fault"),
        (["fault", "not ready", "fault", "suspect"], "fault"),
        (["fault"], "fault"),
        (["fault", "suspect", "healthy", "healthy", "healthy"], None),
        (["not enabled", "healthy"], None),
    ],
)
def test_the_last_three_judged_drives_decide(reported, statuses, state):
    code, _, document, *_ = reported(*driven(statuses))
    assert [car["summary"] for car in document["cars"]] == [state] * (state is not None)
    assert code == (state is not None)


def test_a_repaired_car_is_green_and_its_history_is_kept(reported, tmp_path):
    _, terminal, document, page, (row,) = reported(
        *driven(["healthy", "fault", "fault", "healthy", "healthy", "healthy"])
    )
    history = "healthy in the last 3 judged drives; before that 2 faults, the last in Wed.parquet, 2026-06-03: fault"
    assert document["title"] == "No car of 1 needs a look"
    (before,) = document["recovered"]
    assert [each["status"] for each in before["drives"]] == ["fault", "fault"]
    assert all(history in each for each in (terminal, page, row["why"], before["text"]))
    assert len(drives_of(tmp_path / "results", "car-1")) == 6


def test_estimates_alone_make_no_car_green(reported):
    estimates = ["inconsistent", "estimated", "estimated", "estimated"]
    _, _, document, _, (row,) = reported(*driven(estimates, monitor="sideslip"))
    assert (document["status"], document["symbol"]) == ("estimated", "≈")
    assert row["why"].startswith("monitor sideslip: estimated in the last 3 judged drives; before that 1 inconsistent")


def test_each_monitor_and_each_element_is_judged_by_its_own_drives(reported):
    sound = ["healthy"] * 4
    rows = [
        *driven(["healthy", "fault", "not enabled", "not enabled"]),
        *driven(sound, judged="yaw_rate", monitor="condition"),
        *driven(["healthy", "healthy", "suspect", "fault"], judged="driver_torque", monitor="condition"),
        *driven(["healthy", "fault", "fault", "fault"], "car-2", "motor_torque", "condition", kind="offset"),
        *driven(sound, "car-3"),
    ]
    _, _, document, _, web = reported(*rows)
    first, second = document["cars"]
    assert (first["vehicle"], first["summary"]) == ("car-2", "fault")
    assert first["reasons"][0]["text"] == "motor_torque: fault (offset) in 3 of the last 3 judged drives"
    # Tuesday and Thursday were faulty, Wednesday suspect.
    assert (second["vehicle"], second["summary"]) == ("car-1", "to confirm: 2 faults, 1 suspect")
    assert {each["text"].partition(":")[0] for each in second["reasons"]} == {"driver_torque", "monitor friction"}
    assert document["title"] == "2 of 3 cars to look at: 1 fault, 1 to confirm (2 faults, 1 suspect)"
    assert [row["state"] for row in web] == ["fault", "to confirm", ""]


def test_a_drive_of_several_episodes_or_spans_counts_once(reported):
    (row,) = driven(["fault"])
    (last,) = (each for each in driven(["healthy", "healthy"]) if "Tue" in each["recording_name"])
    later = row | {"status": "healthy", "span": 1, "start": MONDAY + dt.timedelta(hours=1)}
    _, _, document, *_ = reported(row, row | {"kind": "offset"}, later, last)
    assert document["cars"][0]["summary"] == "to confirm: 1 fault"


def test_drives_whose_order_is_unknown_hide_no_fault(reported):
    same = list(driven(["fault", *["healthy"] * 4], apart=0.0))
    undated = [row | {"vehicle": "car-2"} for row in driven(["healthy", "fault", *["healthy"] * 4])]
    undated[1]["start"] = None
    _, _, document, *_ = reported(*same, *undated)
    assert {car["vehicle"]: car["summary"] for car in document["cars"]} == {
        "car-1": "to confirm: 1 fault",
        "car-2": "to confirm: 1 fault",
    }


def test_a_car_without_a_verdict_is_not_green(reported):
    _, terminal, document, page, web = reported(*driven(["not enabled"]), *driven(["healthy"], "car-2"))
    assert document["status"] == "no verdict on 1 of 2 cars"
    assert terminal.startswith("? NO VERDICT ON 1 OF 2 CARS No car of the 1 with a verdict needs a look; 1 gave none")
    assert "✓" not in page.partition("<main")[2].partition("</h1>")[0]
    assert [row["summary"] for row in web] == ["no verdict", ""]


LOW, HIGH = ("healthy", 2.6), ("fault", 6.2)


@pytest.mark.parametrize("deviation", [0.02, 0.1, 0.3])
@pytest.mark.parametrize(
    ("drives", "level", "since", "before"),
    [
        ([LOW, LOW, ("fault", 6.3), ("suspect", 6.1)], 6.2, "2026-06-03", 2.6),
        ([LOW] * 5 + [HIGH] * 3, 6.2, "2026-06-06", 2.6),
        ([LOW, HIGH, HIGH, *[LOW] * 3], 2.6, "2026-06-04", 6.2),
        ([HIGH, HIGH, LOW, LOW], 2.6, "2026-06-03", 6.2),
        ([HIGH, LOW, LOW, LOW], 2.6, "2026-06-02", 6.2),
        ([LOW] * 3 + [("healthy", 4.6)] * 3 + [("fault", 8.0)] * 3, 8.0, "2026-06-07", 4.6),
    ],
)
def test_a_level_is_that_after_its_last_step(reported, drives, level, since, before, deviation):
    _, terminal, document, page, (row,) = reported(*driven(drives, deviation=deviation))
    (quantity,) = document["quantities"]
    assert quantity["levels"]["car-1"][0] == pytest.approx(level, abs=0.12)
    step = quantity["steps"]["car-1"]
    assert (step["since"], step["before"]) == (since, pytest.approx(before, abs=0.12))
    assert row["step"] == step
    if document["cars"]:
        assert document["cars"][0]["reasons"][0]["trend"]["step"] == step
        said = re.search(r"level ([\d.]+) N·m since ([-\d]+), ([\d.]+) N·m before", terminal)
        assert said[0] in page
        assert said[2] == since
        assert (float(said[1]), float(said[3])) == pytest.approx((level, before), abs=0.12)


@pytest.mark.parametrize(
    "values",
    [
        [2.6 + 0.05 * number for number in range(30)],
        [2.6] * 15 + [2.6 + 0.1 * number for number in range(15)],
        [2.6] * 10 + [6.3] + [2.6] * 10,
        [2.6 + 0.05 * (number % 3) for number in range(20)] + [6.3],
    ],
)
def test_a_slow_ramp_and_a_single_drive_are_no_step(reported, values):
    _, _, document, *_ = reported(*driven([("healthy", value) for value in values], apart=3.0))
    (quantity,) = document["quantities"]
    assert quantity["steps"] == {}
    usual = values[-1] if values[-1] < 6.0 else 2.65
    assert quantity["levels"]["car-1"][0] == pytest.approx(usual, abs=0.15)


def test_a_change_that_was_repaired_is_over(reported):
    drives = [LOW] * 12 + [HIGH] * 6
    _, _, document, *_ = reported(*driven(drives, apart=3.0), *driven([*drives, *[LOW] * 4], "car-2", apart=3.0))
    (car,) = document["cars"]
    assert (car["vehicle"], car["summary"]) == ("car-1", "fault")
    (reason,) = car["reasons"]
    assert "level 6.2 N·m since" in reason["text"]
    assert reason["trend"]["change"]["size"][0] == pytest.approx(3.6, abs=0.05)
    assert [each["vehicle"] for each in document["recovered"]] == ["car-2"]


def test_the_level_holds_the_gain_of_the_sensors_which_no_number_of_drives_averages_out(reported):
    drives = [("healthy", 4.0 + 0.02 * (number % 3)) for number in range(9)] + [("fault", 4.02)]
    rows = [*driven(drives, deviation=0.1), *driven(drives, vehicle="car-2", deviation=0.33, shared_deviation=0.31)]
    _, _, document, page, _ = reported(*rows)
    (quantity,) = document["quantities"]
    (_, exact), (_, gained) = (quantity["levels"][name] for name in ("car-1", "car-2"))
    assert exact < 0.1
    assert 0.31 < gained < 0.35
    assert "(sensor gains included)" in page


BEFORE = [("healthy", 3.95)] * 5


@pytest.mark.parametrize(("value", "after", "says"), [
    (7.68, 2, "limit reached"), (7.68, 8, "limit reached"), (7.68, 1, "too few drives"), (7.0, 2, "too few drives"),
    (7.0, 8, "more than 10 years"),
])  # fmt: skip
def test_no_time_is_left_at_the_limit_and_none_is_computed_across_a_step(reported, value, after, says):
    drives = [*BEFORE, *[("rising", value)] * after]
    _, terminal, document, page, _ = reported(*driven(drives, deviation=0.5, shared_deviation=0.45))
    assert says in terminal
    assert says in page
    left = document["cars"][0]["reasons"][0]["trend"]["days_to_limit"]
    assert left[1] == (0.0 if says == "limit reached" else None)
    assert (left == [None] * 3) is (says == "too few drives")


@pytest.mark.parametrize("first", [3, 6])
def test_a_level_that_fell_far_is_to_be_confirmed_but_no_repair_is(reported, first):
    fell = [("healthy", 3.95 - 0.01 * n) for n in range(first)] + [("healthy", 2.76), ("healthy", 2.77)]
    steady = [("healthy", 3.95 - 0.01 * (n % 2)) for n in range(first + 2)]
    more = {"nominal": 4.0, "deviation": 0.3, "shared_deviation": 0.28}
    rows = [
        *driven(fell, **more),
        *driven(steady, "car-2", **more),
        *driven([HIGH, HIGH, *[("healthy", 3.9)] * 3], "car-3", **more),
    ]
    code, terminal, document, page, _ = reported(*rows)
    assert (code, document["title"]) == (1, "1 of 3 cars to look at: 1 to confirm")
    assert "fell from 3.9" in terminal
    assert "fell from 3.9" in page
    (car,) = document["cars"]
    assert (car["vehicle"], car["summary"]) == ("car-1", "to confirm")
    assert "gains" in car["reasons"][0]["inspect"]
