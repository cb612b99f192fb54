"""The page to work in: a server over folders of recordings and results, and the page that it serves.

    tierod.serve("recordings/", "results/", vehicle="car.toml")

`Workbench` is what the endpoints call, for programs: the same functions without HTTP.
"""

from __future__ import annotations
