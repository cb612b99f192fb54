"""The command line lets linear algebra use one thread, so that its figures do not depend on the number of cores."""

import subprocess
import sys

import pytest

from tierod.core.processes import THREADS

ASKED = "import os\nfrom tierod.cli import main\nmain(['monitors'])\nprint(os.environ['OPENBLAS_NUM_THREADS'])"


@pytest.mark.parametrize(("chosen", "used"), [(None, "1"), ("3", "3")])
def test_one_thread_unless_the_user_chose(monkeypatch, chosen, used):
    for name in THREADS:
        monkeypatch.delenv(name, raising=False)
    if chosen:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", chosen)
    done = subprocess.run([sys.executable, "-c", ASKED], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == used
