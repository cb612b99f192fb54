import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.diagnosis.debounce import DebounceCounter, DebounceCounters


def run(block, results):
    state, outputs = block.init(), []
    for result in results:
        state, output = block.step(state, DebounceCounter.Sample(result))
        outputs.append(output)
    return outputs


def test_it_fails_after_127_and_passes_after_128_results_and_is_clamped():
    counters = run(DebounceCounter(), [1.0] * 200)
    assert [output.verdict for output in counters].index(1.0) == 126
    assert counters[-1].counter == 127.0
    back = run(DebounceCounter(jump=False), [1.0] * 200 + [-1.0] * 400)
    assert [output.verdict for output in back].index(-1.0) == 200 + 254
    assert back[-1].counter == -128.0


def test_a_verdict_holds_until_the_other_end_is_reached():
    outputs = run(DebounceCounter(increment=127.0, decrement=1.0, jump=False), [1.0] + [-1.0] * 254)
    assert all(output.verdict == 1.0 for output in outputs)
    assert outputs[-1].counter == -127.0


def test_a_change_of_direction_goes_through_zero_at_once():
    outputs = run(DebounceCounter(), [1.0] * 100 + [-1.0])
    assert outputs[-1].counter == -1.0


@pytest.mark.parametrize("none", [0.0, float("nan")])
def test_without_a_result_the_counter_is_frozen(none):
    outputs = run(DebounceCounter(), [1.0] * 50 + [none] * 1000 + [1.0] * 77)
    assert outputs[-2].verdict == 0.0
    assert outputs[-1].verdict == 1.0


def test_a_consequence_stands_still_while_its_cause_has_failed():
    bank = DebounceCounters((DebounceCounter(127.0, 128.0), DebounceCounter(1.0, 1.0)), ((), (0,)))
    results = np.array([[-1.0, 1.0]] * 60 + [[1.0, 1.0]] * 100 + [[-1.0, 1.0]] * 66)
    done = scan(bank, results)
    assert done["verdict_1"][-1] == 0.0
    # 61 results count before the cause has failed, 65 after it has passed; the next one makes 127.
    more = scan(bank, np.array([[-1.0, 1.0]]), done.state)
    assert more["verdict_1"][-1] == 1.0


@pytest.mark.parametrize("fields", [{"increment": 0.0}, {"decrement": -1.0}, {"increment": 300.0}])
def test_steps_that_cannot_be_are_refused(fields):
    with pytest.raises(ParameterError, match="expected more than 0"):
        DebounceCounter(**fields)


def test_a_cause_that_does_not_exist_is_refused():
    with pytest.raises(ParameterError, match="places from 0 to 0"):
        DebounceCounters((DebounceCounter(),), ((1,),))
