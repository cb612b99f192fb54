"""Text of C sources and of their companions from templates."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any


def rendered(folder: Path, name: str, values: Mapping[str, object]) -> str:
    """Text of a template; a value that it names and that is missing is an error."""
    import jinja2

    # The templates produce C, where HTML escaping would do harm.
    environment: Any = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        autoescape=False,
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
    )
    text: str = environment.get_template(name).render(values)
    return text
