import json
import math
from importlib.resources import files

import jsonschema
import pytest

from tierod.core.claims import Claim, Goal, Outcome, at_most, between, claims_document, exactly
from tierod.core.errors import ParameterError

SCHEMA = json.loads(files("tierod.core").joinpath("claims.schema.json").read_text(encoding="utf-8"))


def claim(name="paper.bias", measured: float | None = 0.2, goal=at_most(0.3), printed=None):  # noqa: B008
    return Claim(name, "The bias is small.", "tierod", printed, measured, goal, "N*m", "in 24 drives")


@pytest.mark.parametrize(
    ("goal", "inside", "outside", "text"),
    [
        (at_most(0.3), (0.3, -5.0), (0.31, math.inf), "<= 0.3"),
        (between(1.5, 2.2), (1.5, 2.2), (1.49, 2.21), "1.5 to 2.2"),
        (exactly(0.0), (0.0,), (1.0, -1.0), "= 0"),
    ],
)
def test_a_goal_holds_within_its_ends_and_reads_back(goal, inside, outside, text):
    assert all(goal.holds(value) for value in inside)
    assert not any(goal.holds(value) for value in outside)
    assert str(goal) == text
    assert Goal.read(text) == goal


def test_the_document_keeps_to_its_schema():
    claims = [
        claim("paper.a", printed="1.5 to 2.2", goal=between(1.5, 2.2)),
        claim("paper.b", printed=0.36, measured=math.nan, goal=exactly(-1e-7)),
        claim("goal.c-1.5", measured=None, goal=None),
    ]
    document = json.loads(claims_document(claims))
    jsonschema.validate(document, SCHEMA)
    assert [row["met"] for row in document] == [False, False, None]
    held, not_held = (json.loads(claims_document([missed(measured=value)]))[0]["cause"] for value in (0.2, 1.0))
    assert (held, not_held) == ("", "P0 is not printed.")
    assert list(document[0]) == [
        *("id", "claim", "source", "printed", "derived", "measured", "goal", "unit", "met", "outcome", "note", "cause")
    ]


def missed(name="paper.bias", cause="P0 is not printed.", irreproducible=True, measured=1.0):
    return Claim(name, "c", "s", 0.1, measured, at_most(0.3), cause=cause, irreproducible=irreproducible)


def test_what_the_source_is_to_blame_for_is_no_shortfall_of_ours():
    assert missed().outcome is Outcome.IRREPRODUCIBLE
    assert missed(irreproducible=False).outcome is Outcome.FAILS
    assert missed(measured=0.2).outcome is Outcome.HOLDS
    assert claim(measured=None).outcome is Outcome.UNMEASURED
    assert claim(goal=None).outcome is None
    with pytest.raises(ParameterError, match="without a cause"):
        missed(cause="")


@pytest.mark.parametrize("name", ["bias", "Paper.bias", "paper.", "paper.two words"])
def test_a_name_of_a_claim_has_a_group(name):
    with pytest.raises(ParameterError, match="not the name of a claim"):
        claim(name)
