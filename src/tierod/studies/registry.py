"""Every study there is: sections of Markdown, made one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Study:
    """One study.

    Args:
        name: as given on the command line
        summary: one sentence
        sections: makes the sections of the study, Markdown each; called with a function that is told what comes next
    """

    name: str
    summary: str
    sections: Callable[[Callable[[str], None]], Iterator[str]]


def _friction(announce: Callable[[str], None]) -> Iterator[str]:
    from tierod.studies import friction_accuracy, friction_paper

    announce("the default estimator and its verdict")
    yield "## The default estimator and its verdict\n"
    for name in friction_accuracy.TABLES:
        announce(name)
        yield friction_accuracy.table(friction_accuracy.run(tables=(name,))) + "\n"
    announce("the paper's methods")
    yield "## The paper's methods\n"
    for table in friction_paper.tables():
        yield table.markdown()


STUDIES: Mapping[str, Study] = {
    study.name: study
    for study in (
        Study(
            "friction",
            "Bias, scatter, detection time and false verdicts of every friction estimator on virtual drives.",
            _friction,
        ),
    )
}
"""By name, as given on the command line."""
