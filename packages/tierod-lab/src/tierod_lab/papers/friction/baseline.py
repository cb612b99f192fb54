"""The baseline algorithm of the paper on its drives: Figure 3 and the claims of sections 4.1 to 4.3."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, at_least, at_most, between
from tierod.core.content import Bars, Chart, Heading, Item, Panel, Table
from tierod_lab.campaign.figures import area_under_curve
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import STATES
from tierod_lab.papers.friction.digest import Windows
from tierod_lab.papers.friction.paper_sets import SOURCE, WORST, PaperSets, paper_sets
from tierod_lab.papers.friction.runs import Drives
from tierod_lab.papers.friction.statistics import BINS, joined, mean, overlap, pooled, shares
from tierod_lab.studies.effort import Effort

SHOWN = {
    named.BASELINE: "eq (1) corrected",
    named.BASELINE_SIGN: "eq (1) with its printed sign",
    named.BASELINE_GATED: "corrected, printed gate",
    named.BASELINE_IN_G: "corrected, printed gate with its limits in g",
}


def items(drives: Drives, effort: Effort) -> Iterator[Item]:
    sets = paper_sets(effort)
    yield Heading(
        "The baseline algorithm",
        (
            "The variance over 15 s of the difference of two self-aligning torques. The paper finds that it does not "
            "separate healthy from faulty. With eq (1) corrected it does on virtual drives; with the printed sign, "
            "which compares a torque with its own negative, the two overlap as in the paper.",
        ),
    )
    yield _figure(sets, drives)
    yield _table(sets, drives)
    yield from _claims(sets, drives)


def variances(sets: PaperSets, drives: Drives, state: str, baseline: str) -> np.ndarray:
    """Variances of all windows of a health state, development set [(N*m)**2]."""
    return joined(window.variance for window in _windows(sets, drives, state, baseline))


def _windows(sets: PaperSets, drives: Drives, state: str, baseline: str) -> list[Windows]:
    return [digest.windows[baseline] for digest in drives.of(sets.development[state])]


def _figure(sets: PaperSets, drives: Drives) -> Chart:
    panels = []
    for name in (named.BASELINE, named.BASELINE_SIGN):
        found = {state: variances(sets, drives, state, name) for state in ("Healthy", WORST)}
        # The largest variances would squeeze all others into a few bars.
        widest = max((float(np.quantile(values, 0.99)) for values in found.values() if len(values)), default=1.0)
        at = np.linspace(0.0, widest, BINS + 1)
        panels.append(
            Panel(
                SHOWN[name],
                "variance [(N·m)²]",
                "share of the windows",
                tuple(Bars(state, at, shares(values, at)) for state, values in found.items()),
            )
        )
    return Chart(
        "figure-3",
        "Figure 3: rolling error variances, healthy against PWM 25%, development set",
        "Share of the windows of 15 s. Above with eq (1) as it follows from the single track, beneath as printed; "
        "one window in a hundred lies further to the right.",
        "Histograms of the baseline's variances; apart with the corrected equation, overlapping with the printed sign.",
        tuple(panels),
    )


def _table(sets: PaperSets, drives: Drives) -> Table:
    rows = []
    for name, words in SHOWN.items():
        groups = {state: variances(sets, drives, state, name) for state in STATES}
        healthy, faulty = groups["Healthy"], groups[WORST]
        enabled = mean(np.array([window.enabled_share for window in _windows(sets, drives, "Healthy", name)]))
        rows.append(
            (
                words,
                *(_quantiles(groups[state]) for state in STATES),
                _written(overlap(healthy, faulty, logarithmic=True)),
                _written(area_under_curve(healthy, faulty)),
                f"{100.0 * enabled:.1f} %",
            )
        )
    return Table(
        "Baseline: variance over 15 s, median (5 to 95 %), development set, (N·m)²",
        ("variant", *STATES, "overlap", "AUC", "enabled"),
        tuple(rows),
        "Overlap and AUC are those of Healthy against PWM 25%.",
    )


def _median(values: np.ndarray) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _written(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.3f}"


def _quantiles(values: np.ndarray) -> str:
    if not len(values):
        return "none"
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95))
    return f"{middle:.0f} ({low:.0f} to {high:.0f})"


def _claims(sets: PaperSets, drives: Drives) -> Iterator[Claim]:
    healthy, faulty = (variances(sets, drives, state, named.BASELINE) for state in ("Healthy", WORST))
    yield Claim(
        "paper.baseline-overlap",
        "The baseline does little to identify the fault: its variances of healthy and faulty steering overlap.",
        f"{SOURCE}, section 4.2 and Figure 3",
        "overlap",
        overlap(healthy, faulty, logarithmic=True),
        at_least(0.4),
        "",
        "Share that the histograms have in common, eq (1) corrected: on virtual drives the corrected baseline works.",
        cause=f"The paper's drives and parameters are not printed. From its own equations the baseline separates both "
        f"(AUC {area_under_curve(healthy, faulty):.3f}); the search shows which conditions come nearest.",
        irreproducible=True,
    )
    signed = [variances(sets, drives, state, named.BASELINE_SIGN) for state in ("Healthy", WORST)]
    yield Claim(
        "paper.baseline-overlap-printed-sign",
        "The same with the sign that eq (1) is printed with.",
        f"{SOURCE}, eq (1) and Figure 3",
        "overlap",
        overlap(*signed, logarithmic=True),
        at_least(0.4),
        "",
        "The printed sign compares a torque with its negative.",
        cause=f"The paper's drives and parameters are not printed. The printed sign lowers the AUC to "
        f"{area_under_curve(*signed):.3f}, part of what the paper shows; for the rest see the search.",
        irreproducible=True,
    )
    yield from _claims_on_gate(sets, drives)
    yield from _claims_on_delay(sets, drives)
    refined = [pooled(drives.of(sets.development[state]), named.PRINTED) for state in ("Healthy", WORST)]
    yield Claim(
        "paper.refined-better",
        "The refined algorithm separates healthy from faulty better than the baseline.",
        f"{SOURCE}, section 5, Figures 3 and 7",
        "superior",
        overlap(healthy, faulty, logarithmic=True) - overlap(*refined),
        at_least(0.0),
        "",
        "Overlap of the corrected baseline less that of the refined filter, development set.",
    )


def _claims_on_gate(sets: PaperSets, drives: Drives) -> Iterator[Claim]:
    gate_shares = {
        name: mean(np.array([window.enabled_share for window in _windows(sets, drives, "Healthy", name)]))
        for name in (named.BASELINE_GATED, named.BASELINE_IN_G)
    }
    for name, words, unit in (
        (named.BASELINE_GATED, "gate", "as printed, in m/s²"),
        (named.BASELINE_IN_G, "gate-in-g", "read in g"),
    ):
        yield Claim(
            f"paper.baseline-{words}-share",
            f"The baseline's gate is open 36 % of the time; limits of lateral acceleration {unit}.",
            f"{SOURCE}, section 4.2",
            0.36,
            gate_shares[name],
            between(0.22, 0.5),
            "",
            "0.1 to 0.5 m/s² with more than 10° of steering is hardly ever driven, 0.1 to 0.5 g often is.",
            cause=f"The paper's roads are not printed, and its limits are not those of its share: "
            f"{100.0 * gate_shares[named.BASELINE_GATED]:.1f} % of the time in m/s², "
            f"{100.0 * gate_shares[named.BASELINE_IN_G]:.1f} % in g.",
            irreproducible=True,
        )


def _claims_on_delay(sets: PaperSets, drives: Drives) -> Iterator[Claim]:
    windows = _windows(sets, drives, "Healthy", named.BASELINE)
    yield Claim(
        "paper.baseline-delay",
        "The observer's self-aligning torque lags behind that of the vehicle.",
        f"{SOURCE}, section 4.3, refinement 1",
        "lags",
        mean(np.array([window.delay for window in windows])),
        at_least(0.02),
        "s",
        "Peak of the correlation, fault-free drives. The delay is that of the observer's poles.",
    )
    plain = [variances(sets, drives, state, named.BASELINE) for state in ("Healthy", WORST)]
    for key, field, how in (
        ("realigned", "realigned", "delaying the vehicle's torque by the shift at which both correlate best"),
        ("warped", "warped", "dynamic time warping of every window, up to half a second"),
    ):
        moved = [
            joined(getattr(window, field) for window in _windows(sets, drives, state, named.BASELINE))
            for state in ("Healthy", WORST)
        ]
        yield Claim(
            f"paper.baseline-{key}",
            f"Realigning the two torques in time did not yield promising results: {how}.",
            f"{SOURCE}, section 4.3, refinement 1",
            "no gain",
            area_under_curve(*moved) - area_under_curve(*plain),
            at_most(0.02),
            "",
            f"Gain in AUC; {area_under_curve(*moved):.4f} with it, {area_under_curve(*plain):.4f} without. Median "
            f"variance of the healthy car {_median(moved[0]):.0f} with it, {_median(plain[0]):.0f} without.",
        )
