"""The study of friction: the paper's filters and baseline on drives like its own, then the default monitor."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tierod.core.content import Item
from tierod_lab.papers.friction import default_datasets as default
from tierod_lab.papers.friction import paper_datasets as paper
from tierod_lab.papers.friction.charts import charts
from tierod_lab.papers.friction.reported import SEEDS
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame

DATASETS = (
    Dataset(
        "sets",
        "The paper's development and test set (Table 2, Figures 3 and 5 to 9)",
        paper.over_sets,
        paper.set_drives,
        joined=paper.distributions,
    ),
    Dataset("positions", "Where the angle is measured, P0 and G", paper.over_positions, paper.position_drives),
    Dataset("terms", "All terms of eq (19)", paper.over_terms, paper.term_drives),
    Dataset("turns", "The friction that was injected (Table 1, Figure 10)", paper.turns, lambda effort: [effort.quick]),
    Dataset(
        "fleet",
        "How exact, where no two cars are alike",
        default.over_fleet,
        default.fleet_cars,
        joined=default.with_floor,
    ),
    Dataset("steps", "How soon", default.over_steps, default.step_drives),
    Dataset("laws", "Friction laws outside the estimator's model", default.over_laws, default.law_drives),
)
"""The datasets, in the order of the report."""


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    yield SEEDS.table()
