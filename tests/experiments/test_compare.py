"""Two campaigns drive by drive."""

import json

import pytest

from experiments.campaign_rows import row
from tierod.core.errors import InputError
from tierod_lab.campaign.comparison import compare, document
from tierod_lab.campaign.figures import Moments
from tierod_lab.campaign.summary import write_table

STEP = {"fault": "step", "size": 4}


def folder(path, rows):
    path.mkdir()
    write_table(rows, path / "cells.parquet")
    return path


def campaign(path, seconds, bias, **more):
    faulty = [
        row(seed, **STEP, detection_s=seconds + seed, detection_enabled_s=seed, errors_fault_free=Moments(9, bias, 1.0),
            errors_faulty=Moments(9, bias, 1.0), **more)
        for seed in range(8)
    ]  # fmt: skip
    return folder(path, [row(1), *faulty])


def test_differences_are_judged_pair_by_pair(tmp_path):
    first, second = campaign(tmp_path / "a", 10.0, 0.1), campaign(tmp_path / "b", 7.0, -0.3)
    (found,) = compare(first, second)
    assert (len(found.pairs), found.alone) == (9, (0, 0))
    content = document([found], (first, second))
    monitor = json.loads(json.dumps(content, allow_nan=False))["monitors"][0]
    figures = {figure["name"]: figure for figure in monitor["figures"]}
    assert figures["detection_s"]["pairs"] == 8
    assert figures["detection_s"]["mean"] == pytest.approx(-3.0)
    assert figures["detection_s"]["sign_p"] == pytest.approx(2.0 / 2**8)
    assert figures["detection_s"]["unit"] == "s"
    assert figures["bias"]["median"] == pytest.approx(-0.4)
    assert figures["absolute_bias"]["median"] == pytest.approx(0.2)
    assert figures["bias"]["unit"] == "N*m"
    assert figures["detection_enabled_s"]["mean"] == 0.0
    assert figures["detection_enabled_s"]["sign_p"] is None
    assert monitor["changed"] == []


def test_changed_verdicts_are_reported_and_counted(tmp_path):
    first = folder(tmp_path / "a", [row(1), row(2, **STEP, detection_s=3.0), row(3, **STEP, verdict="missed"), row(9)])
    second = folder(
        tmp_path / "b",
        [row(1, verdict="false alarm"), row(2, outcome="diverged", **STEP), row(3, **STEP, detection_s=4.0), row(4)],
    )
    (found,) = compare(first, second)
    monitor = document([found], (first, second))["monitors"][0]
    assert (monitor["pairs"], monitor["only_first"], monitor["only_second"]) == (3, 1, 1)
    assert [(each["first"][1], each["second"][1]) for each in monitor["changed"]] == [
        ("quiet", "false alarm"), ("found", "diverged"), ("missed", "found"),
    ]  # fmt: skip
    assert {key: monitor["right"][key] for key in ("first", "second", "only_first", "only_second")} == {
        "first": 2, "second": 1, "only_first": 2, "only_second": 1,
    }  # fmt: skip
    detection = next(figure for figure in monitor["figures"] if figure["name"] == "detection_s")
    assert (detection["pairs"], detection["first_only"], detection["second_only"]) == (0, 0, 1)


def test_campaigns_that_have_nothing_in_common_are_refused(tmp_path):
    first = folder(tmp_path / "a", [row(1), row(1, monitor="other")])
    with pytest.raises(InputError, match="no drive in common"):
        compare(first, folder(tmp_path / "b", [row(2), row(2, monitor="other")]))
    with pytest.raises(InputError, match="no monitor in common"):
        compare(first, folder(tmp_path / "c", [row(1, monitor="third")]))
    with pytest.raises(InputError, match="is not there"):
        compare(first, tmp_path / "d")
