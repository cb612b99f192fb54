"""List the file formats of recordings that can be read and written, with the package of each."""

from __future__ import annotations

from typing import Annotated

import typer


def formats(json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False) -> None:
    """List the formats; a file is read by its content, and written by its ending."""
    from tierod.cli.terminal import output, print_json, rows
    from tierod.io.readers.opening import READERS
    from tierod.io.writers import WRITERS

    read = [(name, each.title, READERS.package_of(name)) for name, each in READERS.items()]
    written = [(f".{ending}", each.title, WRITERS.package_of(ending)) for ending, each in WRITERS.items()]
    if json:
        print_json(
            {
                "read": [dict(zip(("name", "title", "package"), row, strict=True)) for row in read],
                "written": [dict(zip(("ending", "title", "package"), row, strict=True)) for row in written],
            }
        )
        return
    console = output()
    console.print(rows(("read", "format (usual endings)", "package"), read))
    console.print()
    console.print(rows(("written", "format", "package"), written))
