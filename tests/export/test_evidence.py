import shutil

import pytest

from exported_c import exported, needs_gcc, rounded
from tierod.export.evidence.checks import FURTHER, SANITIZED, misra, of_monitor, sanitized
from tierod.export.evidence.comparison import differences, table
from tierod.export.evidence.coverage import Stepped, covered
from tierod.export.subject import subject_of_block
from tierod.export.vectors import input_table, random_inputs, vectors_of
from watched_torque import Watch

needs_cppcheck = pytest.mark.skipif(shutil.which("cppcheck") is None, reason="no cppcheck is installed")


@pytest.fixture(scope="module")
def watch():
    return subject_of_block("watch", Watch(), 100.0, "A watch")


@pytest.fixture
def folder(tmp_path, watch):
    vectors = vectors_of(watch, random_inputs(watch, 300), "a test")
    exported(watch, tmp_path)
    (tmp_path / "build").mkdir()
    (tmp_path / "test/random.csv").write_text(input_table(watch, vectors))
    return tmp_path


@needs_gcc
def test_every_build_is_compared_and_an_absent_compiler_is_named(watch, folder, monkeypatch):
    monkeypatch.setattr("tierod.export.evidence.comparison.COMPILERS", ("gcc", "no-such-compiler"))
    face = exported(watch, folder, precision="double")
    found = differences(face, folder, {"random": rounded(random_inputs(watch, 300))})
    assert [each.trouble for each in found] == [""] * 4 + ["no-such-compiler is not installed"] * 4
    assert all(each.worst < 1e-12 and each.steps == 300 and each.warnings == 0 for each in found[:4])
    rows = table(found, "double").rows
    assert rows[0][0] == "gcc -O0"
    assert rows[-1][1] == "no-such-compiler is not installed"


@needs_gcc
def test_coverage_and_sanitizers_are_counted_and_branches_that_are_left_by_kind(watch, folder):
    face = exported(watch, folder)
    for name in (FURTHER, SANITIZED):
        shutil.copy(folder / "test/random.csv", folder / name)
    whole, left, *_ = covered(of_monitor(face), folder, Stepped(face.program, face.graph.state))
    rows = {name: result for name, _, result in whole.rows}
    assert float(rows["statements executed"].split()[0]) > 95.0
    assert float(rows["branches taken"].split()[0]) > 60.0
    kinds = dict(left.rows)
    assert int(kinds["the end of a counter of steps, after 2^32 steps: 497 days at 100 Hz"]) >= 1
    assert not list(folder.glob("*.gcov"))
    assert sanitized(of_monitor(face), folder, "gcc")[2] == "0 reports in 300 steps"
    assert "not run" in sanitized(of_monitor(face), folder, "no-such-compiler")[2]


@needs_cppcheck
def test_departures_from_misra_are_counted_by_rule(watch, folder):
    face = exported(watch, folder)
    assert misra(of_monitor(face), folder).rows == (("none", "0", "no departure was found"),)
    source = folder / "tierod_watch.c"
    source.write_text(
        source.read_text() + "int odd(int a);\nint odd(int a)\n{\n    if (a) return 1;\n    return 2;\n}\n"
    )
    rules = {row[0]: row for row in misra(of_monitor(face), folder).rows}
    assert rules["rule 15.6"][2] == "no reason is recorded"
