import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from report_pages import unpack
from tierod.core.decimation import Decimator, coarser, pack
from tierod.core.findings import Trace


def made(count, seed=0, scale=1.0, offset=0.0):
    rng = np.random.default_rng(seed)
    mean = scale * rng.normal(size=count).cumsum() + offset
    mean[rng.random(count) < 0.1] = np.nan
    return Trace("a", "m", 3.0 + 0.25 * np.arange(count), mean - scale * rng.random(count), mean + scale, mean)


@pytest.mark.parametrize("count", [0, 1, 2, 1000])
@pytest.mark.parametrize("bits", [2, 12, 16])
@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (1e-9, 7.0), (1e300, 0.0), (0.0, 4.0), (1e-320, 0.0)])
def test_what_is_packed_comes_back_but_for_the_rounding(count, bits, scale, offset):
    whole = made(count, scale=scale, offset=offset)
    again = unpack(pack(whole, bits))
    assert (again.name, again.unit) == ("a", "m")
    np.testing.assert_allclose(again.time, whole.time, rtol=1e-12)
    for part in ("lower", "mean", "upper"):
        one, other = getattr(again, part), getattr(whole, part)
        np.testing.assert_array_equal(np.isfinite(one), np.isfinite(other))
        if np.isfinite(other).any():
            most = max(np.nanmax(np.abs(whole.upper)), np.nanmax(np.abs(whole.lower)))
            spread = np.nanmax(whole.upper / 2) - np.nanmin(whole.lower / 2)
            room = 1.01 * spread / (2**bits - 2) + 1e-11 * most + 1e-318
            assert np.nanmax(np.abs(one - other)) <= room
    assert not np.any(again.lower > again.mean)
    assert not np.any(again.mean > again.upper)


@given(st.integers(0, 300), st.integers(1, 40))
def test_a_coarser_level_hides_nothing(count, step):
    whole = made(count)
    level = coarser(whole, step)
    assert len(level.time) == -(-count // step)
    for place in range(len(level.time)):
        part = slice(place * step, (place + 1) * step)
        if np.isfinite(whole.mean[part]).any():
            assert level.lower[place] == np.nanmin(whole.lower[part])
            assert level.upper[place] == np.nanmax(whole.upper[part])
            assert level.mean[place] == pytest.approx(np.nanmean(whole.mean[part]))
        else:
            assert np.isnan(level.mean[place])


@pytest.mark.parametrize("missing", [0.0, 0.3])
def test_every_bin_is_what_its_samples_say(missing):
    chance = np.random.default_rng(4)
    time = np.cumsum(chance.choice([0.01, 0.02, 0.4], 5000, p=[0.8, 0.15, 0.05]))
    first, second = np.where(chance.random((2, 5000)) < missing, np.nan, chance.normal(size=(2, 5000)))
    one, other = Decimator("one", "", bins=64), Decimator("other", "", bins=64)
    for part in np.split(np.arange(5000), [700, 701, 2400]):
        other.add(time[part], second[part], one.add(time[part], first[part]))
    for decimator, values in ((one, first), (other, second)):
        trace = decimator.trace()
        width = trace.time[1] - trace.time[0]
        bins = np.floor((time - time[0]) / width + 1e-6).astype(int)
        for at in range(len(trace.time)):
            inside = values[(bins == at) & np.isfinite(values)]
            found = trace.lower[at], trace.mean[at], trace.upper[at]
            expected = (inside.min(), inside.mean(), inside.max()) if len(inside) else (np.nan,) * 3
            assert found == pytest.approx(expected, rel=1e-12, nan_ok=True)
