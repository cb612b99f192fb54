"""tierod: estimate what cannot be measured in a steering system, and find what is going wrong in it.

    import tierod

    drive = tierod.read("drive.mf4")
    diagnosis = tierod.diagnose(drive, "midsize-eps", monitor="friction")
    print(diagnosis.findings[0].headline)
    tierod.plot(diagnosis).show()

Names are imported when they are first used, so that `import tierod` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tierod.core.errors import InputError, TierodError
    from tierod.core.facts import Fact, Verdict
    from tierod.core.findings import Diagnosis, Estimate, Finding, Status
    from tierod.core.graph import Stream, batch, maths, scan
    from tierod.core.recording import Channel, Recording
    from tierod.core.version import __version__
    from tierod.io.readers import read
    from tierod.io.writers import write
    from tierod.monitors.diagnose import diagnose
    from tierod.monitors.inspection import inspect
    from tierod.monitors.session import BlockSession, Conclusion, Monitor, Variant
    from tierod.report import to_json, write_html
    from tierod.report.identification import identify
    from tierod.report.isolability import analyse as isolability
    from tierod.report.plot import plot
    from tierod.vehicles import Vehicle
    from tierod.vehicles import load as vehicle
    from tierod.web.server import serve

    campaign: Any
    compare: Any
    simulate: Any

_HOMES = {
    "BlockSession": "tierod.monitors.session",
    "Channel": "tierod.core.recording",
    "Conclusion": "tierod.monitors.session",
    "Diagnosis": "tierod.core.findings",
    "Estimate": "tierod.core.findings",
    "Fact": "tierod.core.facts",
    "Finding": "tierod.core.findings",
    "InputError": "tierod.core.errors",
    "Monitor": "tierod.monitors.session",
    "Recording": "tierod.core.recording",
    "Status": "tierod.core.findings",
    "Stream": "tierod.core.graph",
    "TierodError": "tierod.core.errors",
    "Variant": "tierod.monitors.session",
    "Vehicle": "tierod.vehicles",
    "Verdict": "tierod.core.facts",
    "__version__": "tierod.core.version",
    "batch": "tierod.core.graph",
    "diagnose": "tierod.monitors.diagnose",
    "identify": "tierod.report.identification",
    "inspect": "tierod.monitors.inspection",
    "isolability": "tierod.report.isolability:analyse",
    "maths": "tierod.core.graph.maths:",
    "plot": "tierod.report.plot",
    "read": "tierod.io.readers",
    "scan": "tierod.core.graph",
    "serve": "tierod.web.server",
    "to_json": "tierod.report",
    "vehicle": "tierod.vehicles:load",
    "write": "tierod.io.writers",
    "write_html": "tierod.report",
}
"""Module of each name; after a colon its name there, nothing where it is the module itself."""

_LAB = ("campaign", "compare", "simulate")
"""Names that the package tierod-lab provides."""

__all__ = [
    "BlockSession",
    "Channel",
    "Conclusion",
    "Diagnosis",
    "Estimate",
    "Fact",
    "Finding",
    "InputError",
    "Monitor",
    "Recording",
    "Status",
    "Stream",
    "TierodError",
    "Variant",
    "Vehicle",
    "Verdict",
    "__version__",
    "batch",
    "diagnose",
    "identify",
    "inspect",
    "isolability",
    "maths",
    "plot",
    "read",
    "scan",
    "serve",
    "to_json",
    "vehicle",
    "write",
    "write_html",
]


def __getattr__(name: str) -> Any:
    if name in _LAB:
        from tierod.core.plugins import part

        globals()[name] = part(name, f"tierod.{name}")
        return globals()[name]
    if name not in _HOMES:
        raise AttributeError(f"module 'tierod' has no attribute '{name}'")
    place, colon, attribute = _HOMES[name].partition(":")
    module = importlib.import_module(place)
    value = module if colon and not attribute else getattr(module, attribute or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    from tierod.core.plugins import installed

    return sorted([*__all__, *(_LAB if installed() else ())])
