"""Kept findings of many recordings: a change of structure changes no word and no figure of them."""

from __future__ import annotations

import pytest

from golden.findings import FOLDER, differences, text_of
from golden.recordings import KEPT


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.txt")))
def test_findings_are_what_they_were(name, tmp_path):
    kept = (FOLDER / f"{name}.txt").read_text(encoding="utf-8")
    found = text_of(KEPT[name], tmp_path)
    assert not differences(kept, found), "\n".join(differences(kept, found))


def test_a_changed_word_or_figure_is_a_difference():
    kept = "findings[0].status: healthy\nfindings[0].headline: Friction 2.58 ± 0.19 N·m\n"
    assert not differences(kept, kept.replace("2.58", "2.59"))
    assert differences(kept, kept.replace("2.58", "2.63"))
    assert differences(kept, kept.replace("healthy", "fault"))
    assert differences(kept, kept + "exit 1\n")


def test_no_kept_headline_has_more_than_twelve_words():
    texts = [path.read_text(encoding="utf-8") for path in FOLDER.glob("*.txt")]
    headlines = [line.partition(": ")[2] for text in texts for line in text.splitlines() if "].headline: " in line]
    assert len(headlines) > 60
    assert [each for each in headlines if len(each.split()) > 12] == []
