import numpy as np
import pytest

from diagnosis.memories import code, drive, table
from tierod.core.errors import InputError, ParameterError
from tierod.diagnosis.entry import CLEARED, CodeStatus
from tierod.diagnosis.fault_memory import CAUSE_DELAY, FaultMemory

FAILED_NOW = CodeStatus.TEST_FAILED | CodeStatus.FAILED_THIS_CYCLE | CodeStatus.PENDING | CodeStatus.FAILED_SINCE_CLEAR


def status(memory, name="a"):
    return memory.entries[name].status


def test_before_the_first_drive_nothing_is_known():
    memory = FaultMemory(table(a=code(1)))
    assert status(memory) == CLEARED == 0x50
    assert not memory.lamp
    assert memory.reaction == "none"


def test_the_status_byte_bit_by_bit():
    """Bits as ISO 14229-1, annex D.2 draws them: test failed 01, this cycle 02, pending 04, confirmed 08, not completed
    since clear 10, failed since clear 20, not completed this cycle 40, warning lamp 80."""
    memory = FaultMemory(table(a=code(1, confirmation_cycles=2, healing_cycles=1, aging_cycles=1, lamp=True)))
    statuses = []

    def cycle(*results):
        memory.begin_cycle()
        statuses.append(int(status(memory)))
        for instant, result in enumerate(results):
            memory.absorb([float(instant)], {"a": [result]})
            statuses.append(int(status(memory)))
        memory.end_cycle()
        statuses.append(int(status(memory)))

    cycle(-1.0, 1.0, -1.0)
    assert statuses == [0x50, 0x00, 0x27, 0x26, 0x26]
    cycle()
    assert statuses[5:] == [0x64, 0x64]
    cycle(1.0, -1.0, 1.0)
    assert statuses[7:] == [0x64, 0xAF, 0xAE, 0xAF, 0xAF]
    cycle(-1.0)  # passes: neither pending nor, after one such cycle, a reason for the lamp
    assert statuses[12:] == [0xED, 0xAC, 0x28]
    cycle(-1.0)  # ages: only "failed since clear" stays
    assert statuses[15:] == [0x68, 0x28, 0x20]


def test_a_failure_is_pending_at_once_and_confirmed_in_the_second_cycle():
    memory = FaultMemory(table(a=code(1, confirmation_cycles=2, lamp=True, reaction="degrade")))
    assert drive(memory, {"a": (-1.0, 5.0, 1.0)}) == ((0.0, "a", "passed"), (5.0, "a", "failed"))
    assert status(memory) == FAILED_NOW
    assert not memory.lamp
    drive(memory, {"a": (0.0, 3.0, 1.0)})
    assert status(memory) == FAILED_NOW | CodeStatus.CONFIRMED | CodeStatus.WARNING_REQUESTED
    assert memory.lamp
    assert memory.reaction == "degrade"
    assert memory.entries["a"].occurrences == 1  # it never passed in between


def test_pending_falls_with_a_cycle_that_passes_but_not_with_one_that_tests_nothing():
    memory = FaultMemory(table(a=code(1, confirmation_cycles=2)))
    drive(memory, {"a": 1.0})
    drive(memory, {"a": 0.0})
    assert status(memory) & CodeStatus.PENDING
    assert status(memory) & CodeStatus.NOT_COMPLETED_THIS_CYCLE
    drive(memory, {"a": -1.0})
    assert status(memory) == CodeStatus.FAILED_SINCE_CLEAR
    drive(memory, {"a": 1.0})
    assert not status(memory) & CodeStatus.CONFIRMED  # the passed cycle has begun the count anew


def test_a_confirmed_code_heals_and_then_ages():
    memory = FaultMemory(table(a=code(1, lamp=True, healing_cycles=3, aging_cycles=4)))
    drive(memory, {"a": 1.0})
    assert memory.lamp
    for _ in range(2):
        drive(memory, {"a": -1.0})
    assert memory.lamp
    drive(memory, {"a": 0.0})
    assert memory.lamp  # nothing was tested: no step towards healing
    drive(memory, {"a": -1.0})
    assert not memory.lamp
    assert memory.reaction == "none"
    for _ in range(3):
        drive(memory, {"a": -1.0})
    assert status(memory) & CodeStatus.CONFIRMED
    drive(memory, {"a": -1.0})
    assert not memory.entries["a"].stored
    assert memory.entries["a"].first is None


def test_a_relapse_begins_healing_anew():
    memory = FaultMemory(table(a=code(1, lamp=True, healing_cycles=2)))
    drive(memory, {"a": 1.0})
    drive(memory, {"a": -1.0})
    drive(memory, {"a": (-1.0, 5.0, 1.0)})
    drive(memory, {"a": -1.0})
    assert memory.lamp
    assert memory.entries["a"].occurrences == 2


