"""Plant file of a functional mock-up unit: which of its variables are which signals, with units and signs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import InputError, MissingExtra, nearest
from tierod.core.fields import Range
from tierod.core.toml import Document, Location, build
from tierod.core.units import scale

USUAL_STEP = 1e-3
"""Communication step if neither plant file nor unit states one [s]."""


@dataclass(frozen=True)
class Entry:
    """The signal in `unit` (of the description if None, SI if it has none) is sign * variable."""

    variable: str = ""
    signal: str = ""
    unit: str | None = None
    sign: float = 1.0


@dataclass(frozen=True)
class PlantFile:
    """Content of a plant file.

    Args:
        start_speed: parameter that is the initial speed, or an entry; None keeps the unit's own initial speed
        step: communication step, within what the driver model tolerates; that of the unit's description if None
    """

    fmu: str
    inputs: Mapping[str, Any]
    outputs: Mapping[str, Any]
    values: Mapping[str, float] = field(default_factory=dict)
    start_speed: Any = None
    step: Annotated[float, "s", Range(1e-5, 2e-2)] | None = None


class Wire(NamedTuple):
    """A variable and its signal: signal [SI] = gain * variable + offset."""

    reference: int
    signal: str
    unit: str
    gain: float
    offset: float


def described(path: Path) -> Any:
    """Description of a unit by fmpy.

    Raises:
        InputError: fmpy cannot read the unit, or it is not for co-simulation by FMI 2 on this platform
        MissingExtra: fmpy is not installed
    """
    try:
        import fmpy
    except ImportError:
        raise MissingExtra("fmpy", "fmi", "a functional mock-up unit as plant") from None
    if not path.is_file():
        raise InputError(f"there is no file {path}; name a functional mock-up unit (.fmu)")
    try:
        found: Any = fmpy.read_model_description(str(path), validate=False)
        platforms = set(fmpy.supported_platforms(str(path)))
    except Exception as error:  # fmpy and lxml raise many kinds of errors for a damaged file
        raise InputError(f"{path} is not a unit that fmpy can read ({first_line(error)}); export it anew") from None
    if found.fmiVersion != "2.0" or found.coSimulation is None or fmpy.platform not in platforms:
        held = f"FMI {found.fmiVersion} for {', '.join(sorted(platforms)) or 'no platform'}"
        raise InputError(f"{path} is a unit of {held}; export it for co-simulation by FMI 2.0 on {fmpy.platform}")
    return found


def first_line(error: BaseException) -> str:
    """First line of an error's message; the name of its class where it has none."""
    return next(iter(str(error).splitlines()), "") or type(error).__name__


class Variables(NamedTuple):
    """Variables of a unit, to which entries of the plant file refer; `assumed` lists those without a unit."""

    document: Document
    variables: Mapping[str, Any]
    assumed: list[str]

    def reference(self, location: Location, name: str, causality: str) -> int:
        """Value reference of a number of one causality."""
        known = {key for key, each in self.variables.items() if each.causality == causality and each.type == "Real"}
        if name not in known:
            raise self.document.error(location, f"the unit has no {causality} '{name}'{nearest(name, known)}")
        return int(self.variables[name].valueReference)

    def wire(self, location: Location, causality: str, given: object, known: Mapping[str, str | None]) -> Wire:
        """The wire of an entry; `known` has the unit of every signal that fits."""
        short = "signal" if causality == "input" else "variable"
        entry: Entry = build(Entry, {short: given} if isinstance(given, str) else given, self.document, location)
        name = str(location[-1])
        variable, signal = (name, entry.signal) if causality == "input" else (entry.variable, name)
        if signal not in known:
            raise self.document.error(location, f"no signal here is called '{signal}'{nearest(signal, known)}")
        reference, about = self.reference(location, variable, causality), self.variables[variable]
        stated = entry.unit or about.unit or getattr(about.declaredType, "unit", None) or ""
        wanted = known[signal] or stated
        if entry.sign not in (1.0, -1.0):
            raise self.document.error(location, "'sign' has to be 1 or -1")
        try:
            size = scale(stated or wanted, wanted)
        except InputError as error:
            raise self.document.error(location, f"'{variable}': {error}") from None
        self.assumed.extend([f"{variable} [{wanted}]"] if wanted and not stated else [])
        return Wire(reference, signal, wanted, size.factor * entry.sign, size.offset)
