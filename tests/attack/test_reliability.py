"""The figures of the whole attack: what passes, and what the page shows."""

import copy

import pytest

from attack import reliability
from attack.targets import READERS, TARGETS

TARGET = {
    "cases": 9, "codes": {"0": 4, "2": 1, "3": 4}, "failed": {}, "unrepeated": 0, "slowest": 0.5, "largest": 1e6,
    "classes": {},
}  # fmt: skip
FIGURES = {
    "date": "2026-11-21", "machine": "Linux", "seed": 1, "corpus": {"cases": 3, "failed": []},
    "targets": dict.fromkeys(TARGETS, TARGET),
    "others": {"kills": {"diagnose": {"kills": 5, "broken": 0}}, "signals": {"cases": 7, "failed": {}}},
}  # fmt: skip


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("corpus", "failed"), ["one"]),
        (("targets", "csv", "failed"), {"crash": 1}),
        (("others", "kills", "diagnose", "broken"), 1),
        (("others", "signals", "failed"), {"one": "why"}),
    ],
)
def test_one_failure_anywhere_counts(place, value):
    assert reliability.passed(FIGURES)
    figures = copy.deepcopy(FIGURES)
    table = figures
    for name in place[:-1]:
        table = table[name]
    table[place[-1]] = value
    assert not reliability.passed(figures)


def test_the_page_shows_the_latest_figures_and_keeps_its_text(tmp_path, monkeypatch):
    page = tmp_path / "reliability.md"
    page.write_text(f"before\n{reliability.MARKS[0]}old\n{reliability.MARKS[1]}after\n")
    monkeypatch.setattr(reliability, "PAGE", page)
    monkeypatch.setattr(reliability, "FIGURES", tmp_path / "attack.json")
    for _ in range(2):
        reliability.write(FIGURES)
    text = page.read_text()
    assert text.startswith("before\n<!--")
    assert text.endswith("-->\nafter\n")
    assert "old" not in text
    assert text.count("| csv | 9 | 5 | 4 | 0 |") == 1
    assert f"{9 * len(READERS)} damaged recordings in {len(READERS)} formats, of which 0 failed" in text


def test_the_page_has_its_marks():
    text = reliability.PAGE.read_text(encoding="utf-8")
    assert all(text.count(mark) == 1 for mark in reliability.MARKS)
