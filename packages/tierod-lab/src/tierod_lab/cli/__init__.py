"""Verbs of the command line that need the virtual vehicle, one file per verb."""

from __future__ import annotations

EXAMPLES: dict[str, tuple[str, ...]] = {
    "campaign": ("tierod campaign friction-steps --dry-run", "tierod campaign friction-steps -o runs/"),
    "scenarios": ("tierod scenarios",),
    "simulate": ("tierod simulate mixed-drive-friction-step -o drive.mf4",),
}
"""Examples by command, as they are typed."""


def names_of(parameter: str) -> tuple[str, ...]:
    """The possible names of an option or argument; empty if its values are not names."""
    if parameter in ("simulate scenario", "scenarios name"):
        from tierod_lab.ground.scenarios import shipped

        return tuple(shipped())
    if parameter == "campaign file":
        from tierod_lab.campaign.campaign import shipped as campaigns

        return tuple(campaigns())
    from tierod.cli import examples

    return examples.names_of(parameter)
