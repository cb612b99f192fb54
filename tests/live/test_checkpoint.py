"""A drive that goes on from a checkpoint: statements, states and clock as if the program had not ended."""

import dataclasses
import json
import time

import numpy as np
import pytest

from live_drives import CAR, START, driven, frames_of_drive, simulated_frames, started
from tierod.core.errors import InputError
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.live import checkpoint
from tierod.live.drive import Outputs
from tierod.vehicles import load

pytest.importorskip("cantools")
pytest.importorskip("asammdf")


def outputs(folder, log=False, **more):
    return Outputs(folder / "log.mf4" if log else None, None, folder / "car.state", every=2.5, **more)


def cut_off(folder, frames, until, monitors=("friction",), log=False, memory=None, car=None):
    """A drive whose program ends at a moment; its checkpoint is written."""
    drive, inbox, _ = started(folder, outputs(folder, log), memory, car, monitors)
    driven(drive, inbox, [each for each in frames if each.time < START + until])
    assert drive._checkpoints._writing.result(30.0) is None
    return drive


def gone_on(folder, frames, since, monitors=("friction",), log=False, memory=None, car=None):
    drive, inbox, events = started(folder, outputs(folder, log), memory, car, monitors)
    driven(drive, inbox, [each for each in frames if each.time >= START + since])
    return drive, events


def texts(events, kind="checkpoint"):
    return [each["text"] for each in events if each["event"] == kind]


def same_traces(first, second):
    for name, trace in first.traces.items():
        other = second.traces[name]
        np.testing.assert_array_equal(trace.mean, other.mean, err_msg=name)
        np.testing.assert_array_equal(trace.lower, other.lower, err_msg=name)


def agree(whole, second):
    for (judge, mine, _), (_, other, _) in zip(whole.engine.finish(), second.engine.finish(), strict=True):
        one, two = mine.findings[0], other.findings[0]
        assert (one.status, one.since, one.headline) == (two.status, two.since, two.headline), judge.name
        assert one.evidence.keys() == two.evidence.keys()
        for name, value in one.evidence.items():
            assert two.evidence[name] == pytest.approx(value, rel=1e-9, nan_ok=True), name
        assert [each.samples for each in mine.quality] == [each.samples for each in other.quality]
        same_traces(mine, other)


def test_with_the_log_nothing_is_lost_and_every_figure_goes_on(tmp_path):
    """What came between the checkpoint and the end of the program is judged from the log."""
    frames = frames_of_drive(tmp_path, 20.0)
    monitors = ["friction", "sideslip"]
    whole, inbox, _ = started(tmp_path, Outputs(), None, None, monitors)
    driven(whole, inbox, frames)
    first = cut_off(tmp_path, frames, 13.0, monitors, log=True)
    stuck = first.engine.judges[0].run.session.course[0]
    second, events = gone_on(tmp_path, frames, 13.0, monitors, log=True)
    assert sum("goes on from the checkpoint" in text for text in texts(events)) == 3
    assert any("frames that were logged since" in text for text in texts(events))
    assert any("it continues in" in text for text in texts(events, "problem"))
    assert second.engine.judges[0].run.session.course[0] == stuck
    agree(whole, second)
    assert second.engine.tally.frames == len(frames)


def test_without_the_log_what_was_judged_goes_on(tmp_path):
    frames = frames_of_drive(tmp_path, 16.0)
    first = cut_off(tmp_path, frames, 10.0)
    kept = checkpoint.read(tmp_path / "car.state")
    second, _ = gone_on(tmp_path, frames, 10.0)
    assert second.engine.clock.origin == first.engine.clock.origin
    assert second.engine.clock.jumps == 0
    run = second.engine.judges[0].run
    assert run.start == first.engine.judges[0].run.start
    assert run.session.memory.count > kept.states["friction"].memory.count > 300
    assert second.state()["time"] == pytest.approx(16.0, abs=0.5)


def test_a_monitor_that_measured_its_first_minute_goes_on_with_that_noise(tmp_path):
    frames = frames_of_drive(tmp_path, 68.0)
    first = cut_off(tmp_path, frames, 65.0, ["driver-torque"])
    second, events = gone_on(tmp_path, frames, 65.0, ["driver-torque"])
    assert texts(events)[0] == "goes on from the checkpoint"
    own, other = (each.engine.judges[0].run.session for each in (first, second))
    assert own.fitted == other.fitted is not None
    assert own.block == other.block
    assert other._figures.seen > own._figures.seen > 0


