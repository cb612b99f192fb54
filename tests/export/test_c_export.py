import re
import subprocess

import numpy as np
import pytest

from exported_c import exported, needs_gcc, reference, rounded, run, worst_share
from tierod.export.subject import subject_of, subject_of_block
from tierod.export.vectors import random_inputs
from watched_torque import Watch

DRIVE = np.array([[0.0], [4.0], [np.nan]] * 5 + [[5.0]] * 100)


@pytest.fixture(scope="module")
def watch():
    return subject_of_block("watch", Watch(), 100.0, "A watch")


@pytest.fixture(scope="module")
def friction():
    return subject_of("friction", "midsize-eps")


@needs_gcc
@pytest.mark.parametrize(("precision", "share", "steps"), [("double", 1e-13, 0), ("single", 3e-6, 1)])
def test_the_c_of_a_block_states_what_scan_states(watch, tmp_path, precision, share, steps):
    face = exported(watch, tmp_path, precision=precision)
    found = run(face, tmp_path, DRIVE)
    wanted = reference(watch, DRIVE)
    assert wanted[-1, 0] == 2.0
    assert np.count_nonzero(found[:, 0] != wanted[:, 0]) <= steps
    assert worst_share(found[:, 1:], wanted[:, 1:]).max() <= share


@needs_gcc
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize(("precision", "share"), [("double", 1e-9), ("single", 1e-3)])
def test_friction_compiles_without_a_warning_and_agrees_on_random_samples(
    friction, tmp_path, precision, share, compiler
):
    if subprocess.run(["which", compiler], capture_output=True, check=False).returncode:
        pytest.skip(f"no {compiler} is installed")
    inputs = rounded(random_inputs(friction, 3000, seed=5))
    face = exported(friction, tmp_path, precision=precision)
    flags = ("-O1", "-ffp-contract=off")
    found = run(face, tmp_path, inputs, flags=flags, compiler=compiler)
    assert worst_share(found, reference(friction, inputs)).max() <= share


@needs_gcc
def test_make_builds_and_compares_and_a_wrong_number_fails(watch, tmp_path):
    exported(watch, tmp_path, inputs=DRIVE, precision="single")
    done = subprocess.run(["make", "-s", "-C", tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "115 steps, 12 compared, 0 of 8 outputs beyond tolerance" in done.stdout
    table = tmp_path / "test/expected.csv"
    rows = table.read_text().splitlines()
    rows[5] = ",".join([*rows[5].split(",")[:-1], "7"])
    table.write_text("\n".join(rows) + "\n")
    failed = subprocess.run(["make", "-s", "-C", tmp_path], capture_output=True, text=True, check=False)
    assert failed.returncode != 0
    assert "late differs" in failed.stdout


@needs_gcc
def test_a_clock_of_single_precision_goes_on_after_a_hundred_hours(watch, tmp_path):
    face = exported(watch, tmp_path, precision="single")
    assert set(face.counted.values()) == {"time_steps", "above_steps"}
    found = run(face, tmp_path, DRIVE, steps=36_000_000)
    since = face.subject.graph.output.index("statement.since")
    # 1.15 s after 360 000 s, within the spacing of single-precision numbers there.
    assert found[-1, since] == pytest.approx(360_001.15, abs=0.032)
    # Decisions rest on differences that are counted, so that they do not change.
    assert np.count_nonzero(found[:, 0] != reference(watch, DRIVE)[:, 0]) <= 1


def test_the_same_export_gives_the_same_bytes(friction, tmp_path):
    for name in ("one", "two"):
        exported(friction, tmp_path / name)
    written = {path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*") if path.is_file()}
    assert len(written) == 8
    for path in written:
        assert (tmp_path / "one" / path).read_bytes() == (tmp_path / "two" / path).read_bytes()


def test_the_header_says_unit_meaning_and_range(watch, tmp_path):
    exported(watch, tmp_path)
    text = (tmp_path / "tierod_watch.h").read_text()
    torque = "/* [N*m] Torque of the driver, measured by the torsion bar; positive: towards left; -30 to 30 */"
    assert f"    {torque}\n    tierod_watch_real_t driver_torque;\n" in text
    assert "/* [N*m] torque without its noise */\n    tierod_watch_real_t smooth;" in text
    assert "/* [N*m] torque above which it is suspect */\n    tierod_watch_real_t limit;" in text
    assert "/* [s] time constant of the smoothing */\n    tierod_watch_real_t memory;" in text
    assert text.count("since the start, and above the limit */") == 2
    assert "    TIEROD_WATCH_SUSPECT = 2,\n" in text
    assert "tierod_watch_status_t statement_status;" in text
    assert text.isascii()


def test_what_an_ecu_forbids_is_not_there(friction, tmp_path):
    exported(friction, tmp_path)
    text = (tmp_path / "tierod_friction.c").read_text()
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    for word in ("malloc", "union", "goto", "while", "static tierod_friction_real_t w", "double"):
        assert word not in code
    assert set(re.findall(r"#include (\S+)", code)) == {'"tierod_friction.h"', "<math.h>"}
    bodies = re.findall(r"^static void \w+\([^)]*\)\n\{\n(.*?)^\}", code, flags=re.DOTALL | re.MULTILINE)
    assert bodies
    assert max(body.count(";") for body in bodies) <= 200
