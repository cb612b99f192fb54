"""The monitor runs without the package of the paper's rules, and offers them where it is installed."""

import pytest

from tierod.monitors.condition import further_variants as further
from tierod.monitors.condition.definition import CONDITION

NONE = "tierod_lab.papers.condition.not_there.definition:VARIANTS"


def test_the_rules_of_the_paper_are_variants_beside_the_bank():
    assert list(CONDITION.variants) == ["bank", *further.further_variants()]
    assert CONDITION.default == "bank"
    assert all(each.decisions for each in CONDITION.variants.values())


def test_a_package_that_is_not_installed_adds_nothing(monkeypatch):
    monkeypatch.setattr(further, "_VARIANTS", NONE)
    monkeypatch.setattr(further, "_CALIBRATION", NONE)
    assert further.further_variants() == {}
    assert further.further_calibration()(None, (), (), "") == {}


def test_a_package_that_lacks_what_it_imports_is_no_package_that_is_missing(monkeypatch, tmp_path):
    (tmp_path / "broken_variants.py").write_text("import not_installed_either\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(further, "_VARIANTS", "broken_variants:VARIANTS")
    with pytest.raises(ModuleNotFoundError, match="not_installed_either"):
        further.further_variants()
