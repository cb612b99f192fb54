"""Measure the estimators on virtual drives: the figures of the documentation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def study(
    name: Annotated[str | None, typer.Argument(help="Which study; every one where not given.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Folder for the figures as Markdown.")] = None,
) -> int:
    """Run a study and print its tables, as soon as each is there."""
    import sys

    from tierod.cli.terminal import messages
    from tierod.errors import ParameterError, nearest
    from tierod.files import write_text
    from tierod.studies.registry import STUDIES

    if name is not None and name not in STUDIES:
        raise ParameterError(f"there is no study '{name}'{nearest(name, STUDIES)}")
    for chosen in STUDIES.values() if name is None else [STUDIES[name]]:
        sections = []
        for section in chosen.sections(lambda what: messages().print(f"measuring: {what}")):
            sections.append(section)
            sys.stdout.write(section + "\n")
            sys.stdout.flush()
        if output is not None:
            output.mkdir(parents=True, exist_ok=True)
            path = write_text(output / f"{chosen.name}.md", f"# Study: {chosen.name}\n\n" + "\n".join(sections))
            messages().print(f"written: {path}", soft_wrap=True, markup=False)
    return 0
