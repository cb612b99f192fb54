"""Proposal of a channel map: which column of a recording is which signal, in which unit, with which sign, and why."""

from __future__ import annotations

from tierod.io.proposal.propose import Proposal, propose, text_of

__all__ = ["Proposal", "propose", "text_of"]
