"""JSON document of a diagnosis."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from tierod.core.decimation import merged
from tierod.core.files import text_of
from tierod.core.findings import Diagnosis, Element, Episode, Estimate, Finding, Trace
from tierod.report.display import INTERVAL

SCHEMA = "tierod.diagnosis/4"  # Name and version of the JSON document


def document(diagnosis: Diagnosis, series: bool) -> str:
    """JSON text of a diagnosis; NaN and infinity become null."""
    content = {
        "schema": SCHEMA,
        "version": diagnosis.version,
        "created": diagnosis.created,
        "command": diagnosis.command,
        **diagnosis.status.document(),
        "exit_code": diagnosis.status.exit_code,
        "findings": [_finding(finding) for finding in diagnosis.findings],
        "elements": [_element(element) for element in diagnosis.elements],
        "consistency": diagnosis.consistency,
        "remarks": diagnosis.remarks,
        "quality": [dataclasses.asdict(row) for row in diagnosis.quality],
        "vehicle": diagnosis.vehicle,
        "parameters": [
            dict(zip(("name", "value", "unit", "standard_deviation", "source"), row, strict=True))
            for row in diagnosis.parameters
        ],
        "parameter_effects": [dataclasses.asdict(each) for each in diagnosis.parameter_effects],
    }
    if series:
        content["traces"] = {name: _trace(merged(trace)) for name, trace in diagnosis.traces.items()}
        content["histograms"] = {
            name: {"edges": edges, "counts": counts} for name, (edges, counts) in diagnosis.histograms.items()
        }
        content["loops"] = {
            name: {"angle": angle, "torque": torque} for name, (angle, torque) in diagnosis.loops.items()
        }
    # The recording comes last, because for a simulation it contains all parameters of the plant.
    content["recording"] = diagnosis.recording
    return json.dumps(plain(content), ensure_ascii=False, indent=None if series else 2, allow_nan=False)


def plain(value: object) -> Any:
    """A value converted to JSON types: dictionaries, lists, text, finite numbers, null."""
    if isinstance(value, Mapping):
        return {text_of(str(key)): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int) else text_of(str(value))


def _finding(finding: Finding) -> dict[str, Any]:
    names = [field.name for field in dataclasses.fields(finding) if field.name != "decided_by"]
    content = {name: getattr(finding, name) for name in names} | finding.status.document()
    return content | {"estimate": _estimate(finding.estimate)}


def _estimate(estimate: Estimate | None) -> dict[str, Any] | None:
    if estimate is None:
        return None
    half = INTERVAL * estimate.standard_deviation
    inside = ("limits", "held", "fault_from")
    content = {name: value for name, value in dataclasses.asdict(estimate).items() if name not in inside}
    return content | {"interval": [estimate.value - half, estimate.value + half]}


def _element(element: Element) -> dict[str, Any]:
    content = {field.name: getattr(element, field.name) for field in dataclasses.fields(element)}
    content |= element.status.document()
    return content | {"episodes": [_episode(episode) for episode in element.episodes]}


def _episode(episode: Episode) -> dict[str, Any]:
    names = {field.name: "size" if field.name == "magnitude" else field.name for field in dataclasses.fields(episode)}
    return {key: getattr(episode, name) for name, key in names.items()} | {"size": _estimate(episode.magnitude)}


def _trace(trace: Trace) -> dict[str, Any]:
    return {key: getattr(trace, key) for key in ("unit", "time", "lower", "upper", "mean")}
