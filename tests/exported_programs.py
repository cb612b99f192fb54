"""Random programs as exported C, compiled together."""

from __future__ import annotations

import ctypes
import subprocess
from functools import cached_property

import numpy as np

from exported_c import WARNINGS
from random_programs import Made
from tierod.core.graph.operations import Program
from tierod.core.graph.trace import Graph
from tierod.export.c_export import comparing_program, monitor_files
from tierod.export.interface import Interface, Options
from tierod.export.simplification import growth_first, simplified
from tierod.export.subject import Described, Subject


class ProgramInterface(Interface):
    """Interface of the C of a step that is given as a program."""

    made: Made

    @cached_property
    def stepped(self) -> Program:
        found = simplified(self.made.step, self.initial, self.tuning)
        return growth_first(found) if self.options.precision == "single" else found

    @cached_property
    def initial(self) -> Program:
        return self.made.initial


def interface_of_program(made: Made, name: str, **options) -> ProgramInterface:
    """The interface of an export of a random step."""
    counts = {"tuning": len(made.tuning), "state": made.states, "sample": made.inputs, "output": made.outputs}
    groups = {word: tuple(f"{word}{k}" for k in range(count)) for word, count in counts.items()}
    rings = tuple((f"line{k}", size) for k, size in enumerate(made.rings))
    graph = Graph(**{"name": name, "rings": rings, "sample_tree": (), "output_tree": (), "make": lambda: None} | groups)
    known = {word: tuple(map(Described, paths)) for word, paths in groups.items()}
    subject = Subject(name, name, name, "", "", 100.0, None, graph, **known, values=made.tuning)
    face = ProgramInterface(subject, Options(**options))
    object.__setattr__(face, "made", made)
    return face


def compiled(faces, folder, compiler, flags):
    """A function for each interface that runs its C over samples; all of them in one library."""
    folder.mkdir(parents=True, exist_ok=True)
    sources = []
    for face in faces:
        texts = monitor_files(face) | {"compare.c": comparing_program(face, [0.0] * len(face.graph.output), 0.0)}
        own = folder / face.prefix
        own.mkdir(exist_ok=True)
        for name, text in texts.items():
            (own / name).write_text(text)
        source = own / "all.c"
        wanted = [name for name in texts if name.endswith(".c")]
        source.write_text(f"#define tierod_run run_{face.prefix}\n" + "".join(f'#include "{n}"\n' for n in wanted))
        sources.append(str(source))
    library = folder / f"{compiler}{abs(hash(flags))}.so"
    command = [compiler, *WARNINGS.split(), *flags, "-ffp-contract=off", "-fPIC", "-shared", "-DTIEROD_NO_MAIN"]
    done = subprocess.run([*command, *sources, "-o", library, "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    loaded = ctypes.CDLL(str(library))
    return [_runner(loaded, face) for face in faces]


def _runner(loaded, face):
    function = getattr(loaded, f"run_{face.prefix}")
    function.argtypes = [ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_long, ctypes.c_long]

    def run(samples):
        given = np.ascontiguousarray(samples)
        found = np.zeros((len(given), len(face.graph.output)))
        function(len(given), given.ctypes.data, found.ctypes.data, 1, 0)
        return found

    return run


def same_bits(found, wanted):
    """Whether numbers are the same to the last bit, zeros with their signs; a NaN is as good as another."""
    return np.array_equal(found, wanted, equal_nan=True) and bool(
        np.all((np.signbit(found) == np.signbit(wanted)) | np.isnan(wanted))
    )
