"""Text and state of the condition monitor's C on a Cortex-M7, in the budget of a control unit."""

import re
import shutil
import subprocess

import pytest

from tierod.export.c_export import interface_of, monitor_files, write_folder
from tierod.export.evidence.targets import FLAGS, GCC, M7
from tierod.export.interface import Options
from tierod.export.subject import subject_of

pytestmark = pytest.mark.skipif(shutil.which(GCC) is None, reason=f"no {GCC} is installed")


@pytest.mark.parametrize(("variant", "most_text", "most_state"), [("bank", 260_000, 70_000), ("rules", 60_000, 8_000)])
def test_text_and_state_are_in_the_budget(tmp_path, variant, most_text, most_state):
    face = interface_of(subject_of("condition", "smartload", variant), Options("single"))
    write_folder(monitor_files(face), tmp_path)
    state = f'#include "{face.prefix}.h"\nextern {face.prefix}_state_t state;\n{face.prefix}_state_t state;\n'
    (tmp_path / "state.c").write_text(state)
    command = [GCC, *M7, *FLAGS, "-c", f"{face.prefix}.c", "state.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    objects = [f"{face.prefix}.o", "state.o"]
    sizes = subprocess.run(["arm-none-eabi-size", *objects], cwd=tmp_path, capture_output=True, text=True, check=True)
    (text, data, bss), (_, *memory) = [
        list(map(int, each)) for each in re.findall(r"^\s*(\d+)\s+(\d+)\s+(\d+)", sizes.stdout, re.MULTILINE)
    ]
    assert text <= most_text
    assert data + bss == 0
    assert 0 < sum(memory) <= most_state
    print(text, sum(memory))
