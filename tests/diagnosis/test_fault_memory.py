"""Trouble codes, their debouncing and the memory that holds them."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.memories import code, drive, table
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.diagnosis.entry import CodeStatus
from tierod.diagnosis.fault_memory import CAUSE_DELAY, FaultMemory
from tierod.diagnosis.trouble_codes import DebounceCounter, DebounceCounters, TroubleCode, load_trouble_codes
from tierod.monitors.registry import MONITORS


def status(memory, name="a"):
    return memory.entries[name].status


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


def test_a_full_memory_displaces_the_least_important_code():
    codes = table(**{f"c{k}": code(k, priority=10 * k) for k in range(1, 6)})
    memory = FaultMemory(codes, places=3)
    drive(memory, {"c1": (0.0, 1.0, 1.0), "c5": (0.0, 2.0, 1.0), "c3": (0.0, 3.0, 1.0), "c2": (0.0, 4.0, 1.0)})
    assert [name for name, entry in memory.entries.items() if entry.stored] == ["c1", "c2", "c3"]
    assert memory.overflowed
    drive(memory, {"c4": 1.0})
    assert not memory.entries["c4"].stored


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


def run(block, results):
    state, outputs = block.init(), []
    for result in results:
        state, output = block.step(state, DebounceCounter.Sample(result))
        outputs.append(output)
    return outputs


def test_it_fails_after_127_and_passes_after_128_results_and_is_clamped():
    counters = run(DebounceCounter(), [1.0] * 200)
    assert [output.verdict for output in counters].index(1.0) == 126
    assert counters[-1].counter == 127.0
    back = run(DebounceCounter(jump=False), [1.0] * 200 + [-1.0] * 400)
    assert [output.verdict for output in back].index(-1.0) == 200 + 254
    assert back[-1].counter == -128.0


@pytest.mark.parametrize("none", [0.0, float("nan")])
def test_without_a_result_the_counter_is_frozen(none):
    outputs = run(DebounceCounter(), [1.0] * 50 + [none] * 1000 + [1.0] * 77)
    assert outputs[-2].verdict == 0.0
    assert outputs[-1].verdict == 1.0


def test_a_consequence_stands_still_while_its_cause_has_failed():
    bank = DebounceCounters((DebounceCounter(127.0, 128.0), DebounceCounter(1.0, 1.0)), ((), (0,)))
    results = np.array([[-1.0, 1.0]] * 60 + [[1.0, 1.0]] * 100 + [[-1.0, 1.0]] * 66)
    done = scan(bank, results)
    assert done["verdict_1"][-1] == 0.0
    # 61 results count before the cause has failed, 65 after it has passed; the next one makes 127.
    more = scan(bank, np.array([[-1.0, 1.0]]), done.state)
    assert more["verdict_1"][-1] == 1.0


WHOLE = """
[codes.a]
code = "C1A01-92"
meaning = "something"
monitor = "friction"

[freeze_frame]
yaw_rate = 0xD001
"""


def test_every_shipped_code_is_fed_by_a_monitor():
    codes = load_trouble_codes()
    assert codes.codes
    for code_ in codes.codes.values():
        assert code_.monitor in MONITORS


@pytest.mark.parametrize(
    ("display", "number"),
    [("P0123-00", 0x012300), ("C1A01-92", 0x5A0192), ("B3FFF-FF", 0xBFFFFF), ("U0100-87", 0xC10087)],
)
def test_the_three_bytes_of_a_code(display, number):
    assert TroubleCode(display, "", "friction").number == number


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (('"C1A01-92"', '"X1A01-92"'), "line 2.*letter of PCBU"),
        (("meaning", "meanign"), "meanign"),
        (('monitor = "friction"', 'monitor = "friction"\nfailed_by = ["broken"]'), "'broken'"),
        (('monitor = "friction"', 'monitor = "friction"\nfailed_by = ["healthy"]'), "one of them only"),
        (('monitor = "friction"', 'monitor = "friction"\nconsequence_of = ["b"]'), "consequence of 'b'"),
        (('monitor = "friction"', 'monitor = "friction"\nconsequence_of = ["a"]'), "remove the loop"),
        (('monitor = "friction"', 'monitor = "friction"\npriority = 0'), "expected 1 to 255"),
        (("yaw_rate", "yaw_rat"), "did you mean 'yaw_rate'"),
        (("0xD001", "70000"), "0 to 65535"),
        (("[freeze_frame]", "[freezer]"), "'freezer'"),
    ],
)
def test_a_slip_in_the_table_is_named(tmp_path, change, says):
    path = tmp_path / "codes.toml"
    path.write_text(WHOLE)
    load_trouble_codes(path)
    spoilt = tmp_path / "spoilt.toml"
    spoilt.write_text(WHOLE.replace(*change))
    with pytest.raises(ParameterError, match=says):
        load_trouble_codes(spoilt)
