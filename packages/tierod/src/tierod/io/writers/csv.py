"""CSV: a comment line with sources and notes, titles with units, one time column per group of channels.

Groups with fewer samples end in empty cells. Numbers are written with all digits, so that they read back exactly.
"""

from __future__ import annotations

import json
from pathlib import Path

from tierod.core.arrow import column_of
from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.io.layout import Writer
from tierod.io.writers.spool import ROWS, FromSpool, Spool


def write_csv(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording to a CSV file.

    Args:
        path: the file; replaced as a whole

    Returns:
        what the format cannot hold: nothing
    """
    import pyarrow as pa
    import pyarrow.csv as text

    found = spool.groups()
    about = spool.description(found)
    titles = [
        title for group in found for title in (f"{group.clock} [s]", *(_title(c.name, c.unit) for c in group.channels))
    ]
    names = {_title(each.name, each.unit): each.name for each in spool.channels.values()}
    about["channels"] = {title: about["channels"][name] | {"name": name} for title, name in names.items()}
    try:
        with replacing(path) as temporary, temporary.open("wb") as file:
            file.write(f"# tierod {json.dumps(about)}\n".encode())
            file.write((",".join(_quoted(title) for title in titles) + "\n").encode())
            for begin in range(0, max(group.count for group in found), ROWS):
                length = min(max(group.count for group in found) - begin, ROWS)
                parts = []
                for group in found:
                    columns = (group.time(begin, begin + ROWS), *group.values(begin, begin + ROWS))
                    parts += [column_of(each, length) for each in columns]
                table = pa.table(parts, names=[str(place) for place in range(len(parts))])
                text.write_csv(table, file, text.WriteOptions(include_header=False))
            file.flush()
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None
    return ()


def _title(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _quoted(title: str) -> str:
    escaped = title.replace('"', '""')
    return f'"{escaped}"' if any(sign in title for sign in ',"\n\r;\t') else title


WRITER = Writer("CSV", FromSpool(write_csv))
