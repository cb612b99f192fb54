"""Description of a functional mock-up unit, and checks that it can run on this machine."""

from __future__ import annotations

import math
import re
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, MissingExtra
from tierod.core.fields import ANY, Range
from tierod.core.files import expanded, sha256_of

LARGEST = 2_000_000_000
"""Maximum unpacked size of a unit [bytes]."""

DESCRIPTION = "modelDescription.xml"

NUMBERS = ("Real", "Float64")
"""Types of the variables that can be exchanged."""


@dataclass(frozen=True)
class Variable:
    """A variable of a unit.

    Args:
        name: name in the unit
        reference: value reference
        causality: "input", "output", "parameter", "local", "independent"
        variability: "continuous", "discrete", "tunable", "fixed", "constant"
        is_number: whether it is a scalar of 64 bits, which can be exchanged
        unit: unit of measurement as written in the description; "" if there is none
        meaning: description
        start: value before the first step; NaN if there is none
        limits: range according to the description
    """

    name: str
    reference: int
    causality: str
    variability: str
    is_number: bool
    unit: str = ""
    meaning: str = ""
    start: float = math.nan
    limits: Range = ANY


@dataclass(frozen=True)
class Unit:
    """A unit according to its description.

    Args:
        path: path of the file
        digest: SHA-256 of the file
        name: name of the model
        version: version of the standard, 2 or 3
        identifier: model identifier of the binary
        token: GUID or instantiation token
        step: recommended communication step [s]; NaN if there is none
        fixed: whether it accepts no other step
        variables: variables by name
        depends: names of the inputs on which an output depends directly, by output; without outputs whose dependencies
            are unknown
    """

    path: Path
    digest: str
    name: str
    version: int
    identifier: str
    token: str
    step: float
    fixed: bool
    variables: Mapping[str, Variable]
    depends: Mapping[str, frozenset[str]]

    def of(self, causality: str) -> dict[str, Variable]:
        """Variables of one causality."""
        return {name: each for name, each in self.variables.items() if each.causality == causality}


def read_unit(path: str | Path) -> Unit:
    """Description of a unit.

    Args:
        path: path of the file (.fmu)

    Raises:
        InputError: not a unit, a unit for another platform, without co-simulation, or of FMI 1
        MissingExtra: fmpy is not installed
    """
    file = expanded(path)
    _require_version(file, _require_archive(file))
    try:
        import fmpy
    except ImportError:
        raise MissingExtra("fmpy", "fmi", "a functional mock-up unit as plant") from None
    try:
        described: Any = fmpy.read_model_description(str(file), validate=False)
        platforms = list(fmpy.supported_platforms(str(file)))
    except Exception as error:  # fmpy and lxml raise many kinds of errors for a damaged description
        raise InputError(f"{file} has no description that can be read ({first_line(error)}); export it anew") from None
    version, own = str(described.fmiVersion), described.coSimulation
    if own is None:
        raise InputError(f"{file} is for model exchange alone; export it for co-simulation, with its own solver")
    _require_platform(file, platforms, int(version[0]))
    return _unit(file, described, own, int(version[0]))


_VERSION = re.compile(rb"""<fmiModelDescription[^>]*?\sfmiVersion\s*=\s*["']([^"']*)["']""")


def _require_version(file: Path, description: bytes) -> None:
    """Reject other versions of FMI before the description is read by the rules of version 2 or 3."""
    found = _VERSION.search(description)
    version = found[1].decode(errors="replace") if found else ""
    if found and version[:1] not in ("2", "3"):
        raise InputError(f"{file} is a unit of FMI {version}, and only 2 and 3 can be run; export it as one of these")


def _require_archive(file: Path) -> bytes:
    """Model description in an archive that has been checked for integrity and size."""
    if not file.is_file():
        raise InputError(f"there is no file {file}; name a functional mock-up unit (.fmu)")
    try:
        with zipfile.ZipFile(file) as archive:
            size = sum(each.file_size for each in archive.infolist())
            described = archive.read(DESCRIPTION) if DESCRIPTION in archive.namelist() else None
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, NotImplementedError, RuntimeError) as error:
        raise InputError(f"{file} is not a functional mock-up unit: {first_line(error)}; export it anew") from None
    if described is None:
        raise InputError(f"{file} is not a functional mock-up unit: it has no modelDescription.xml; export it anew")
    if size > LARGEST:
        raise InputError(f"{file} would unpack to {size / 1e9:.1f} GB, more than the {LARGEST / 1e9:g} GB allowed")
    return described


def _require_platform(file: Path, platforms: list[str], version: int) -> None:
    import fmpy

    wanted = str(fmpy.platform_tuple if version == 3 else fmpy.platform)
    if not {wanted, str(fmpy.platform)} & set(platforms):
        found = [each for each in platforms if each != "c-code"]
        held = f"binaries for {', '.join(found)}" if found else "no binary"
        raise InputError(f"{file} holds {held} and none for this platform, {wanted}; export it for this one")


def _unit(file: Path, described: Any, own: Any, version: int) -> Unit:
    step = own.fixedInternalStepSize
    if step is None and described.defaultExperiment is not None:
        step = described.defaultExperiment.stepSize
    return Unit(
        path=file,
        digest=sha256_of(file),
        name=str(described.modelName),
        version=version,
        identifier=str(own.modelIdentifier),
        token=str(described.guid),
        step=math.nan if step is None else float(step),
        fixed=not own.canHandleVariableCommunicationStepSize,
        variables={str(each.name): _variable(each) for each in described.modelVariables},
        depends={
            str(each.variable.name): frozenset(str(one.name) for one in each.dependencies)
            for each in described.outputs
            if each.dependencies is not None
        },
    )


def _variable(each: Any) -> Variable:
    declared = each.declaredType
    number = each.type in NUMBERS and not each.dimensions

    def stated(name: str) -> Any:
        value = getattr(each, name)
        return getattr(declared, name, None) if value is None and declared is not None else value

    return Variable(
        name=str(each.name),
        reference=int(each.valueReference),
        causality=str(each.causality or "local"),
        variability=str(each.variability or "continuous"),
        is_number=number,
        unit=str(stated("unit") or "") if number else "",
        meaning=str(each.description or ""),
        start=_float(each.start) if number else math.nan,
        limits=Range(_float(stated("min"), -math.inf), _float(stated("max"), math.inf)) if number else ANY,
    )


def _float(text: object, otherwise: float = math.nan) -> float:
    try:
        return otherwise if text is None else float(str(text))
    except ValueError:
        return otherwise


def first_line(error: BaseException) -> str:
    """First line of an error's message; the name of its class where it has none."""
    return next(iter(str(error).splitlines()), "") or type(error).__name__
