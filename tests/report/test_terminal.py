import dataclasses
import io

import pytest
from rich.console import Console

from diagnosis_examples import EXAMPLES
from tierod.report import print_table


def printed(name):
    console = Console(file=io.StringIO(), width=200)
    print_table(EXAMPLES[name](), console)
    return console.file.getvalue()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "friction_fault",
            [
                "✕ FAULT",
                "12.43 N·m  (95 %: 12.21 to 12.65)",
                "fault level 7.5 N·m",
                "21 min 50 s",
                "Remarks on the data",
            ],
        ),
        ("healthy", ["✓ HEALTHY", "as it should be"]),
        ("not_identifiable", ["? NOT IDENTIFIABLE", "<lane keeping> was active", "what to do", "raw counts"]),
        (
            "several_elements",
            [
                "Sensors and actuators",
                "✕ FAULT",
                "outlier",
                "positive offset",
                "16.62 °/s (16.17 to 17.06)",
                "angle and speed (0.008 rad/s)",
                "C1A33-64",
                "kind not known; not separable from steering motor 2",
                "the recording has no tie_rod_force",
            ],
        ),
        (
            "estimated",
            [
                "≈ ESTIMATED",
                "Which parameters decide",
                "rear_distance",
                "1.2 ± 0.3 m",
                "+3.5 °",
                "99 %",
                "−0.11 °",
                "Measure rear_distance first",
                "that of the class 'midsize' is assumed",
            ],
        ),
        ("nothing", ["? NOT AVAILABLE  no monitor ran"]),
    ],
)
def test_says_what_was_found(name, expected):
    text = printed(name)
    for each in expected:
        assert each in text


def test_square_brackets_of_a_recording_are_no_markup():
    assert "[/" not in printed("friction_fault")


def test_what_a_finding_warns_of_is_not_repeated_under_the_remarks():
    example = EXAMPLES["friction_fault"]()
    row = next(row for row in example.quality if row.remarks)
    warning = f"{row.name}: {row.remarks[0]}"
    first, *rest = example.findings
    warned = dataclasses.replace(first, warnings=(*first.warnings, warning))
    console = Console(file=io.StringIO(), width=400)
    print_table(dataclasses.replace(example, findings=(warned, *rest)), console)
    assert console.file.getvalue().count(row.remarks[0]) == 1


def test_columns_of_elements_that_stay_empty_are_left_out():
    example = EXAMPLES["several_elements"]()
    console = Console(file=io.StringIO(), width=200)
    print_table(dataclasses.replace(example, elements=example.elements[1:4]), console)
    text = console.file.getvalue()
    assert "fault" in text
    assert "replaced by" not in text
    assert "size" not in text
