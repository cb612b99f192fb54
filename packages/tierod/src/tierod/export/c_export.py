"""A C export as a folder: header, source, parameters, test vectors, comparison program, Makefile and README."""

from __future__ import annotations

import errno
from collections.abc import Mapping
from pathlib import Path

from tierod.core.errors import OutputError, ParameterError
from tierod.core.files import expanded, require_folder, write_text
from tierod.core.graph.bank import BankGraph
from tierod.export.bank import BankInterface, bank_parameter_rows, bank_source, bank_structs
from tierod.export.c_header import header, rendered
from tierod.export.c_source import parameters, source
from tierod.export.c_test import comparing_program
from tierod.export.interface import Interface, Options
from tierod.export.subject import Subject
from tierod.export.vectors import ROWS_BEYOND, SPACING, TOLERANCE, Vectors, input_table, output_table, tolerances

BITS = 32  # Bits of the mask of valid inputs


def files(face: Interface, vectors: Vectors) -> Mapping[str, str]:
    """All files of an export: path in its folder -> text; equal exports give equal bytes."""
    subject = face.subject
    beyond = ROWS_BEYOND[face.options.precision]
    return {
        **monitor_files(face),
        **{name: rendered(f"{name}.j2", _about(face, vectors)) for name in ("Makefile", "README.md")},
        "test/compare.c": comparing_program(face, tolerances(face, vectors), beyond),
        "test/inputs.csv": input_table(subject, vectors),
        "test/expected.csv": output_table(subject, vectors),
    }


def _about(face: Interface, vectors: Vectors) -> dict[str, object]:
    subject, precision = face.subject, face.options.precision
    beyond = ROWS_BEYOND[precision]
    rows = f", but for {beyond:.1%} of the rows: a decision may fall some steps earlier or later" if beyond else ""
    return {
        "prefix": face.prefix, "title": subject.title, "version": subject.version, "vehicle": subject.vehicle,
        "precision": precision, "digest": f"{subject.digest:08x}", "sample_time": f"{subject.sample_time:g}",
        "validity": face.options.validity, "clocks": list(face.counted.values()), "source": vectors.source,
        "steps": len(vectors.inputs), "spacing": SPACING, "tolerance": f"{TOLERANCE[precision]:g}", "beyond": rows,
    }  # fmt: skip


def monitor_files(face: Interface) -> dict[str, str]:
    prefix = face.prefix
    if isinstance(face, BankInterface):
        texts = (header(face, bank_structs(face)), bank_source(face), parameters(face, bank_parameter_rows(face)))
    else:
        texts = (header(face), source(face), parameters(face))
    return dict(zip((f"{prefix}.h", f"{prefix}.c", f"{prefix}_parameters.c"), texts, strict=True))


def interface_of(subject: Subject, options: Options) -> Interface:
    """Interface of an export: of a bank, or of a single block."""
    count = len(subject.graph.sample)
    if options.validity and count > BITS:
        raise ParameterError(
            f"{subject.title} takes {count} inputs, and a mask of valid ones has {BITS} bits; leave --validity out, so "
            "that NaN stands for a missing input"
        )
    kind = BankInterface if isinstance(subject.graph, BankGraph) else Interface
    return kind(subject, options)


def refuse_foreign(folder: str | Path, own: str) -> None:
    """Refuse a folder whose files do not come from an earlier export of this monitor."""
    place = expanded(folder)
    taken = next((name for name in ("README.md", "Makefile") if (place / name).exists()), None)
    if taken is not None and not (place / own).exists():
        raise OutputError(f"{place} holds a {taken} that is not of this export; name a folder of its own with --output")


def write_folder(texts: Mapping[str, str], folder: str | Path) -> Path:
    """Write files into a folder, created if missing; each file is written atomically."""
    place = expanded(folder)
    require_folder(place)
    for path in {place, *((place / name).parent for name in texts)}:
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            what = (
                "there is a file of that name"
                if error.errno == errno.EEXIST
                else (error.strerror or str(error)).lower()
            )
            raise OutputError(f"{path} cannot be made: {what}; name another folder with --output") from None
    for name, text in texts.items():
        write_text(place / name, text)
    return place
