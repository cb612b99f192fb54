"""Units of files: values are converted to SI once, on reading.

The notations of vehicle recordings are in a table, so that common units need no unit library; pint reads all others.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache, lru_cache
from math import isfinite, pi
from typing import Any

from tierod.core.errors import InputError, nearest

COUNT = "count"  # Unit of a raw value that is not calibrated


@dataclass(frozen=True)
class Scale:
    """Conversion of a unit: value in the wanted unit = factor * value as given + offset."""

    factor: float
    offset: float = 0.0

    def __call__(self, values: Any) -> Any:
        if self.factor == 1.0 and self.offset == 0.0:
            return values
        return values * self.factor + self.offset if self.offset else values * self.factor


_SPELLINGS = {
    "rad": "rad radian radians",
    "deg": "deg degree degrees grad ° º unit_degreofarc",
    "rad/s": "rad/s rad/sec rads rad/seconds radps rad*s-1 rad*s^-1",
    "deg/s": "deg/s degree/s degrees/s deg/sec degps dps °/s º/s grad/s deg/seconds unit_degreofarcpersecon",
    "rad/s**2": "rad/s2 rad/s^2 rad/s²",
    "deg/s**2": "deg/s2 deg/s^2 deg/s² °/s2 °/s² º/s2 º/s²",
    "m/s": "m/s mps m/sec metres/s meter/second meters/second metres/second m*s-1 unit_meterpersecon",
    "km/h": "km/h kmh kph kmph kmperhour km/hr unit_kilometerperhour",
    "mph": "mph mi/h miles/h",
    "m/s**2": "m/s2 m/s^2 m/s² m/ss m/s/s mps2 m/sec2 m/sec^2 m*s-2 unit_meterperseconsquar",
    "g_0": "unit_forceofgravi",
    "N*m": "nm n*m n.m n·m newtonmeter newton-meter nmeter unit_newtometer",
    "N": "n newton newtons",
    "rpm": "rpm 1/min u/min rev/min r/min min-1 /min",
    "revolution": "rev revolution revolutions turn turns",
    "degC": "degc °c ºc celsius deg_c c",
    "degF": "degf °f fahrenheit deg_f",
    "K": "k kelvin",
    "": "- 1 unitless none [] -- n/a na nounit enum flag bool dimensionless",
    "percent": "% percent pct unit_perce",
    COUNT: "count counts raw lsb inc incs digit digits bit bits cnt ticks tick increments",
    "V": "v volt volts unit_volt",
    "A": "a amp amps ampere",
    "mA": "ma",
    "s": "s sec second seconds unixtime",
    "ms": "ms msec millisecond milliseconds",
    "us": "us usec µs μs microsecond microseconds",
    "ns": "ns nsec nanosecond nanoseconds",
    "bar": "bar",
    "m": "m meter metre",
    "mm": "mm millimeter",
    "hour": "h hour hours",
}

_TIDY = {word: unit for unit, words in _SPELLINGS.items() for word in words.split()} | {"": ""}

_SUFFIXES = {
    "_rad_s2": "rad/s**2", "_deg_s2": "deg/s**2", "_m_s2": "m/s**2", "_mps2": "m/s**2",
    "_rad_s": "rad/s", "_deg_s": "deg/s", "_dps": "deg/s", "_m_s": "m/s", "_mps": "m/s",
    "_km_h": "km/h", "_kmh": "km/h", "_kph": "km/h", "_mph": "mph", "_rpm": "rpm",
    "_rad": "rad", "_deg": "deg", "_nm": "N*m", "_kn": "kN", "_bar": "bar", "_volt": "V",
    "_sec": "s", "_seconds": "s", "_ms": "ms", "_us": "us", "_ns": "ns", "_s": "s", "_count": COUNT, "_counts": COUNT,
}  # fmt: skip

_SCALES = {
    ("deg", "rad"): Scale(pi / 180.0),
    ("deg/s", "rad/s"): Scale(pi / 180.0),
    ("deg/s**2", "rad/s**2"): Scale(pi / 180.0),
    ("rpm", "rad/s"): Scale(pi / 30.0),
    ("revolution", "rad"): Scale(2.0 * pi),
    ("km/h", "m/s"): Scale(1.0 / 3.6),
    ("bar", "Pa"): Scale(1.0e5),
    ("degC", "K"): Scale(1.0, 273.15),
    ("rad", ""): Scale(1.0),
    ("percent", ""): Scale(0.01),
    ("ms", "s"): Scale(1.0e-3),
    ("us", "s"): Scale(1.0e-6),
    ("ns", "s"): Scale(1.0e-9),
    ("mm", "m"): Scale(1.0e-3),
    ("g_0", "m/s**2"): Scale(9.80665),
}


_SI = frozenset(
    {"rad", "rad/s", "rad/s**2", "m", "m/s", "m/s**2", "N", "N*m", "A", "V", "K", "Pa", "s", "g_0", COUNT, ""}
)

# SI unit of the quantity of each unit that needs no unit library; of different ones only rad and "" can be converted
_QUANTITIES = {unit: unit for unit in _SI - {COUNT}} | {given: wanted for given, wanted in _SCALES if wanted}

LONGEST = 80  # Largest number of characters of a unit: a longer text is no unit, and would take long to parse

_LONGEST_TITLE = 1000

_WRITTEN = "write it as deg/s, N*m or m/s**2 are written"

_TOKEN = re.compile(r"(?P<power>\*\*|\^)|(?P<number>\d+\.?\d*|\.\d+)|(?P<word>[^\W\d]\w*|[%°µΩ])|(?P<mark>[-+*/·() ])")
# Exponent of one digit, with a sign, with a decimal, or as a fraction: V/Hz**0.5, J/K**(1/2)
_EXPONENT = re.compile(r"\s*[-+]?\d(?:\.\d+)?(?![\w.^]|\s*\*\*)|\([-+]?\d(?:/\d)?\)(?![\w.^]|\s*\*\*)")


@lru_cache(maxsize=512)
def tidy(text: str, wanted: str = "") -> str:
    """A unit as a file writes it, converted to the notation of pint.

    Args:
        text: for example "°/s", "Nm", "KM/H", "[m/s^2]"
        wanted: the unit to convert to; for an acceleration "g" means standard gravity
    """
    if len(text) > LONGEST:
        raise InputError(f"the unit '{text[:LONGEST]}...' has {len(text)} characters; {_WRITTEN}")
    bare = _unwrapped(text)
    if wanted == "m/s**2" and bare.lower() in ("g", "gs", "g0", "g_0", "gn"):
        return "g_0"
    found = _TIDY.get(re.sub(r"\s+", "", bare).lower().replace("**", "^"), _TIDY.get(bare.lower()))
    if found is not None:
        return found
    if bare in _SI:
        return bare
    return _by_pint(bare)


def _unwrapped(text: str) -> str:
    """A unit without enclosing brackets; those of "1/(N*m)" belong to the unit."""
    outer = text.strip().strip("[]").strip()
    inner = outer.strip("()").strip()
    return outer if "(" in inner else inner


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)


def _is_plain(bare: str) -> bool:
    """Whether a text is words with small exponents, joined by signs: towers of powers would keep pint busy forever."""
    place, depth, before = 0, 0, ""
    while place < len(bare):
        token = _TOKEN.match(bare, place)
        if token is None or len(token[0]) > 24 or (token.lastgroup == "number" and len(token[0]) > 6):
            return False
        place = token.end()
        depth += {"(": 1, ")": -1}.get(token[0], 0)
        if not 0 <= depth <= 3:
            return False
        if token.lastgroup == "power":
            exponent = _EXPONENT.match(bare, place)
            if exponent is None or not (before == "word" or before == ")"):
                return False
            place = exponent.end()
        if token[0] != " ":
            before = token[0] if token.lastgroup == "mark" else token.lastgroup or ""
    return depth == 0


def _by_pint(bare: str) -> str:
    spelled = bare.replace("²", "**2").replace("³", "**3").replace("°", "deg").replace("·", "*").replace("^", "**")
    # Without the sign pint reads the N of "kNm" as a number of things, not as newton.
    spelled = re.sub(r"\b([mkM]?N)([cm]?m)\b", r"\1*\2", spelled)
    for candidate in (spelled, spelled.lower()) if _is_plain(spelled) else ():
        try:
            _registry().parse_units(candidate)
            return candidate
        except Exception:  # for a text that is no unit, pint passes on whatever its tokenizer and evaluator raise
            continue
    known = [word for words in _SPELLINGS.values() for word in words.split()]
    raise InputError(f"the unit '{bare}' is not known; {_WRITTEN}{nearest(bare, known)}")


def known(text: str) -> bool:
    try:
        tidy(text)
    except InputError:
        return False
    return True


def scale(given: str, wanted: str) -> Scale:
    return _scale(tidy(given, wanted), tidy(wanted))


@lru_cache(maxsize=512)
def _scale(given: str, wanted: str) -> Scale:
    if given == wanted:
        return Scale(1.0)
    if (given, wanted) in _SCALES:
        return _SCALES[given, wanted]
    if (wanted, given) in _SCALES:
        inverse = _SCALES[wanted, given]
        return Scale(1.0 / inverse.factor, -inverse.offset / inverse.factor)
    if given.lower() in ("hz", "hertz", "khz") and wanted.startswith("rad"):
        raise InputError(f"'{given}' may count turns or radians per second; write rpm or rad/s in a channel map")
    if COUNT in (given, wanted):
        raise InputError(
            f"a raw count has no known size in '{wanted if given == COUNT else given}'; "
            "keep it as count, or give the factor in the channel map"
        )
    quantities = {_QUANTITIES.get(unit) for unit in (given, wanted)}
    apart = len(quantities) == 2 and None not in quantities and quantities != {"rad", ""}
    found = None if apart else _scale_by_pint(given, wanted)
    if found is None:
        raise InputError(f"the unit '{given}' cannot become '{wanted}': they are units of different quantities")
    return found


def _scale_by_pint(given: str, wanted: str) -> Scale | None:
    """The scale; None between units of different quantities."""
    import pint

    quantity = _registry().Quantity
    try:
        at_zero, at_one, at_two = (float(quantity(value, given).to(wanted).magnitude) for value in (0.0, 1.0, 2.0))
    except pint.errors.DimensionalityError:
        return None
    except Exception:  # pint fails in many ways at units that it has parsed, such as dB*m
        raise InputError(f"the unit '{given}' has no fixed size in '{wanted}'; {_CONVERTED}") from None
    factor = at_one - at_zero
    if not (isfinite(at_zero) and isfinite(factor) and factor):
        raise InputError(f"the unit '{given}' has no finite size in '{wanted}'; {_CONVERTED}")
    if abs(at_two - at_one - factor) > 1e-6 * abs(factor):
        raise InputError(f"the unit '{given}' is logarithmic, and no factor converts it to '{wanted}'; {_CONVERTED}")
    return Scale(factor, at_zero)


@dataclass(frozen=True)
class Dimensions:
    """A unit in terms of SI base units and the radian: value in these = factor * value."""

    factor: float
    exponents: dict[str, int]  # exponents by symbol: kg, m, s, A, K, mol, cd, rad


_SYMBOLS = {
    "kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "mole": "mol", "candela": "cd",
    "radian": "rad",
}  # fmt: skip


@lru_cache(maxsize=512)
def dimensions(text: str) -> Dimensions:
    """Dimensions of a unit without an offset.

    Args:
        text: in any notation; "" for a number without unit
    """
    if not text:
        return Dimensions(1.0, {})
    unit = tidy(text)
    scale_ = None if unit == COUNT else _registry().get_base_units(unit)
    exponents = {} if scale_ is None else dict(scale_[1]._units)
    if (
        scale_ is None
        or scale(unit, str(scale_[1])).offset
        or any(name not in _SYMBOLS or power != int(power) for name, power in exponents.items())
    ):
        raise InputError(f"the unit '{text}' is not a product of whole powers of SI units; {_CONVERTED}")
    return Dimensions(float(scale_[0]), {_SYMBOLS[name]: int(power) for name, power in exponents.items()})


_CONVERTED = "convert the values first, or write another unit"


def split_name(name: str) -> tuple[str, str]:
    """The name and the unit in brackets that a column title holds: "Speed [km/h]", "time (ms)".

    Returns:
        (name without the unit, unit as written); the unit is "" where the title holds none
    """
    # The time of the search grows with the square of the length, so that a title of any length is not searched.
    found = re.match(r"^(.*?)\s*([\[(<])([^\[\]()<>]*)[\])>]\s*$", name) if len(name) <= _LONGEST_TITLE else None
    if found and found[1] and (found[2] == "[" or known(found[3])):
        return found[1].strip(), found[3].strip()
    return name.strip(), ""


def split_suffix(name: str) -> tuple[str, str]:
    """The name and the unit of its suffix: "speed_m_s" gives ("speed", "m/s"); without one, the unit is ""."""
    lowered = name.lower()
    for suffix, unit in _SUFFIXES.items():
        if lowered.endswith(suffix) and len(lowered) > len(suffix):
            return name[: -len(suffix)], unit
    return name, ""
