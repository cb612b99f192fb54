"""TOML files become frozen dataclasses; a slip is named with its line."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

import pytest

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.toml import Document, build, override
from tierod.core.toml_document import line_of


@dataclass(frozen=True)
class Wheel:
    radius: Annotated[float, "m", POSITIVE] = 0.3
    pressures: Annotated[tuple[float, ...], "Pa", POSITIVE] = (2.3e5,)
    camber: Annotated[float, "rad"] | None = None


@dataclass(frozen=True)
class Person:
    patience: Annotated[float, "s", NOT_NEGATIVE]
    hands: Annotated[int, "", NOT_NEGATIVE] = 2


@dataclass(frozen=True)
class CruiseControl:
    gain: Annotated[float, ""] = 0.5

    def __post_init__(self):
        if self.gain == 13.0:
            raise ParameterError("a gain of 13 brings bad luck; give another")


@dataclass(frozen=True)
class Car:
    mass: Annotated[float, "kg", POSITIVE]
    speed: Annotated[float, "m/s"] = 0.0
    share: Annotated[float, "", SHARE] = 0.5
    until: Annotated[float, "s"] = math.inf
    delay_steps: int = 3
    name: str = "car"
    automatic: bool = False
    drive: Literal["front", "rear"] = "front"
    wheel: Wheel = field(default_factory=lambda: Wheel(0.31))
    driver: Person | CruiseControl = field(default_factory=CruiseControl)
    wheels: tuple[Wheel, ...] = ()
    corner: tuple[float, float] = (0.0, 0.0)
    spares: Mapping[str, Wheel] = field(default_factory=dict)
    load: Annotated[float, "kg"] | Literal["full"] | None = None


def car(text):
    document = Document.parse(text, "car.toml")
    return build(Car, document.content, document)


def test_defaults_units_and_every_type():
    built = car("""
        mass = 1600
        speed = "72 km/h"
        share = "30 %"
        delay_steps = 4
        name = "mine"
        automatic = true
        drive = "rear"
        corner = [1, 2.5]
        load = "full"
        wheel = { camber = "-1 deg", pressures = ["2.2 bar", 2.4e5] }
        [driver]
        kind = "person"
        patience = "250 ms"
        [[wheels]]
        radius = "300 mm"
        [[wheels]]
        [spares.boot]
        radius = 0.29
    """)
    assert built.mass == 1600.0
    assert isinstance(built.mass, float)
    assert built.speed == pytest.approx(20.0)
    assert built.share == pytest.approx(0.3)
    assert (built.delay_steps, built.name, built.automatic, built.drive) == (4, "mine", True, "rear")
    assert built.corner == (1.0, 2.5)
    assert built.load == "full"
    assert built.wheel.radius == 0.31, "what a table leaves out stays as the default of the field has it"
    assert built.wheel.camber == pytest.approx(-math.pi / 180.0)
    assert built.wheel.pressures == pytest.approx((2.2e5, 2.4e5))
    assert built.driver == Person(0.25)
    assert built.wheels == (Wheel(0.3), Wheel())
    assert built.spares == {"boot": Wheel(0.29)}
    assert built.until == math.inf


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("mass = 1\n\nspede = 3", 3, "'spede' is not known here; did you mean 'speed'?"),
        ("speed = 1", None, "'mass' is missing; add it, in kg"),
        ("mass = 0", 1, "'mass' is 0 kg, but has to be above 0 kg"),
        ("mass = nan", 1, "finite number in kg"),
        ("mass = true", 1, "'mass' is true, but has to be a number in kg"),
        ("mass = '3 m'", 1, "measured in 'kg': the unit 'm' cannot become 'kg'"),
        ("mass = 'much'", 1, "'mass' is 'much', but has to be a number, in kg"),
        ("mass = 1\nspeed = '3 kmp'", 2, "the unit 'kmp' is not known"),
        ("mass = 1\nshare = 1.5", 2, "0 to 1"),
        ("mass = 1\ndelay_steps = 2.5", 2, "a whole number"),
        ("mass = 1\ndrive = 'all'", 2, "not among front, rear"),
        ("mass = 1\ncorner = [1]", 2, "has 1 elements, but needs 2"),
        ("mass = 1\ncorner = [\n1,\n'x']", 4, "'corner.1' is 'x'"),
        ("mass = 1\n[wheel]\n[wheel.more]", 3, "'more' is not known here"),
        ("mass = 1\n[wheel]\npressures = [1.0,\n-2.0]", 4, "'wheel.pressures.1' is -2 Pa"),
        ("mass = 1\n[driver]\nkind = 'persn'", 3, "no kind is called 'persn'; did you mean 'person'?"),
        ("mass = 1\n[driver]\nkind = 'person'\npatience = 1\nhands = -1", 5, "at least 0"),
        ("mass = 1\n[driver]\ngain = 13", 2, "bad luck"),
        ("mass = 1\nload = 'empty'", 2, "'load' is 'empty', which is not among full"),
    ],
)
def test_a_slip_is_named_with_its_line(text, line, words):
    with pytest.raises(ParameterError) as caught:
        car(text)
    assert words in str(caught.value)
    assert str(caught.value).startswith("car.toml, line " + str(line) if line else "car.toml: ")


@pytest.mark.parametrize(("text", "words"), [("a = ", "not valid TOML"), (None, "cannot be read")])
def test_a_file_that_is_no_toml(tmp_path, text, words):
    path = tmp_path / "a.toml"
    if text:
        path.write_text(text)
    with pytest.raises(ParameterError, match=words):
        Document.read(path)


WHOLE = Car(1500.0, wheels=(Wheel(0.3), Wheel(0.4)), driver=Person(1.0), spares={"boot": Wheel()})


def test_override_by_dotted_path_and_by_tables():
    changed = override(WHOLE, {"wheel.radius": "290 mm", "driver": {"patience": 2}, "wheels.1.radius": 0.5, "mass": 9})
    assert (changed.wheel.radius, changed.driver.patience, changed.mass) == (0.29, 2.0, 9.0)
    assert [wheel.radius for wheel in changed.wheels] == [0.3, 0.5]
    assert override(WHOLE, {"delay_steps": 7, "wheel.camber": "2 deg"}).wheel.camber == pytest.approx(math.radians(2))
    assert override(WHOLE, {"driver": {"kind": "cruise-control", "gain": 3}}).driver == CruiseControl(3.0)
    assert override(WHOLE, {}) == WHOLE


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"radius": 1}, "no parameter is called 'radius'; did you mean"),
        ({"wheel.raduis": 1}, "did you mean 'wheel.radius'"),
        ({"mass": {"value": 3}}, "no parameter is called 'mass.value'"),
    ],
)
def test_a_wrong_override(changes, words):
    with pytest.raises(ParameterError, match=words):
        override(WHOLE, changes)


@dataclass(frozen=True)
class Shift:
    size: Annotated[float | str, "{signal}", NOT_NEGATIVE]
    limit: Annotated[float | str, "{signal}"] | None = None


def test_an_amount_stays_a_text_until_its_signal_is_known():
    document = Document.parse("size = '2 deg'\nlimit = '1 m'", "a.toml")
    raw = build(Shift, document.content, document)
    assert raw == Shift("2 deg", "1 m")
    assert build(Shift, {"size": raw.size}, document, signal="rad").size == pytest.approx(math.radians(2.0))
    with pytest.raises(ParameterError, match=r"a.toml, line 2: 'limit' is '1 m', but is measured in 'rad'"):
        build(Shift, document.content, document, signal="rad")
    with pytest.raises(ParameterError, match="'size' is 'much', but has to be a number"):
        build(Shift, {"size": "much"}, document)
    with pytest.raises(ParameterError, match="'size' is -2 rad, but has to be at least 0 rad"):
        build(Shift, {"size": "-2 rad"}, document, signal="rad")
    assert build(Shift, {"size": 3}, document) == Shift(3.0)


MANY = '''\
text = """
[not.a.table]
key = 1
"""
numbers = [
  1.0,  # [comment]
  { low = 2, high = [3,
    4] },
]

[[faults]]
element = "yaw_rate"
[faults.trigger]
at = 1979-05-27 07:32:00

[[faults]]
element = 'a = "b"'
trigger.at = 2.0

[[faults.parts]]
size = 1
[[faults.parts]]
size = 2
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("text",), 1),
        (("not", "a", "table"), None),
        (("numbers", 0), 6),
        (("numbers", 1, "high", 1), 8),
        (("faults", 0, "element"), 12),
        (("faults", 0, "trigger", "at"), 14),
        (("faults", 1, "element"), 17),
        (("faults", 1, "parts", 1, "size"), 23),
        (("faults", 1, "parts.1.size"), 23),
    ],
)
def test_knows_arrays_inline_tables_and_strings_of_several_lines(path, line):
    tomllib.loads(MANY)
    assert line_of(MANY, path) == line
