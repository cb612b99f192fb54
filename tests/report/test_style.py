"""Colours of the pages: contrast in light and dark, one home, and no name that the style lacks."""

import re

import pytest

from diagnosis_examples import friction_fault
from tierod.report.glossary import Glossary, explanation
from tierod.report.html import TEMPLATES
from tierod.report.plot import plot

TOKENS = (TEMPLATES / "tokens.css").read_text(encoding="utf-8")
COLOURS = {
    name: {"light": light, "dark": dark}
    for name, light, dark in re.findall(r"(--[a-z-]+): var\(--light, (#\w{6})\) var\(--dark, (#\w{6})\);", TOKENS)
}
TEXT = [
    *((f"--{name}", ground) for name in ("ink", "muted", "accent") for ground in ("--paper", "--ground")),
    *((f"--{kind}", ground) for kind in ("good", "warn", "bad", "open") for ground in ("--paper", f"--{kind}-tint")),
    *(("--on-kind", f"--{kind}") for kind in ("good", "warn", "bad", "open")),
    *(("--ink", f"--{kind}-tint") for kind in ("good", "warn", "bad", "open")),
]


def luminance(colour):
    parts = (int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5))
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize(("text", "ground"), TEXT)
def test_text_can_be_read_on_its_ground(text, ground, theme):
    """Contrast of at least 4.5 to 1, as WCAG 2.1 asks for (1.4.3)."""
    low, high = sorted(luminance(COLOURS[name][theme]) for name in (text, ground))
    assert (high + 0.05) / (low + 0.05) >= 4.5


def test_every_colour_that_is_named_is_in_the_style():
    known = set(re.findall(r"^  (--[a-z-]+):", TOKENS, re.MULTILINE)) | {"--kind", "--tint", "--light", "--dark"}
    places = [*TEMPLATES.parent.rglob("*.py"), *TEMPLATES.glob("*.css"), *TEMPLATES.glob("*.js")]
    named = {name for path in places for name in re.findall(r"var\((--[a-z-]+)", path.read_text(encoding="utf-8"))}
    assert len(named) > 20
    assert named <= known


def test_colours_stand_in_one_place():
    for path in [*TEMPLATES.parent.rglob("*.py"), TEMPLATES / "report.css"]:
        assert re.findall(r"#[0-9a-f]{6}\b", path.read_text(encoding="utf-8")) == [], path


def test_a_plot_for_a_notebook_has_the_colours_of_the_light_page():
    figure = plot(friction_fault(bins=50))
    assert "var(" not in figure.to_json()
    assert figure.layout.paper_bgcolor == COLOURS["--paper"]["light"]


def test_words_are_explained_with_their_sign_and_the_unit_of_the_page():
    name, meaning = explanation("Yaw rate [°/s]")
    assert name == "Yaw rate"
    assert "Positive: " in meaning
    assert meaning.endswith("Shown in °/s.")
    assert "axle" in explanation("Front cornering stiffness")[1]
    assert explanation("no such word") is None


def test_a_word_is_reached_by_the_keyboard_once_and_a_hostile_one_stays_text():
    glossary = Glossary()
    first, second = str(glossary.link("Yaw rate")), str(glossary.link("yaw rate"))
    assert "tabindex" not in first
    assert 'tabindex="-1"' in second
    assert list(glossary.found) == ["word-yaw-rate"]
    assert str(glossary.link("<b>")) == "&lt;b&gt;"
    assert 'href="#word-fault"' in str(glossary.status("fault"))
    assert str(glossary.link("Fault")) == "Fault"
