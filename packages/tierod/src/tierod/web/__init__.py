"""The interactive page: a server for folders of recordings and results, and the page that it serves.

    tierod.serve("recordings/", "results/", vehicle="car.toml")

The endpoints call the functions of `Workbench`, which programs can use without HTTP.
"""

from __future__ import annotations
