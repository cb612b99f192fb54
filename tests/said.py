"""What a reader sees of a finding at first: headline and details."""

from tierod.core.findings import Finding
from tierod.core.shown import plus_minus


def said(finding: Finding) -> str:
    """Headline and details of a finding, one after the other."""
    return "; ".join((finding.headline, *finding.details))


def estimated(finding: Finding) -> str:
    """The estimate of a finding as its texts show it."""
    assert finding.estimate is not None
    return plus_minus(finding.estimate.value, finding.estimate.standard_deviation, finding.estimate.unit)
