"""Kalman filter, linear time-varying and extended alike, for any discrete model.

`kernels.predict_covariance`, `kernels.correct` and their neighbours are its steps, and stand alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Model, Scalar, Tree, Truth, rebuild, require_discrete, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import maximum, present, where
from tierod.core.graph.trace import jacobian
from tierod.methods.estimators import kernels
from tierod.methods.estimators.shapes import (
    Belief,
    check_mean,
    check_names,
    check_variances,
    estimate_class,
    filled,
    leaf_names,
    leaf_values,
    sample_class,
)

COVARIANCE_UPDATES = ("schmidt", "printed")


class Prediction(NamedTuple):
    """The predicted estimate of a sample, before its measurements."""

    mean: kernels.Vector
    covariance: kernels.Vector
    points: Sequence[kernels.Vector] = ()  # sigma points for the correction, if the filter uses them


class Innovations(NamedTuple):
    """Innovations of measurements against a prediction."""

    rows: kernels.Matrix  # Jacobian of the outputs with respect to the state, m rows of n
    residuals: kernels.Vector  # measured minus expected output, (m,); NaN where missing
    known: kernels.Vector  # variance of each expected output, (m,)


@dataclass(frozen=True)
class KalmanFilter:
    """Extended Kalman filter with automatic Jacobians; for a linear model the Kalman filter itself.

    W = F P, P = W F' + Q + G diag(w) G', then one scalar update per output on a symmetric P, all linearised at the
    predicted mean, so that the order of the outputs does not matter.

    Valid while the model is nearly linear over a few standard deviations; compare with an unscented filter in doubt.
    The covariance stays positive in double precision while the initial variance of the measured quantity is below about
    1e12 times the measurement noise.

    A sample is `input`, `measured` and, with maskable states, `enabled` (0 to 1 each; missing counts as 0). A missing
    measurement is NaN: it corrects nothing. NaN never reaches the state.

    An estimate is `mean` and `variance` after the sample, `innovation` (measured minus expected from the past; NaN
    where missing) and `innovation_variance`, `nis` (over the outputs present) and `present`, their number.

    Source: R. E. Kalman, 1960, doi 10.1115/1.3662552; masks after S. F. Schmidt, 1966, and Mohtat et al., Table 3; gate
    after Chang, Journal of Geodesy 88 (2014) 391, for each measurement alone.
    """

    model: Model  # discrete model (`State`, `Input`, `Output`, `transition`, `output`)
    parameters: Tree  # of the model; its floats are tuning
    initial_mean: Tree  # state before the first sample, one float per state
    initial_variance: Tree  # its variance, one per state [unit of the state squared]
    process_noise: Tree  # variance added to each state per sample [unit squared]; None for a state without noise
    measurement_noise: Tree  # variance of each output [unit squared], greater than zero
    # variance of each input [unit squared], propagated to the state by G Q G' with G = d transition / d input; None
    # for an exact input, or for all of them
    input_noise: Tree = None
    # names of the states whose correction a sample can mask; all others are always corrected
    maskable: tuple[str, ...] = ()
    # effect of a mask e (0 to 1) on the covariance. "schmidt": consistent with the masked gain Ke = E K (consider
    # form, Joseph); "printed": P = (I - K C) P for every mask, as in Table 3 of Mohtat et al., which lets the
    # variance of a masked state shrink without information
    covariance_update: str = "schmidt"
    # whether inputs are checked for NaN. A sample with a missing input is left out: the mean is held, the variance
    # grows by the process noise. False only where an input hold comes first
    hold_missing_input: bool = True
    full_covariance: bool = False  # whether the estimate includes the packed covariance (needed for NEES)
    # bound of the squared innovation over its variance, a quantile of chi-square with one degree of freedom (10.83
    # for 99.9 %). For a measurement beyond, the noise is raised until it lies on the bound: the farther out it is,
    # the less it moves the estimate, and the filter never rejects all. None: no gate
    gate: Annotated[float, ""] | None = None

    def __post_init__(self) -> None:
        require_discrete(self.model)
        states, inputs = leaf_names(self.model.State), leaf_names(self.model.Input)
        check_variances("initial_variance", self.initial_variance, states)
        check_variances("process_noise", self.process_noise, states)
        check_variances("measurement_noise", self.measurement_noise, leaf_names(self.model.Output), positive=True)
        check_names("maskable", self.maskable, states)
        if self.input_noise is not None:
            check_variances("input_noise", self.input_noise, inputs)
        check_mean(self.initial_mean, states)
        if self.covariance_update not in COVARIANCE_UPDATES:
            raise ParameterError(
                f"covariance_update is '{self.covariance_update}'; expected {' or '.join(COVARIANCE_UPDATES)}"
            )

    @property
    def Sample(self) -> type:
        return sample_class(self.model, self.maskable)

    @property
    def Estimate(self) -> type:
        return estimate_class(self.model, self.full_covariance)

    def init(self) -> Belief:
        mean = rebuild(skeleton(self.model.State), leaf_values(self.initial_mean))
        return Belief(mean, kernels.from_diagonal(leaf_values(self.initial_variance)))

    def step(
        self,
        state: Belief,
        sample: Tree,
        *,
        process_noise: Tree = None,
        input_noise: Tree = None,
        measurement_noise: Tree = None,
    ) -> tuple[Belief, Tree]:
        """State and estimate after one sample: prediction with its inputs, correction with its measurements.

        Args: process_noise, input_noise, measurement_noise: variances of this sample where they vary; they replace
        those of the tuning and have None entries in the same places.
        """
        process = leaf_values(self.process_noise if process_noise is None else process_noise)
        entering = leaf_values(self.input_noise if input_noise is None else input_noise)
        noise = leaf_values(self.measurement_noise if measurement_noise is None else measurement_noise)
        predicted = self._predict(state, sample.input, process, entering)
        mask = self._mask(sample)
        start = kernels.unmasked_start(predicted.mean, mask)
        correction, innovation, spread = self._correct(predicted, sample, noise, start)
        mean = kernels.masked_mean(predicted.mean, correction.shift, mask)
        after = correction.covariance
        if self.covariance_update == "schmidt":
            after = kernels.consider(predicted.covariance, after, mask)
        nis, count = correction.nis, correction.present
        whole = kernels.usable(leaf_values(sample.input)) if self.hold_missing_input else True
        if whole is not True:
            mean = _select(whole, mean, leaf_values(state.mean))
            after = _select(whole, after, kernels.held_covariance(state.covariance, process))
            nis, count = where(whole, nis, 0.0), where(whole, count, 0.0)
        belief = Belief(rebuild(state.mean, mean), after)
        return belief, self._estimate(belief, innovation, spread, nis, count)

    def _predict(self, state: Belief, inputs: Tree, process: kernels.Noise, entering: kernels.Noise) -> Prediction:
        def transition(mean: Tree) -> Tree:
            return self.model.transition(mean, inputs, self.parameters)

        rows = jacobian(transition, state.mean)
        gain, variances = self._noise_gain(state.mean, inputs, entering)
        covariance = kernels.predict_covariance(rows, state.covariance, process, gain, variances)
        return Prediction(leaf_values(transition(state.mean)), covariance)

    def innovations(self, predicted: Prediction, sample: Tree) -> Innovations:
        """Innovations of a sample's measurements against a prediction."""

        def output(at: Tree) -> Tree:
            return self.model.output(at, sample.input, self.parameters)

        at = rebuild(skeleton(self.model.State), predicted.mean)
        rows = jacobian(output, at)
        pairs = zip(leaf_values(sample.measured), leaf_values(output(at)), strict=True)
        known = [kernels.quadratic(row, predicted.covariance) for row in rows]
        return Innovations(rows, tuple(measured - expected for measured, expected in pairs), known)

    def bounded_noise(self, noise: kernels.Vector, known: kernels.Vector, innovation: kernels.Vector) -> kernels.Vector:
        """Noise variance of every measurement, raised where its innovation lies beyond the gate."""
        if self.gate is None:
            return noise
        return tuple(_widened(self.gate, *each) for each in zip(noise, known, innovation, strict=True))

    def _correct(
        self, predicted: Prediction, sample: Tree, noise: kernels.Vector, start: kernels.Vector
    ) -> tuple[kernels.Correction, kernels.Vector, kernels.Vector]:
        rows, innovation, known = self.innovations(predicted, sample)
        noise = self.bounded_noise(noise, known, innovation)
        spread = tuple(kernels.plus(each, value) for each, value in zip(known, noise, strict=True))
        return kernels.correct(predicted.covariance, rows, innovation, noise, start), innovation, spread

    def _mask(self, sample: Tree) -> tuple[Truth, ...]:
        given = dict(zip(self.maskable, leaf_values(sample.enabled), strict=True)) if self.maskable else {}
        return kernels.clean_mask([given.get(name, True) for name in leaf_names(self.model.State)])

    def _noise_gain(self, mean: Tree, inputs: Tree, entering: kernels.Noise) -> tuple[kernels.Matrix, kernels.Vector]:
        if self.input_noise is None or all(variance is None for variance in entering):
            return (), ()
        noisy = {k: variance for k, variance in enumerate(entering) if variance is not None}
        rows = jacobian(lambda at: self.model.transition(mean, at, self.parameters), inputs)
        return [[row[k] for k in noisy] for row in rows], list(noisy.values())

    def _estimate(
        self, belief: Belief, innovation: kernels.Vector, spread: kernels.Vector, nis: Scalar, count: Scalar
    ) -> Tree:
        extra = belief.covariance if self.full_covariance else ()
        variance = kernels.diagonal(belief.covariance)
        return filled(self.Estimate, leaf_values(belief.mean), variance, innovation, spread, (nis, count), extra)


def _select(condition: Truth, taken: kernels.Vector, otherwise: kernels.Vector) -> tuple[Scalar, ...]:
    return tuple(where(condition, a, b) for a, b in zip(taken, otherwise, strict=True))


def _widened(gate: Scalar, noise: Scalar, known: Scalar, innovation: Scalar) -> Scalar:
    """Noise variance of a measurement, raised where its innovation lies beyond the gate; unchanged where missing."""
    return maximum(noise, where(present(innovation), innovation * innovation, 0.0) / gate - known)
