"""Reference page of the JSON documents, generated from their schemas."""

from __future__ import annotations

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


COMMON = ("schema", "version", "created", "command", "symbol", "colour")
"""Fields of every document, explained once."""


def pages() -> dict[str, Callable[[], str]]:
    """Path below docs/ -> function that returns the text."""
    return {"reference/json.md": schemas_page}


def schemas_page() -> str:
    """Page of all documents with the tables of their fields."""
    parts = [
        "The schemas (draft 2020-12) describe every field; they are installed with the packages:",
        "```python\nimport json\nfrom importlib.resources import files\n\n"
        'file = files("tierod.report").joinpath("diagnosis.schema.json")\n'
        'schema = json.loads(file.read_text(encoding="utf-8"))\n```',
        "Every document holds `schema` (its name and version, which rises when a field goes or changes its meaning), "
        "`version` (of tierod), `created` (UTC) and `command`. Documents with a verdict hold `status`, `symbol`, "
        "`colour` and `exit_code` as [the table of statuses](words.md) has them. The further fields of each:",
    ]
    for name, (package, words) in SCHEMAS.items():
        schema = json.loads(files(package).joinpath(f"{name}.schema.json").read_text(encoding="utf-8"))
        parts += [f"## {name}", f"{words} Schema: `{name}.schema.json` of `{package}`.", _table(schema)]
    return page("JSON documents", *parts)


def _table(schema: dict[str, Any]) -> str:
    if schema.get("type") == "array":
        items = schema["items"]
        return _table(schema["$defs"][items["$ref"].rpartition("/")[2]] if "$ref" in items else items)
    rows = [(f"`{name}`", field.get("description", "")) for name, field in schema["properties"].items()]
    return table(("field", "meaning"), [row for row in rows if row[0].strip("`") not in COMMON])
