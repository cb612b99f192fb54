"""The page of signals is the catalogue's, word for word."""

from pathlib import Path

from tierod.core.nomenclature import nomenclature
from tierod.core.signals import SIGNALS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "signals.md"


def test_the_page_is_up_to_date():
    remedy = "run: python -m tierod.core.nomenclature > docs/reference/signals.md"
    assert PAGE.read_text(encoding="utf-8") == nomenclature(), remedy


def test_every_signal_is_on_the_page():
    page = nomenclature()
    assert [name for name in SIGNALS if f"| `{name}` |" not in page] == []
