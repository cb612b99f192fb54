"""The fault memory in C does what that in Python does; power loss at any write leaves the old or the new one whole."""

import ctypes
import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from exported_c import needs_gcc
from tierod.cli import main
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.export.c_export import write_folder
from tierod.export.fault_memory import fault_memory_files

pytestmark = needs_gcc

PLACES = 5
FLAGS = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]


@pytest.fixture(scope="module")
def codes():
    table, random = load_trouble_codes(), np.random.default_rng(5)
    changed = {
        name: replace(
            code,
            increment=int(random.choice([127, 64, 40])),
            decrement=int(random.choice([128, 50])),
            jump=bool(random.integers(2)),
            priority=int(random.integers(1, 4)),
            confirmation_cycles=int(random.integers(1, 3)),
            healing_cycles=int(random.integers(1, 3)),
            aging_cycles=int(random.integers(1, 4)),
            lamp=bool(random.integers(2)),
        )
        for name, code in table.codes.items()
    }
    names = list(changed)
    # Chains: the second is a consequence of the first, the third of the second.
    for first in range(0, len(names) - 3, 4):
        changed[names[first + 1]] = replace(changed[names[first + 1]], consequence_of=(names[first],))
        changed[names[first + 2]] = replace(changed[names[first + 2]], consequence_of=(names[first + 1],))
    return replace(table, codes=changed)


class Memory:
    """The compiled memory with a store in this program, whose power may fail."""

    def __init__(self, path, codes):
        count, signals = len(codes.codes), len(codes.identifiers)

        class Frame(ctypes.Structure):
            _fields_ = [
                ("there", ctypes.c_bool), ("cycle", ctypes.c_uint32), ("instant", ctypes.c_uint32),
                ("values", ctypes.c_float * signals),
            ]  # fmt: skip

        class Entry(ctypes.Structure):
            _fields_ = [
                ("status", ctypes.c_uint8), ("counter", ctypes.c_int16), ("verdict", ctypes.c_int8),
                ("cause", ctypes.c_int16), ("occurrences", ctypes.c_uint32), ("failed_cycles", ctypes.c_uint32),
                ("passed_cycles", ctypes.c_uint32), ("healed", ctypes.c_bool), ("first", Frame), ("last", Frame),
            ]  # fmt: skip

        class Whole(ctypes.Structure):
            _fields_ = [
                ("entries", Entry * count), ("before", Entry * count), ("since", ctypes.c_uint32 * count),
                ("has_before", ctypes.c_bool * count), ("counter", ctypes.c_int16 * count),
                ("verdict", ctypes.c_int8 * count), ("cycles", ctypes.c_uint32), ("sequence", ctypes.c_uint32),
                ("slot", ctypes.c_uint8), ("open", ctypes.c_bool), ("live", ctypes.c_bool),
                ("overflowed", ctypes.c_bool),
            ]  # fmt: skip

        self.library, self.kind, self.names = ctypes.CDLL(str(path)), Whole, list(codes.codes)
        self.signals, self.whole = signals, Whole()
        self.stored, self.left, self.writes = bytearray(100_000), None, 0
        access = ctypes.CFUNCTYPE(
            ctypes.c_bool, ctypes.c_void_p, ctypes.c_uint32, ctypes.POINTER(ctypes.c_uint8), ctypes.c_uint32
        )

        class Store(ctypes.Structure):
            _fields_ = [("context", ctypes.c_void_p), ("read", access), ("write", access)]

        self.store = Store(None, access(self._read), access(self._write))
        for name in ("load", "save", "begin_cycle", "step", "end_cycle", "clear", "lamp"):
            getattr(self.library, f"tierod_memory_{name}").restype = ctypes.c_bool

    def _read(self, context, offset, data, length):
        ctypes.memmove(data, bytes(self.stored[offset : offset + length]), length)
        return True

    def _write(self, context, offset, data, length):
        self.writes += 1
        if self.left is not None:
            if self.left == 0:
                # Half of it is still written when the power goes.
                length //= 2
            if self.left < 0:
                return False
            self.left -= 1
        self.stored[offset : offset + length] = bytes(data[:length])
        return self.left is None or self.left >= 0

    def __call__(self, name, *given):
        call = getattr(self.library, f"tierod_memory_{name}")
        return call(ctypes.byref(self.whole), ctypes.byref(self.store), *given)

    def step(self, time, results, values):
        rows = (ctypes.c_int8 * len(self.names))(*results)
        return self("step", ctypes.c_uint32(time), rows, (ctypes.c_float * self.signals)(*values))

    def state(self):
        return [
            (
                e.status, e.counter, e.verdict, e.occurrences, e.failed_cycles, e.passed_cycles, e.healed,
                "" if e.cause < 0 else self.names[e.cause],
            )
            for e in self.whole.entries
        ]  # fmt: skip

    def kept(self):
        frames = [bytes(memoryview(f).cast("B")) for e in self.whole.entries for f in (e.first, e.last)]
        return [(s[0], *s[3:]) for s in self.state()], frames, self.whole.cycles, self.whole.open, self.whole.overflowed