def test_a_consequence_is_not_raised_while_its_cause_has_failed():
    memory = FaultMemory(table(a=code(1), b=code(2, consequence_of=("a",)), c=code(3, consequence_of=("b",))))
    drive(memory, {"a": (-1.0, 3.0, 1.0), "b": (-1.0, 4.0, 1.0), "c": (-1.0, 5.0, 1.0)})
    assert [name for name, entry in memory.entries.items() if entry.stored] == ["a"]


@pytest.mark.parametrize(("delay", "raised"), [(CAUSE_DELAY - 0.1, ["a"]), (CAUSE_DELAY + 0.5, ["a", "b"])])
def test_a_cause_that_is_found_a_little_later_takes_the_place_of_its_consequence(delay, raised):
    memory = FaultMemory(table(a=code(1), b=code(2, consequence_of=("a",), lamp=True)))
    drive(memory, {"a": (-1.0, 4.0 + delay, 1.0), "b": (-1.0, 4.0, 1.0)})
    assert [name for name, entry in memory.entries.items() if entry.stored] == raised
    if raised == ["a"]:
        assert memory.entries["b"].consequence_of == "a"
        assert not memory.lamp


def test_freeze_frames_hold_the_signals_around_the_first_and_the_latest_failure():
    memory = FaultMemory(table(a=code(1)))
    drive(memory, {"a": (-1.0, 5.0, 1.0)}, date="2026-01-01")
    drive(memory, {"a": -1.0})
    drive(memory, {"a": (-1.0, 9.9, 1.0)}, date="2026-01-03")
    first, last = memory.entries["a"].first, memory.entries["a"].last
    assert (first.cycle, first.date, first.instant) == (1, "2026-01-01", 5.0)
    assert first.time[0] == -2.0
    assert first.time[-1] == 1.0
    assert first.values["vehicle_speed"] == pytest.approx([15.0 + t for t in first.time])
    assert first.at_instant() == pytest.approx({"vehicle_speed": 15.0, "yaw_rate": np.sin(5.0)})
    # The drive ended at the failure: what there is of it is kept.
    assert (last.cycle, last.instant, last.time[-1]) == (3, pytest.approx(9.9), 0.0)


def test_frames_do_not_depend_on_how_the_drive_is_cut():
    time = np.arange(1000) / 100.0
    result, speed = np.where(time < 4.99, -1.0, 1.0), np.where(np.arange(1000) % 7 == 0, np.nan, time)
    frames = []
    for size in (1000, 137, 13):
        memory = FaultMemory(table(a=code(1)))
        memory.begin_cycle("2026-01-01")
        for at in range(0, 1000, size):
            piece = slice(at, at + size)
            memory.absorb(time[piece], {"a": result[piece]}, {"vehicle_speed": speed[piece]})
        memory.end_cycle()
        frames.append(memory.entries["a"].first)
    assert frames[0] == frames[1] == frames[2]
    assert len(frames[0].time) <= 61
    assert 0.0 in frames[0].time


def test_a_full_memory_displaces_the_least_important_code():
    codes = table(**{f"c{k}": code(k, priority=10 * k) for k in range(1, 6)})
    memory = FaultMemory(codes, places=3)
    drive(memory, {"c1": (0.0, 1.0, 1.0), "c5": (0.0, 2.0, 1.0), "c3": (0.0, 3.0, 1.0), "c2": (0.0, 4.0, 1.0)})
    assert [name for name, entry in memory.entries.items() if entry.stored] == ["c1", "c2", "c3"]
    assert memory.overflowed
    drive(memory, {"c4": 1.0})
    assert not memory.entries["c4"].stored


def test_clearing_forgets_and_a_fault_that_is_still_there_comes_back():
    memory = FaultMemory(table(a=code(1), b=code(2)))
    time = np.arange(10.0)
    memory.begin_cycle()
    memory.absorb(time, {"a": np.ones(10), "b": np.ones(10)})
    memory.clear("a")
    assert [name for name, entry in memory.entries.items() if entry.stored] == ["b"]
    memory.absorb(time + 10.0, {"a": np.ones(10), "b": np.ones(10)})
    assert memory.entries["a"].stored
    memory.end_cycle()
    memory.clear()
    assert all(entry.status == CLEARED for entry in memory.entries.values())


