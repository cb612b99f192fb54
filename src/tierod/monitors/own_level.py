"""What a monitor learnt of one very vehicle, kept from recording to recording."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tierod.errors import InputError
from tierod.files import write_text

SCHEMA = "tierod.own-level/1"


@dataclass(frozen=True)
class OwnLevel:
    """A quantity of this vehicle as it was when it was sound.

    Args:
        vehicle: name of the parameter set that was used
        monitor: name of monitor and variant that learnt it; another one may measure with another bias
        value: in the unit
        deviation: its standard deviation in the unit
        unit: in the notation of pint
        seconds: enabled time that went into it [s]
        learnt: when, ISO 8601
    """

    vehicle: str
    monitor: str
    value: Annotated[float, "unit of the signal"]
    deviation: Annotated[float, "unit of the signal"]
    unit: str
    seconds: Annotated[float, "s"]
    learnt: str = ""


def load_own_level(path: str | Path) -> OwnLevel:
    """The level in a file.

    Raises:
        InputError: the file cannot be read, or is not one that tierod wrote
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
        if document.pop("schema") != SCHEMA:
            raise KeyError("schema")
        level = OwnLevel(**document)
        if not (math.isfinite(level.value) and level.value > 0.0 and level.deviation >= 0.0):
            raise ValueError(f"value {level.value} and deviation {level.deviation}")
    except OSError as error:
        raise InputError(f"{path} cannot be read ({(error.strerror or str(error)).lower()}); check the path") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"{path} is not a level that tierod stored ({error}); name another file, or remove it to learn anew"
        ) from None
    return level


def store_own_level(level: OwnLevel, path: str | Path) -> Path:
    """Write the level to a file, whole or not at all.

    Raises:
        OutputError: the file cannot be written
    """
    return write_text(path, json.dumps({"schema": SCHEMA, **dataclasses.asdict(level)}, indent=2) + "\n")


def refuse_foreign(level: OwnLevel, vehicle: str, monitor: str, path: str | Path = "the stored level") -> None:
    """Stop where a level belongs to another vehicle or another way of measuring.

    Raises:
        InputError: it does; the message names both
    """
    for what, stored, wanted in (("vehicle", level.vehicle, vehicle), ("monitor", level.monitor, monitor)):
        if stored != wanted:
            raise InputError(
                f"{path} was learnt for the {what} '{stored}', not '{wanted}'; keep one file for each, "
                "or remove it to learn anew"
            )
