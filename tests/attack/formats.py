"""Which operators change a file of which format."""

from __future__ import annotations

import random
from collections.abc import Sequence

from .containers import blf_container, gzip_content, mat_element, mdf_block, parquet_data, parquet_footer, parquet_table
from .documents import dbc_signal, hexadecimal, json_node, toml_key, toml_value
from .mutations import BYTES, Operator
from .texts import TEXT

FAMILIES: dict[str, tuple[tuple[Operator, ...], tuple[Operator, ...]]] = {
    "text": (TEXT, TEXT),
    "can-text": (TEXT, (hexadecimal,)),
    "gzip": (BYTES, (gzip_content, gzip_content, gzip_content)),
    "mdf": (BYTES, (mdf_block,)),
    "parquet": (BYTES, (parquet_footer, parquet_data, parquet_table, parquet_table, parquet_table, parquet_table)),
    "process": (BYTES, BYTES),
    "mat": (BYTES, (mat_element,)),
    "blf": (BYTES, (blf_container,)),
    "toml": (TEXT, (toml_value, toml_value, toml_key)),
    "json": (TEXT, (json_node,)),
    "dbc": (TEXT, (dbc_signal,)),
}
"""Of each family of formats the operators that know nothing of it, and those that do."""


def mutated(chance: random.Random, content: bytes, others: Sequence[bytes], family: str) -> bytes:
    """A changed file: mostly one change, now and then a handful.

    Args:
        chance: random source; the same state gives the same bytes
        content: of the file
        others: of its kind, for splices
        family: of the format, a key of `FAMILIES`
    """
    plain, aware = FAMILIES[family]
    # A text that is no longer TOML or JSON ends at the parser: most changes keep it one.
    share = 0.8 if family in ("toml", "json", "dbc") else 0.6
    for _ in range(chance.choice((1, 1, 1, 1, 2, 2, 3, 6))):
        content = chance.choice(aware if chance.random() < share else plain)(chance, content, others)
    return content
