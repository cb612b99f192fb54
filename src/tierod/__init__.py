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

__version__ = "0.1.0"

if TYPE_CHECKING:
    from tierod.core.errors import TierodError
    from tierod.core.findings import Diagnosis, Finding, Status
    from tierod.core.graph import Stream, batch, scan
    from tierod.core.recording import Channel, Recording
    from tierod.io.readers import read
    from tierod.io.writers import write
    from tierod.monitors.diagnose import diagnose
    from tierod.report import to_json, write_html
    from tierod.report.plot import plot
    from tierod.vehicles import Vehicle
    from tierod.vehicles import load as vehicle

_HOMES = {
    "Channel": "tierod.core.recording",
    "Diagnosis": "tierod.core.findings",
    "Finding": "tierod.core.findings",
    "Recording": "tierod.core.recording",
    "Status": "tierod.core.findings",
    "Stream": "tierod.core.graph",
    "TierodError": "tierod.core.errors",
    "Vehicle": "tierod.vehicles",
    "batch": "tierod.core.graph",
    "diagnose": "tierod.monitors.diagnose",
    "plot": "tierod.report.plot",
    "read": "tierod.io.readers",
    "scan": "tierod.core.graph",
    "to_json": "tierod.report",
    "vehicle": "tierod.vehicles:load",
    "write": "tierod.io.writers",
    "write_html": "tierod.report",
}

__all__ = [
    "Channel",
    "Diagnosis",
    "Finding",
    "Recording",
    "Status",
    "Stream",
    "TierodError",
    "Vehicle",
    "__version__",
    "batch",
    "diagnose",
    "plot",
    "read",
    "scan",
    "to_json",
    "vehicle",
    "write",
    "write_html",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'tierod' has no attribute '{name}'")
    module, _, attribute = _HOMES[name].partition(":")
    value = getattr(importlib.import_module(module), attribute or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
