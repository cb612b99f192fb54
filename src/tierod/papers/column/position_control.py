"""Position control of the column on observed states, and the driver who ends it."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.content import Heading, Item
from tierod.experiments.effort import Effort
from tierod.papers.column import figure_ten, robustness, takeover, tracking
from tierod.papers.column.closed_loop import belief, loop_of
from tierod.papers.column.followed import sweep

TEXT = (
    "The paper closes the loop with a first attempt at a linear quadratic regulator on observed states and shows one "
    "sweep. Here the regulator has integral action, a plan from the flat output (the steering wheel's angle, of which "
    "the reference's derivatives give every state and torque), friction fed forward, limits of torque and its rate. "
    "What it finds from one sample acts from the next on.",
    "The plant is the simulated bench with its gear and Dahl friction; noise of 0.05° and 0.2° on the angles of "
    "steering wheel and motor, 0.02 N·m on the torsion bar. The angle that counts is that of the gear, which no sensor "
    "tells. Where nothing else is said, the observer is the paper's mechanical reduction.",
    "A driver who takes the wheel ends control: a cumulative sum of the observed torque of the hands above 0.75 N·m, "
    "whose threshold finds 1 N·m in the estimate within 30 ms. The torque is let go within 100 ms. Control comes back "
    "when it is asked for anew and the hands have been still for a second.",
)


def items(effort: Effort) -> Iterator[Item]:
    """Section 6 of the paper and figure 10, and what they leave open."""
    known = belief()
    loops = {name: loop_of(observer, known) for name, observer in tracking.observers(known).items()}
    chosen = loops[tracking.CHOSEN]
    yield Heading("Position control", TEXT)
    yield from tracking.items(loops, known, effort)
    shown = {name: loops[name] for name in tracking.PRINTED}
    yield figure_ten.chart(sweep(chosen, 1, effort.quick)[0], shown)
    yield from robustness.items(chosen, effort)
    yield Heading("A driver takes the wheel")
    yield from takeover.items(loops, effort)
