"""Every numbered part of the papers has an entry, and every function, test and study that it names exists."""

from importlib import import_module
from pathlib import Path

import pytest

from tierod.core.errors import ParameterError
from tierod_lab.papers.contents import PAPERS, Contents, Entry, contents

ROOT = Path(__file__).resolve().parents[2]
ENTRIES = [pytest.param(row, id=f"{package} {row.of}") for package in PAPERS for row in contents(package).rows]


@pytest.mark.parametrize("package", PAPERS)
def test_every_number_of_a_paper_is_covered_once(package):
    held = contents(package)
    assert held.missing() == ()
    numbers = [(row.kind, number) for row in held.rows for number in row.numbers]
    assert len(numbers) == len(set(numbers))
    assert (ROOT / "docs/explanation/papers" / f"{held.explanation}.md").exists()


@pytest.mark.parametrize("entry", ENTRIES)
def test_what_an_entry_names_is_there(entry):
    for each in entry.code:
        module, _, name = each.partition(":")
        assert hasattr(import_module(module), name), each
    assert entry.verdict


def test_numbers_are_read_from_words():
    def numbers(of):
        return Entry(of, "", (), "").numbers

    assert numbers("(7) to (10)") == ("7", "8", "9", "10")
    assert numbers("(3), (4)") == ("3", "4")
    assert numbers("Figures 1 to 3, 6") == ("1", "2", "3", "6")
    assert numbers("Table A1") == ("A1",)
    assert numbers("Section 4.3") == ()


def test_what_is_not_covered_is_named():
    row = Entry("(1), (3)", "", (), "right")
    held = Contents("paper", "page", 3, 1, 1, (row, Entry("Figure 1", "", (), "right")))
    assert held.missing() == ("equation 2", "table 1")
    with pytest.raises(ParameterError, match="no paper"):
        contents("steering")
