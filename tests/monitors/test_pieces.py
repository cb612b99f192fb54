"""Remarks on several pieces of a recording speak of the whole."""

import itertools

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.monitors.pieces import LONGEST, QualityOverChunks, Silence


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


STEP = 0.01


def judged(signals, cuts=()):
    """Seconds of a recording that are judged, as (from, until), joined where they touch."""
    silence, parts, at = Silence(), [], min(each[0] for each in signals)
    edges = [-np.inf, *cuts, np.inf]
    for low, high in itertools.pairwise(edges):
        piece = [each[(each >= low) & (each < high)] for each in signals]
        held = [each for each in piece if len(each)]
        if not held:
            continue
        begin, last = min(each[0] for each in held), max(each[-1] for each in held)
        for skip_to, stop in silence.stretches(piece, begin, last + 0.5 * STEP):
            at = max(at, skip_to)
            if stop > at:
                parts.append((at, stop))
                at = stop
    joined = [parts[0]]
    for begin, stop in parts[1:]:
        if begin == joined[-1][1]:
            joined[-1] = (joined[-1][0], stop)
        else:
            joined.append((begin, stop))
    return joined


def drive(begin, seconds):
    return begin + STEP * np.arange(round(seconds / STEP))


def test_of_a_long_pause_so_much_is_judged_as_verdicts_need():
    time = np.concatenate([drive(0.0, 30.0), drive(7200.0, 30.0)])
    assert judged([time]) == [(0.0, pytest.approx(29.99 + LONGEST)), (7200.0, pytest.approx(7230.0, abs=STEP))]


@pytest.mark.parametrize("seed", range(20))
def test_the_result_does_not_depend_on_how_the_recording_is_cut(seed):
    random = np.random.default_rng(seed)
    begins = np.cumsum(random.choice([40.0, 300.0, 700.0, 4000.0], 30))
    signals = [np.concatenate([drive(begin, random.uniform(1.0, 30.0)) for begin in begins]) for _ in range(2)]
    span = max(each[-1] for each in signals)
    whole = judged(signals)
    assert judged(signals, np.sort(random.uniform(0.0, span, 12))) == whole
    assert judged(signals, np.arange(600.0, span, 600.0)) == whole


def test_a_clock_that_was_set_is_refused():
    with pytest.raises(InputError, match="jumps ahead from about 29.99 s by 11.6 days"):
        judged([np.concatenate([drive(0.0, 30.0), drive(1e6, 30.0)])])