@pytest.fixture(scope="module")
def library(codes, tmp_path_factory):
    folder = tmp_path_factory.mktemp("memory")
    write_folder(fault_memory_files(codes, PLACES), folder)
    traps = ["-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"]
    command = ["gcc", *FLAGS, *traps, "-fPIC", "-shared", "tierod_fault_memory.c", "-o", "memory.so"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return folder / "memory.so"


def results_of(random, count):
    """Results that hold for a while: runs of failed, passed and none."""
    now = np.zeros(count, int)
    while True:
        changes = random.random(count) < 0.15
        now[changes] = random.choice([-1, 0, 1], size=int(changes.sum()), p=[0.5, 0.2, 0.3])
        yield now


def expected(memory):
    return [
        (
            int(e.status), e.counter, e.verdict, e.occurrences, e.failed_cycles, e.passed_cycles, e.healed,
            e.consequence_of,
        )
        for e in memory.entries.values()
    ]  # fmt: skip


def test_it_does_what_the_memory_in_python_does(codes, library):
    ours, compiled = FaultMemory(codes, places=PLACES), Memory(library, codes)
    assert not compiled("load")
    random, signals = np.random.default_rng(1), list(codes.identifiers)
    seen, frames = set(), 0
    for cycle in range(14):
        ours.begin_cycle("2026-01-01")
        assert compiled("begin_cycle")
        quiet = cycle % 3 == 2
        for step, row in zip(range(1, 60), results_of(random, len(codes.codes)), strict=False):
            results = np.minimum(row, 0) - (random.random(len(row)) < 0.3) * (row > 0) if quiet else row
            values = random.standard_normal(len(signals)).astype(np.float32)
            given = {name: results[k : k + 1].astype(float) for k, name in enumerate(codes.codes)}
            ours.absorb([0.1 * step], given, dict(zip(signals, values[:, None], strict=True)))
            assert compiled.step(100 * step, results, values)
            assert compiled.state() == expected(ours)
            seen |= {(each[0], each[6], bool(each[7])) for each in compiled.state()}
        if cycle in (5, 9):
            name = list(codes.codes)[cycle]
            ours.clear(name)
            assert compiled("clear", ctypes.c_int16(cycle))
        ours.end_cycle()
        assert compiled("end_cycle")
        assert compiled.state() == expected(ours)
        assert compiled.library.tierod_memory_lamp(ctypes.byref(compiled.whole)) == ours.lamp
        for entry, own in zip(compiled.whole.entries, ours.entries.values(), strict=True):
            if own.last is not None and entry.last.instant == round(1000.0 * own.last.instant):
                frames += 1
                at = np.array([own.last.at_instant()[name] for name in signals], np.float32)
                assert np.array_equal(at, np.array(entry.last.values[:], np.float32))
    assert len(seen) > 12
    assert any(cause for *_, cause in seen)
    assert frames > 20
    assert ours.overflowed == compiled.whole.overflowed


def test_power_loss_at_any_write_leaves_the_old_or_the_new_memory(codes, library):
    random, failing = np.random.default_rng(2), np.ones(len(codes.codes), int)
    memory = Memory(library, codes)
    memory("load")
    assert memory("begin_cycle")
    found = set()
    for round_ in range(2):
        for step in range(1, 4):
            memory.step(100 * step, failing * (1 if round_ == 0 else -1), random.standard_normal(memory.signals))
        before, old, whole = memory.kept(), bytes(memory.stored), bytes(memory.whole)
        memory.writes = 0
        assert memory("end_cycle")
        after, writes = memory.kept(), memory.writes
        assert writes == len(codes.codes) + 2
        assert before != after
        for cut in range(writes + 1):
            memory.stored[:] = old
            memory.whole = memory.kind.from_buffer_copy(whole)
            memory.left = cut
            assert memory("end_cycle") == (cut == writes)
            again = Memory(library, codes)
            again.stored[:] = memory.stored
            assert again("load")
            assert again.kept() == (after if cut == writes else before)
            found.add(cut == writes)
        memory.left = None
        assert memory("begin_cycle")
    assert found == {False, True}


def test_the_command_line_writes_what_make_compares_and_a_wrong_number_fails(tmp_path, capsys):
    folder = tmp_path / "ecu"
    assert main(["export", "c", "fault-memory", "-o", str(folder)]) == 0
    assert "make -C" in capsys.readouterr().out
    done = subprocess.run(["make", "-s", "-C", folder], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert re.search(r"\d+ rows, 0 different, 0 refused, [1-9]\d+ cuts of power, 0 broken", done.stdout)
    table = folder / "test/expected.csv"
    table.write_text(table.read_text().replace("80,0,-1", "80,1,-1", 1))
    failed = subprocess.run(["make", "-s", "-C", folder], capture_output=True, text=True, check=False)
    assert failed.returncode != 0
    assert " 1 different" in failed.stdout
    assert main(["export", "fmu", "fault-memory", "-o", str(tmp_path / "m.fmu"), "--vehicle", "midsize-eps"]) == 3
