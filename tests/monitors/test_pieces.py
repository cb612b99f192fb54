"""Remarks on several pieces of a recording speak of the whole."""

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.monitors.pieces import QualityOverChunks


def remarks(*pieces: tuple[np.ndarray, np.ndarray]) -> list[str]:
    quality = QualityOverChunks(["vehicle_speed"])
    for time, values in pieces:
        quality.add(Recording({"vehicle_speed": Channel("vehicle_speed", time, values, "m/s")}))
    (row,) = quality.rows()
    return list(row.remarks)


def piece(start: float, top: float = 30.0) -> tuple[np.ndarray, np.ndarray]:
    time = start + np.arange(0.0, 60.0, 0.01)
    return time, 10.0 + (top - 10.0) * np.sin(0.1 * (time - start)) ** 2


def test_the_range_is_that_of_all_pieces_and_reported_once():
    assert remarks(piece(0.0)) == []
    (remark,) = remarks(piece(0.0, 100.0), piece(60.0), piece(120.0, 120.0))
    assert remark.startswith("36 km/h to 432 km/h leaves the plausible")


def test_the_longest_gap_is_reported_wherever_it_lies():
    assert remarks(piece(0.0), piece(90.0)) == ["the longest gap lasts 30 s"]
    time, values = piece(60.0)
    kept = (time < 69.995) | (time > 74.995)
    before, slow = piece(0.0)
    early = (before < 20.0) | (before > 20.5)
    found = remarks((before[early], slow[early]), (time[kept], values[kept]))
    assert found == ["the longest gap lasts 5.01 s"]


def test_missing_samples_are_counted_over_all_pieces():
    time, values = piece(60.0)
    half = np.where(np.arange(len(time)) % 2, values, np.nan)
    assert remarks(piece(0.0), (time, half)) == ["25 % of the samples are missing"]
    nothing = np.full_like(values, np.nan)
    assert remarks(piece(0.0), (time, nothing))[0] == "50 % of the samples are missing"