def test_a_displaced_code_still_says_that_its_test_fails():
    memory = FaultMemory(table(a=code(1, priority=1), b=code(2, priority=9, lamp=True)), places=1)
    drive(memory, {"b": (-1.0, 2.0, 1.0), "a": (-1.0, 4.0, 1.0)})
    kept = CodeStatus.TEST_FAILED | CodeStatus.FAILED_THIS_CYCLE | CodeStatus.FAILED_SINCE_CLEAR
    assert status(memory, "b") == kept
    assert not memory.entries["b"].stored
    assert not memory.lamp


def test_a_consequence_that_outlasts_its_cause_is_raised():
    memory = FaultMemory(table(a=code(1), b=code(2, consequence_of=("a",))))
    time = np.arange(100) / 10.0
    a = np.select([time < 3.0, time < 6.0], [-1.0, 1.0], -1.0)
    memory.begin_cycle()
    changes = memory.absorb(time, {"a": a, "b": np.where(time < 3.5, -1.0, 1.0)})
    memory.end_cycle()
    assert [change[1:] for change in changes] == [
        ("a", "passed"),
        ("b", "passed"),
        ("a", "failed"),
        ("a", "passed"),
        ("b", "failed"),
    ]
    assert changes[-1][0] == pytest.approx(6.1)
    assert memory.entries["b"].stored


def test_a_consequence_of_what_fails_is_no_step_towards_healing():
    memory = FaultMemory(table(a=code(1), b=code(2, consequence_of=("a",), healing_cycles=1, lamp=True)))
    drive(memory, {"b": 1.0})
    drive(memory, {"b": (-1.0, 5.0, 1.0), "a": (-1.0, 5.0, 1.0)})
    assert memory.entries["b"].consequence_of == "a"
    assert memory.lamp


def test_a_code_without_a_lamp_ages_from_its_first_passed_cycle_on():
    memory = FaultMemory(table(a=code(1, healing_cycles=9, aging_cycles=2)))
    drive(memory, {"a": 1.0})
    drive(memory, {"a": -1.0})
    assert memory.entries["a"].stored
    drive(memory, {"a": -1.0})
    assert not memory.entries["a"].stored


def test_clearing_one_code_leaves_others_as_they_are_and_keeps_no_frame_of_its_own():
    memory = FaultMemory(table(a=code(1), b=code(2, increment=1, decrement=1)))
    time = np.arange(100) / 10.0
    memory.begin_cycle()
    speed = {"vehicle_speed": time}
    memory.absorb(time, {"a": np.where(time < 9.5, -1.0, 1.0), "b": np.ones(100)}, speed)
    memory.clear("C1A01-62")
    assert memory.entries["b"].counter == 100
    changes = memory.absorb(time + 10.0, {"b": np.ones(100)}, speed)
    assert changes == ((pytest.approx(12.6), "b", "failed"),)
    memory.end_cycle()
    assert memory.entries["a"].status == CLEARED
    assert memory.entries["a"].last is None


def test_signals_that_the_table_does_not_list_are_left_out():
    memory = FaultMemory(table(a=code(1)))
    memory.begin_cycle()
    memory.absorb([0.0], {"a": [1.0]}, {"vehicle_speed": [3.0], "motor_torque": [1.0]})
    memory.end_cycle()
    assert memory.entries["a"].last.at_instant() == {"vehicle_speed": 3.0}


def test_the_strongest_reaction_of_what_fails_now_counts():
    memory = FaultMemory(table(a=code(1, reaction="degrade"), b=code(2, reaction="off")))
    drive(memory, {"a": 1.0, "b": 1.0})
    assert memory.reaction == "off"
    drive(memory, {"b": -1.0})
    assert memory.reaction == "degrade"


def test_bad_input_is_named():
    memory = FaultMemory(table(friction=code(1)))
    with pytest.raises(ParameterError, match="begin one"):
        memory.absorb([0.0], {"friction": [1.0]})
    memory.begin_cycle()
    with pytest.raises(ParameterError, match="end it before"):
        memory.begin_cycle()
    with pytest.raises(InputError, match="did you mean 'friction'"):
        memory.absorb([0.0], {"frction": [1.0]})
    with pytest.raises(InputError, match="did you mean 'yaw_rate'"):
        memory.absorb([0.0], {"friction": [1.0]}, {"yaw_rte": [0.0]})
    with pytest.raises(InputError, match="must be finite and increase"):
        memory.absorb([np.nan], {"friction": [1.0]})
    with pytest.raises(InputError, match="expected \\(2,\\)"):
        memory.absorb([0.0, 1.0], {"friction": [1.0]})
    with pytest.raises(InputError, match="must be finite and increase"):
        memory.absorb([1.0, 0.0], {"friction": [1.0, 1.0]})
    memory.absorb([5.0], {"friction": [1.0]})
    with pytest.raises(InputError, match="must be finite and increase"):
        memory.absorb([4.0], {"friction": [1.0]})
