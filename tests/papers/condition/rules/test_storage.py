import math

import pytest

from tierod.core.errors import ParameterError
from tierod_lab.papers.condition.residuals import USUAL, judged
from tierod_lab.papers.condition.rules.calibration import ResidualCalibration
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, Coefficients
from tierod_lab.papers.condition.rules.readings import ResidualThreshold
from tierod_lab.papers.condition.rules.storage import read_calibration, shipped_calibration, text_of, widen

SAMPLE = ResidualCalibration(
    Coefficients(1.25, per_mass=0.5),
    {name: ResidualThreshold(0.25, per_speed=0.5, centre=-0.125) for name in RESIDUALS}
    | {"r19": ResidualThreshold(math.inf)},
    dict.fromkeys(RESIDUALS, 0.125),
    4000,
    adaptive=True,
)


def written(tmp_path, text):
    path = tmp_path / "own.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_calibration_comes_back_as_it_was_written(tmp_path):
    assert read_calibration(written(tmp_path, text_of(SAMPLE))) == SAMPLE


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("[thresholds.r7]", "[thresholds.r77]"), "no residual is called 'r77'"),
        (("samples = 4000", "sample = 4000"), "'sample' is not known here; did you mean 'samples'"),
        (("per_mass = 0.5", "per_mas = 0.5"), "did you mean 'per_mass'"),
        (("base = 0.25", 'base = "wide"'), "base"),
    ],
)
def test_a_slip_is_reported_with_its_line(tmp_path, change, words):
    path = written(tmp_path, text_of(SAMPLE).replace(*change, 1))
    with pytest.raises(ParameterError, match=words):
        read_calibration(path)


def test_a_missing_threshold_is_reported(tmp_path):
    text = text_of(SAMPLE)
    path = written(tmp_path, text[: text.index("[thresholds.drive_side]")])
    with pytest.raises(ParameterError, match="threshold of 'drive_side' is missing"):
        read_calibration(path)


def test_the_shipped_one_is_whole_and_widened_for_other_vehicles():
    found, wide = shipped_calibration(1.0), shipped_calibration()
    assert set(found.thresholds) == set(RESIDUALS)
    assert wide.thresholds["r7"].base == pytest.approx(1.5 * found.thresholds["r7"].base)
    assert widen(SAMPLE, 2.0).thresholds["r1"] == ResidualThreshold(0.5, per_speed=1.0, centre=-0.125)


def test_a_judged_residual_shows_its_threshold_in_sigmas_and_its_condition():
    each = judged("r4", SAMPLE)
    assert each.sigmas == pytest.approx((0.25 + 0.5 * USUAL.speed) / 0.125)
    assert each.condition == "above walking speed, below 6 m/s2 across"
    assert judged("r7a", SAMPLE).condition == "always"
    assert "median" in each.distance
    with pytest.raises(ParameterError, match="did you mean"):
        judged("r4b", SAMPLE)