def test_the_condition_of_a_demonstrator_goes_on(tmp_path):
    car = load("smartload")
    frames = frames_of_drive(tmp_path, 12.0)
    whole, inbox, _ = started(tmp_path, Outputs(), None, car, ["condition"])
    driven(whole, inbox, frames)
    cut_off(tmp_path, frames, 8.0, ["condition"], True, None, car)
    second, _ = gone_on(tmp_path, frames, 8.0, ["condition"], True, None, car)
    agree(whole, second)


def test_a_cycle_of_the_fault_memory_goes_on_and_is_counted_once(tmp_path):
    frames = frames_of_drive(tmp_path, 14.0)
    memory = tmp_path / "car.json"
    cut_off(tmp_path, frames, 8.0, memory=memory)
    second, events = gone_on(tmp_path, frames, 8.0, memory=memory)
    kept = (tmp_path / "car.state").read_bytes()
    second.close()
    assert FaultMemory.opened(memory, CAR.name).cycles == 1
    # Killed once more between memory and checkpoint: the same drive is not taken in again.
    (tmp_path / "car.state").write_bytes(kept)
    third, events = gone_on(tmp_path, frames, 14.0, memory=memory)
    third._begin(frames[-1], time.monotonic(), time.time())
    third.close()
    assert FaultMemory.opened(memory, CAR.name).cycles == 1
    assert any("counts none twice" in text for text in texts(events, "problem"))


def test_after_the_end_of_a_drive_only_the_blocks_go_on(tmp_path):
    frames = frames_of_drive(tmp_path, 8.0)
    first = cut_off(tmp_path, frames, 8.0)
    first.close()
    assert checkpoint.read(tmp_path / "car.state").ended
    known = checkpoint.read(tmp_path / "car.state").states["friction"].memory.count
    second, events = gone_on(tmp_path, [each._replace(time=each.time + 60.0) for each in frames], 0.0)
    assert texts(events) == ["its block goes on from the state at the end of the drive before"]
    assert second.engine.judges[0].run.session.memory.count > known
    assert second.engine.tally.frames == len(frames)


def refusal(folder, car=CAR):
    drive, _, events = started(folder, outputs(folder), None, car)
    drive.prepare()
    (text,) = texts(events)
    return text


def test_checkpoints_of_others_are_refused_with_the_reason(tmp_path, monkeypatch):
    cut_off(tmp_path, frames_of_drive(tmp_path, 6.0), 6.0)
    path = tmp_path / "car.state"
    other = dataclasses.replace(CAR, name="compact")
    assert "it is of the vehicle 'midsize-eps', and this is 'compact'; the monitors begin anew" in refusal(
        tmp_path, other
    )
    heavier = dict(CAR.parameters)
    heavier["mass"] = dataclasses.replace(heavier["mass"], value=1.01 * heavier["mass"].value)
    assert "the parameters of the vehicle 'midsize-eps' have changed since" in refusal(
        tmp_path, dataclasses.replace(CAR, parameters=heavier)
    )
    found = checkpoint.read(path)
    checkpoint.written(dataclasses.replace(found, written=found.written - 400.0, ended=True, drive=None), path)
    assert "s old, and 300 s are the limit" in refusal(tmp_path)
    checkpoint.written(dataclasses.replace(found, databases="other"), path)
    assert "the CAN databases or the channel map have changed since" in refusal(tmp_path)
    checkpoint.written(found, path)
    monkeypatch.setattr(checkpoint, "__version__", "0.0.1")
    assert "it is of another version of tierod than 0.0.1" in refusal(tmp_path)


