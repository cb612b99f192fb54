"""Reference page of the JSON documents: which command writes which, and where its schema is."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.resources import files
from typing import Any

from docs_text import names, page, table

SCHEMAS = {
    "diagnosis": ("tierod.report", "`tierod diagnose --json`; `tierod.to_json(diagnosis)` gives the same text"),
    "diagnoses": ("tierod.report", "`tierod diagnose --json` of several recordings or all monitors"),
    "campaign": ("tierod_lab.campaign", "`tierod campaign`, as `campaign.json`"),
    "fleet": ("tierod.fleet", "`tierod fleet report`, as `fleet.json` or with `--json`"),
    "claims": ("tierod.core", "`tierod study`, as `claims.json`: a list with one object for each claim"),
}
"""Name -> package that contains the schema, and origin of the document."""

COMMON = ("schema", "version", "created", "command", "status", "symbol", "colour", "exit_code")
"""Fields that most documents share."""


def pages() -> dict[str, Callable[[], str]]:
    """Path below docs/ -> function that returns the text."""
    return {"reference/json.md": schemas_page}


def schemas_page() -> str:
    """Page of all documents with the names of their fields."""
    rows = []
    for name, (package, origin) in SCHEMAS.items():
        schema = json.loads(files(package).joinpath(f"{name}.schema.json").read_text(encoding="utf-8"))
        fields = [field for field in _fields(schema) if field not in COMMON]
        rows.append((f"`{name}`", origin, f"`{package}`", names(fields)))
    return page(
        "JSON documents",
        "A schema (draft 2020-12) describes every field of a document; it is installed with its package as "
        "`NAME.schema.json`. This prints what the fields of a diagnosis mean:",
        "```python\nimport json\nfrom importlib.resources import files\n\n"
        'file = files("tierod.report").joinpath("diagnosis.schema.json")\n'
        'schema = json.loads(file.read_text(encoding="utf-8"))\n'
        'for name, field in schema["properties"].items():\n    print(name, field["description"])\n```',
        table(("document", "written by", "schema in", "fields"), rows),
        "Documents also hold `schema` (name and version, which rises when a field goes or changes its meaning), "
        "`version` (of tierod), `created` (UTC) and `command`, and those with a verdict `status`, `symbol`, `colour` "
        "and `exit_code` as [the table of statuses](words.md) has them. Numbers are in SI units whatever a report "
        "shows. What could not be computed is `null`, never NaN. `traces`, `histograms` and `loops` of a diagnosis are "
        "filled by `tierod.to_json(diagnosis, series=True)`.",
    )


def _fields(schema: dict[str, Any]) -> list[str]:
    if schema.get("type") == "array":
        items = schema["items"]
        return _fields(schema["$defs"][items["$ref"].rpartition("/")[2]] if "$ref" in items else items)
    return list(schema["properties"])
