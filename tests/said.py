"""What a reader sees of a finding at first: headline and details."""

from tierod.core.findings import Finding


def said(finding: Finding) -> str:
    """Headline and details of a finding, one after the other."""
    return "; ".join((finding.headline, *finding.details))