def test_a_drive_that_was_cut_off_long_ago_is_concluded(tmp_path):
    """Fault memory and page come from checkpoint and log, once; what begins then is a new drive."""
    memory, path = tmp_path / "car.json", tmp_path / "car.state"
    frames = frames_of_drive(tmp_path, 12.0)
    whole, _, _ = started(tmp_path, Outputs())
    driven(whole, whole.inbox, [each for each in frames if each.time < START + 10.0])
    expected = whole.engine.finish()[0][1].findings[0]
    cut_off(tmp_path, frames, 10.0, log=True, memory=memory)
    found = checkpoint.read(path)
    checkpoint.written(dataclasses.replace(found, written=found.written - 4000.0), path)
    for first in (True, False):
        drive, inbox, events = started(tmp_path, outputs(tmp_path, True), memory)
        drive.prepare()
        kinds = [each["event"] for each in events]
        if first:
            sentence = "is too old to continue: it is concluded from its checkpoint"
            assert any(sentence in each for each in texts(events)), texts(events)
            assert next(each for each in events if each["event"] == "end")["headlines"] == {
                "friction": expected.headline
            }
            assert "memory" in kinds
        else:
            assert "end" not in kinds
        assert FaultMemory.opened(memory).cycles == 1
    driven(drive, inbox, [each._replace(time=each.time + 5000.0) for each in frames])
    problems = texts(events, "problem")
    assert any("log.mf4 exists already; this drive is written to" in each for each in problems)
    assert drive.engine.tally.frames == len(frames)
    drive.close()
    assert FaultMemory.opened(memory).cycles == 2


def test_damaged_checkpoints_are_refused(tmp_path):
    cut_off(tmp_path, frames_of_drive(tmp_path, 6.0), 6.0)
    path = tmp_path / "car.state"
    whole = path.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    for damaged in (whole[: len(whole) // 2], whole[:40], b"", b"{}", bytes(flipped), whole + b"\0"):
        path.write_bytes(damaged)
        with pytest.raises(InputError, match="is not used: it is damaged"):
            checkpoint.read(path)
    path.write_text(json.dumps({"layout": 1, "version": "1.0"}))
    with pytest.raises(InputError, match=r"another version|damaged"):
        checkpoint.read(path)


def test_a_checkpoint_cannot_make_other_classes_than_those_of_the_sessions(tmp_path):
    from tierod.live.restoring import Unfit, restored
    from tierod.live.snapshot import Snapshot

    for name in ("subprocess:Popen", "tierod.live.log:os.system", "tempfile:_TemporaryFileCloser", "builtins:eval"):
        with pytest.raises(Unfit, match="there is no class"):
            restored(Snapshot(["o", 0, name, []], []), None, frozenset({"tierod"}), {})
    for node in (["x", 1], ["r", 5], ["a", 0, 7], [3], ["o", 0, "tierod.live.frame:Frame", [["time"]]]):
        with pytest.raises(Unfit):
            restored(Snapshot(node, []), None, frozenset({"tierod"}), {})


def test_a_checkpoint_is_at_most_five_seconds_old(tmp_path):
    drive, inbox, _ = started(tmp_path, dataclasses.replace(outputs(tmp_path), every=5.0))
    frames = frames_of_drive(tmp_path, 24.0)
    ages = []
    for begin in range(0, len(frames), 40):
        driven(drive, inbox, frames[begin : begin + 40])
        if drive._checkpoints._writing is not None:
            drive._checkpoints._writing.result(30.0)
            ages.append(frames[begin].time - START - 0.25 - drive._checkpoints.judged_until)
    assert len(ages) > 100
    assert max(ages) < 5.0


@pytest.mark.slow
@pytest.mark.parametrize("log", [True, False])
def test_half_a_minute_after_a_checkpoint_the_estimate_is_that_of_an_undisturbed_drive(tmp_path, log):
    """The program is gone for two seconds; without a log what came since the checkpoint is lost, too."""
    frames = simulated_frames(tmp_path, "mixed-drive-healthy", 154.0, seed=11)
    whole, inbox, _ = started(tmp_path, Outputs())
    driven(whole, inbox, frames)
    cut_off(tmp_path, frames, 120.0, log=log)
    second, _ = gone_on(tmp_path, frames, 122.0, log=log)
    mine, other = (each.engine.judges[0].ticker.values()["friction_torque"] for each in (second, whole))
    print(f"log {log}: {mine:.5f} against {other:.5f} N*m: {100 * abs(mine / other - 1):.3f} %")
    assert mine == pytest.approx(other, rel=0.01)
