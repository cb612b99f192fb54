import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal, Protocol

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE, check_ranges, numbers, replaced
from tierod.core.toml import Document, build, kind_name, override


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


def test_the_kind_may_be_left_out_where_the_default_shows_it():
    assert car("mass = 1\n[driver]\ngain = 2").driver == CruiseControl(2.0)
    assert car("mass = 1\n[driver]\nkind = 'cruise_control'").driver == CruiseControl()
    assert kind_name(CruiseControl) == "cruise-control"


def test_a_number_or_a_word():
    assert car("mass = 1\nload = '0.2 tonne'").load == pytest.approx(200.0)
    assert car("mass = 1\nuntil = inf").until == math.inf


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("mass = 1\n\nspede = 3", 3, "'spede' is not known here; did you mean 'speed'?"),
        ("speed = 1", None, "'mass' is missing; add it, in kg"),
        ("mass = 0", 1, "'mass' is 0 kg, but has to be above 0 kg"),
        ("mass = nan", 1, "finite number in kg"),
        ("mass = inf", 1, "finite number in kg"),
        ("mass = true", 1, "'mass' is true, but has to be a number in kg"),
        ("mass = '3 m'", 1, "measured in 'kg': the unit 'm' cannot become 'kg'"),
        ("mass = 'much'", 1, "'mass' is 'much', but has to be a number, in kg"),
        ("mass = 1\nspeed = '3 kmp'", 2, "the unit 'kmp' is not known"),
        ("mass = 1\nshare = 1.5", 2, "0 to 1"),
        ("mass = 1\nshare = '3 s'", 2, "has to be a number without unit"),
        ("mass = 1\ndelay_steps = 2.5", 2, "a whole number"),
        ("mass = 1\ndelay_steps = true", 2, "a whole number"),
        ("mass = 1\nautomatic = 1", 2, "true or false"),
        ("mass = 1\nname = 7", 2, "a text"),
        ("mass = 1\ndrive = 'all'", 2, "not among front, rear"),
        ("mass = 1\ncorner = [1]", 2, "has 1 elements, but needs 2"),
        ("mass = 1\ncorner = [\n1,\n'x']", 4, "'corner.1' is 'x'"),
        ("mass = 1\ncorner = 3", 2, "a list"),
        ("mass = 1\nwheel = 3", 2, "has to be a table"),
        ("mass = 1\nspares = 3", 2, "has to be a table"),
        ("mass = 1\n[wheel]\n[wheel.more]", 3, "'more' is not known here"),
        ("mass = 1\n[wheel]\npressures = [1.0,\n-2.0]", 4, "'wheel.pressures.1' is -2 Pa"),
        ("mass = 1\n[[wheels]]\n[[wheels]]\nradius = -1", 4, "'wheels.1.radius' is -1 m"),
        ("mass = 1\n[driver]\nkind = 'persn'", 3, "no kind is called 'persn'; did you mean 'person'?"),
        ("mass = 1\n[driver]\nkind = 'person'", 2, "'patience' is missing"),
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


def test_one_of_several_kinds_has_to_be_chosen():
    document = Document.parse("x = 1", "a.toml")
    with pytest.raises(ParameterError, match="choose one of: cruise-control, person"):
        build(Person | CruiseControl, {}, document)


@dataclass(frozen=True)
class Ramp:
    rate: Annotated[float, "{signal}/s"] = 0.0


def test_a_unit_that_depends_on_a_signal():
    document = Document.parse("rate = '2 deg/min'")
    assert build(Ramp, document.content, document, signal="rad").rate == pytest.approx(math.radians(2.0) / 60.0)
    with pytest.raises(ParameterError, match="no unit is known here"):
        build(Ramp, document.content, document)


@pytest.mark.parametrize(("text", "words"), [("a = ", "not valid TOML"), (None, "cannot be read")])
def test_a_file_that_is_no_toml(tmp_path, text, words):
    path = tmp_path / "a.toml"
    if text:
        path.write_text(text)
    with pytest.raises(ParameterError, match=words):
        Document.read(path)


def test_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ParameterError, match="not UTF-8"):
        Document.read(path, "course")


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=1e-9, max_value=1e9))
def test_any_number_is_read_to_the_bit(value):
    assert car(f"mass = {value!r}").mass == value
    assert car(f"mass = '{value!r} kg'").mass == value


@given(st.text("massped_ =[]{}'\"1.\n", max_size=30))
def test_any_text_gives_a_car_or_a_sentence(text):
    try:
        built = car(text)
    except ParameterError as error:
        said = str(error)
        assert said.startswith("car.toml")
    else:
        assert built.mass > 0.0


class Driver(Protocol):
    @property
    def anticipation(self): ...


@dataclass(frozen=True)
class Automatic:
    anticipation: Annotated[float, "s", POSITIVE] = 0.5


@dataclass(frozen=True)
class Bus:
    driver: Driver = field(default_factory=Automatic)


def test_override_of_a_part_that_is_declared_as_a_protocol():
    assert override(Bus(), {"driver.anticipation": "200 ms"}) == Bus(Automatic(0.2))
    with pytest.raises(ParameterError, match=r"'driver.anticipation' is -1 s, but has to be above 0 s"):
        override(Bus(), {"driver": {"anticipation": -1}})
    with pytest.raises(ParameterError, match="'driver' is 3, but has to be a table"):
        override(Bus(), {"driver": 3})


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
        ({"wheels.2.radius": 1}, "did you mean 'wheels"),
        ({"wheel.radius": -1}, "'wheel.radius' is -1 m"),
        ({"wheel": 3}, "has to be a table"),
        ({"mass": {"value": 3}}, "no parameter is called 'mass.value'"),
    ],
)
def test_a_wrong_override(changes, words):
    with pytest.raises(ParameterError, match=words):
        override(WHOLE, changes)


def test_a_wrong_override_in_a_file():
    document = Document.parse("[car]\nwheel.radius = 1\n'wheel.camer' = 2")
    with pytest.raises(ParameterError, match="text, line 3: no parameter is called 'wheel.camer'"):
        override(WHOLE, document.content["car"], document, ("car",))


def test_numbers_with_units_and_ranges():
    known = numbers(WHOLE)
    assert known["wheel.radius"] == (0.31, "m", POSITIVE)
    assert known["wheels.1.pressures.0"] == (2.3e5, "Pa", POSITIVE)
    assert known["corner.1"].value == 0.0
    assert known["spares.boot.radius"].unit == "m"
    assert known["driver.patience"].unit == "s"
    assert not {"delay_steps", "name", "automatic", "load", "wheel.camber"} & set(known)
    assert numbers(override(WHOLE, {"load": 3}))["load"] == (3.0, "kg", None)


def test_replaced_keeps_all_else():
    changed = replaced(WHOLE, {"wheels.0.radius": 1.0, "wheel.pressures.0": 2.0, "spares.boot.radius": 3.0})
    assert (changed.wheels[0].radius, changed.wheel.pressures, changed.spares["boot"].radius) == (1.0, (2.0,), 3.0)
    assert replaced(changed, {path: value for path, (value, _, _) in numbers(WHOLE).items()}) == WHOLE


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


@pytest.mark.parametrize(
    ("wheel", "words"), [(Wheel(0.0), "'radius' is 0 m, but has to be above 0 m"), (Wheel(), None)]
)
def test_ranges_are_checked_in_python_too(wheel, words):
    if words is None:
        check_ranges(wheel)
        return
    with pytest.raises(ParameterError, match=words):
        check_ranges(wheel)
