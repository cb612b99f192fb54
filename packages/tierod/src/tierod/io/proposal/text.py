"""The text of a proposed channel map, with the reason of every entry as a comment."""

from __future__ import annotations

from tierod.core.screen import printable
from tierod.core.signals import SIGNALS
from tierod.core.toml import quoted
from tierod.io.proposal.propose import Proposal, Proposed


def text_of(proposal: Proposal) -> str:
    """A channel map in TOML, to be read, edited and used."""
    doubtful = [entry.signal for entry in proposal.entries if entry.doubtful]
    head = [
        f"# Channel map proposed from {printable(proposal.path.name)}: edit it, and keep what is right.",
        "# SI units and ISO 8855 hold behind it: forward and left are positive.",
    ]
    if doubtful:
        head.append(f"# To check: {', '.join(doubtful)}.")
    parts = ["\n".join([*head, f"title = {quoted(f'proposed from {proposal.path.name}')}"])]
    parts += [_table(entry) for entry in proposal.entries]
    if proposal.unmatched:
        lines = ["# Columns that were not matched; write a table for each that you need:"]
        lines += [f"#   {quoted(c.name)}{f'  [{printable(c.unit)}]' if c.unit else ''}" for c in proposal.unmatched]
        lines += ["# [signals.NAME]  # a name of 'docs/reference/signals.md'", '# source = "COLUMN"', '# unit = "..."']
        parts.append("\n".join(lines))
    if proposal.texts:
        names = ", ".join(map(quoted, proposal.texts))
        parts.append(
            f"# Not read, since they hold text: {names}. Values that such a flag marks as invalid are read as valid."
        )
    return "\n\n".join(parts) + "\n"


def _table(entry: Proposed) -> str:
    signal = SIGNALS[entry.signal]
    lines = [f"[signals.{entry.signal}]  # {signal.meaning}", f"source = {quoted(entry.column.name)}"]
    reason = f"name: {entry.meant.reason}"
    if entry.others:
        reason += f"; other candidates: {', '.join(map(repr, entry.others))}"
    lines[-1] += f"  # {printable(reason)}"
    lines.append(f"unit = {quoted(entry.unit.unit.name)}  # {entry.unit.reason}")
    if entry.factor != 1.0:
        lines.append(f"factor = {entry.factor:.5g}  # m/s of one unit of the column")
    if entry.sign.sign < 0 or entry.sign.reason:
        lines.append(f"sign = {entry.sign.sign}  # {entry.sign.reason}; positive: {signal.positive or '-'}")
    return "\n".join(lines)
