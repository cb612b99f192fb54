"""Reference pages of the JSON documents, generated from their schemas."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable
from importlib.resources import files
from typing import Any

from docs_text import page, table

SCHEMAS = {
    "diagnosis": (
        "tierod.report",
        "`tierod diagnose --json` prints this document to stdout; `tierod.to_json(diagnosis)` gives the same text, and "
        "`tierod.to_json(diagnosis, series=True)` adds the time series. Numbers are in SI units whatever the report "
        "shows. What could not be computed is `null`, never NaN.",
    ),
    "diagnoses": (
        "tierod.report",
        "`tierod diagnose --json` prints this document where several recordings or all monitors are judged.",
    ),
    "campaign": ("tierod_lab.campaign", "`tierod campaign` writes this document as `campaign.json`."),
    "fleet": (
        "tierod.fleet",
        "`tierod fleet report --json` prints this document to stdout; without `--json` it stands in `fleet.json`.",
    ),
    "claims": ("tierod.core", "`tierod study` writes this list as `claims.json`, one object for each claim."),
}
"""Name -> package that contains the schema, and origin of the document."""


def pages() -> dict[str, Callable[[], str]]:
    """Path below docs/ -> function that returns the text."""
    return {f"reference/json/{name}.md": functools.partial(schema_page, name) for name in SCHEMAS}


def schema_page(name: str) -> str:
    """Page of one document with the tables of its fields."""
    package, words = SCHEMAS[name]
    schema = json.loads(files(package).joinpath(f"{name}.schema.json").read_text(encoding="utf-8"))
    parts = [words, f"The schema (draft 2020-12) is installed with the package as `{name}.schema.json` of `{package}`:"]
    parts.append(
        "```python\nimport json\nfrom importlib.resources import files\n\n"
        f'schema = json.loads(files("{package}").joinpath("{name}.schema.json").read_text(encoding="utf-8"))\n```'
    )
    if "const" in schema.get("properties", {}).get("schema", {}):
        parts.append("The field `schema` names the version; it rises when a field goes or changes its meaning.")
    parts += ["## The document", _table(schema)]
    for key, definition in schema.get("$defs", {}).items():
        parts += [f"## {key}", _table(definition)]
    return page(f"JSON: {name}", *parts)


def _table(schema: dict[str, Any]) -> str:
    described = schema.get("description", "")
    if schema.get("type") == "array":
        return _table(schema["items"])
    if "properties" not in schema:
        return f"{_type(schema)}. {described}".strip()
    rows = []
    for name, field in schema["properties"].items():
        optional = "" if name in schema.get("required", ()) else " (optional)"
        rows.append((f"`{name}`{optional}", _type(field), field.get("description", "")))
    return table(("field", "type", "meaning"), rows)


def _type(field: dict[str, Any]) -> str:
    if "const" in field:
        return f"`{json.dumps(field['const'])}`"
    if "enum" in field:
        return ", ".join(f"`{json.dumps(value)}`" for value in field["enum"])
    if "$ref" in field:
        name = field["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    for key in ("oneOf", "anyOf"):
        if key in field:
            return " or ".join(_type(choice) for choice in field[key])
    if "type" not in field:
        return "any"
    kinds = field["type"] if isinstance(field["type"], list) else [field["type"]]
    if "array" in kinds:
        return f"list of {_type(field['items'])}" if "items" in field else "list"
    inner = field.get("additionalProperties")
    return f"object of {_type(inner)}" if isinstance(inner, dict) else " or ".join(kinds)
