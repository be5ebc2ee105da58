from dataclasses import replace

import pytest
import torch

from aeroscene.learning.training import course
from aeroscene.learning.training.checkpoint import read_checkpoint, under
from aeroscene.learning.training.config import Budget, TrainingError
from aeroscene.learning.training.data import prepared
from aeroscene.learning.training.journal import read_log
from aeroscene.learning.training.procedure import CHECKPOINT, Training
from aeroscene.learning.training.same_data import taken_parts
from aeroscene.learning.training.state import read_state
from aeroscene.learning.training.state_head import STATE
from tests.aeroscene.learning.training.conftest import Watcher, small_sections


def weights(plan):
    return read_checkpoint(plan.folder / CHECKPOINT).parts


def assert_equal(left, right):
    assert left.keys() == right.keys()
    for part in left:
        assert left[part].keys() == right[part].keys()
        for name, value in left[part].items():
            torch.testing.assert_close(value, right[part][name], rtol=0, atol=0)


def test_training_stopped_and_resumed_twice_equals_an_unbroken_one(plan, tmp_path):
    assert Training(plan, Watcher()).run()
    broken = replace(plan, folder=tmp_path / "broken")
    assert not Training(broken, Watcher(stop_after=3)).run()
    for stop_after in (2, None):
        state = read_state(broken.folder / STATE)
        is_done = Training(broken, Watcher(stop_after)).run(state)
        assert is_done == (stop_after is None)
    assert_equal(weights(plan), weights(broken))


def test_stop_while_the_writer_learns_resumes_to_the_same_weights(plan, tmp_path):
    assert Training(plan, Watcher()).run()
    broken = replace(plan, folder=tmp_path / "broken")
    assert not Training(broken, Watcher(stop_after=1, stage="writer")).run()
    assert set(weights(broken)) == {"writer"}
    assert Training(broken, Watcher()).run(read_state(broken.folder / STATE))
    assert_equal(weights(plan), weights(broken))


def test_other_seed_gives_other_weights(plan, tmp_path):
    Training(plan, Watcher()).run()
    sections = small_sections(plan.data, seed=1)
    other = replace(plan, folder=tmp_path / "other", sections=sections)
    Training(other, Watcher()).run()
    mine, theirs = weights(plan)["denoiser"], weights(other)["denoiser"]
    assert any((mine[name] != theirs[name]).any() for name in mine)


def test_longer_budget_goes_on_from_the_end_of_a_shorter_one(plan):
    Training(plan, Watcher()).run()
    longer = replace(plan, budgets={**plan.budgets, "denoiser": Budget(steps=12)})
    assert Training(longer, Watcher()).run(read_state(plan.folder / STATE))
    facts = read_checkpoint(plan.folder / CHECKPOINT).facts
    assert facts.training["steps"] == 12
    steps = [line["step"] for line in read_log(plan.folder) if "total" in line]
    assert steps[-4:] == [6, 8, 10, 12]


def test_log_after_resuming_has_no_line_twice(plan):
    Training(plan, Watcher(stop_after=4)).run()
    state = read_state(plan.folder / STATE)
    # Steps taken after the last save, then lost.
    with (plan.folder / "log.jsonl").open("a") as file:
        file.write('{"stage": "denoiser", "step": 6, "total": 9.0}\n{"stage": "den')
    Training(plan, Watcher()).run(state)
    lines = [(line["stage"], line["step"]) for line in read_log(plan.folder) if "total" in line]
    assert lines == [("writer", 2), ("writer", 3), *(("denoiser", k) for k in (2, 4, 6, 8))]


def test_checkpoint_says_what_it_was_trained_on_and_by_what(plan):
    Training(plan, Watcher()).run()
    facts = read_checkpoint(plan.folder / CHECKPOINT).facts
    assert facts.data.digest == plan.data.source.digest
    assert facts.data.n_scenes == 4
    assert facts.configs["training"]["batch_size"] == 4
    assert facts.configs["model"]["n_kinds"] == len(plan.data.train.language.vocabulary.kinds)
    assert facts.code.startswith("0.")
    assert facts.training["steps"] == 8
    assert facts.training["held_out_loss"] > 0
    assert facts.training["held_out_skipped"] == 0


def test_progress_reaches_one_in_every_stage(plan):
    watcher = Watcher()
    Training(plan, watcher).run()
    last = dict(watcher.seen)
    assert list(last) == ["writer", "denoiser"]
    assert all(share >= 1.0 for share in last.values())


def test_parts_of_another_training_are_taken_over(plan, tmp_path):
    first = replace(plan, parts=("writer",))
    Training(first, Watcher()).run()
    taken = taken_parts(first.folder / CHECKPOINT, plan.data, ("denoiser",))
    second = replace(plan, folder=tmp_path / "b", parts=("denoiser",), taken=taken)
    Training(second, Watcher()).run()
    assert set(weights(second)) == {"writer", "denoiser"}
    whole = replace(plan, folder=tmp_path / "whole")
    Training(whole, Watcher()).run()
    assert_equal(weights(whole), weights(second))


def test_other_data_is_refused_when_resuming_or_taking(plan, small_scenes):
    Training(plan, Watcher(stop_after=1)).run()
    other = prepared("fewer", small_scenes[:3], [])
    state = read_state(plan.folder / STATE)
    with pytest.raises(TrainingError, match=r"data 'fewer' .3 scenes.* valid: the same data"):
        Training(replace(plan, data=other), Watcher()).run(state)
    with pytest.raises(TrainingError, match="is of other data"):
        taken_parts(plan.folder / CHECKPOINT, other, ("denoiser",))


def test_weights_that_are_not_finite_leave_the_last_save_as_it_was(plan):
    training = Training(plan, Watcher(stop_after=2))
    training.run()
    before = (plan.folder / CHECKPOINT).read_bytes(), (plan.folder / STATE).read_bytes()
    next(iter(training.trainings["denoiser"].average.weights.values())).fill_(torch.nan)
    with pytest.raises(TrainingError, match="not finite after step 2"):
        training.save()
    assert ((plan.folder / CHECKPOINT).read_bytes(), (plan.folder / STATE).read_bytes()) == before


def losses_of(monkeypatch, *losses):
    """Held-out losses as they are found, one a look."""
    found = iter(losses)
    real = course.held_out_loss

    def loss(training, data, loss):
        return (
            next(found)
            if data is not None and hasattr(data, "language")
            else real(training, data, loss)
        )

    monkeypatch.setattr(course, "held_out_loss", loss)


def average_after(plan, step):
    """The average after so many steps, as another training of the same has it."""
    folder = plan.folder.with_name(f"until-{step}")
    plan = replace(plan, folder=folder, sections=looking(plan, 1000))
    Training(plan, Watcher(stop_after=step)).run()
    return last_average(plan)


def last_average(plan):
    average = under(read_state(plan.folder / STATE).tensors, "denoiser.average.")
    return {name: v.half().float() if v.is_floating_point() else v for name, v in average.items()}


def looking(plan, steps, **more):
    training = replace(plan.sections["training"], look_steps=steps, **more)
    return {**plan.sections, "training": training}


def test_checkpoint_has_the_weights_with_the_least_held_out_loss(plan, monkeypatch):
    losses_of(monkeypatch, 0.9, 0.5, 0.7, 0.6)
    Training(replace(plan, sections=looking(plan, 2)), Watcher()).run()
    found = read_checkpoint(plan.folder / CHECKPOINT)
    wanted = average_after(plan, 4)
    assert_equal({"denoiser": found.parts["denoiser"]}, {"denoiser": wanted})
    facts = found.facts.training
    assert (facts["held_out_loss"], facts["held_out_least"]) == (0.5, 0.5)
    assert (facts["steps"], facts["held_out_least_step"]) == (8, 4)
    marked = [
        line["step"]
        for line in read_log(plan.folder)
        if line.get("is_best") and line["stage"] == "denoiser"
    ]
    assert marked == [2, 4]


def test_best_weights_outlive_a_stop_and_training_goes_on_from_the_last(
    plan, tmp_path, monkeypatch
):
    plan = replace(plan, sections=looking(plan, 2))
    losses = (0.9, 0.5, 0.7, 0.6)
    losses_of(monkeypatch, *losses)
    Training(plan, Watcher()).run()
    broken = replace(plan, folder=tmp_path / "broken")
    losses_of(monkeypatch, *losses)
    assert not Training(broken, Watcher(stop_after=5)).run()
    state = read_state(broken.folder / STATE)
    head = state.heads["denoiser"]
    assert (head.best_step, head.best_loss, head.step) == (4, 0.5, 5)
    assert Training(broken, Watcher()).run(state)
    assert_equal(weights(plan), weights(broken))
    left, right = (read_state(each.folder / STATE).tensors for each in (plan, broken))
    assert all(torch.equal(value, right[name]) for name, value in left.items())


def test_last_weights_can_be_kept_and_it_is_said_where_they_were_best(plan, monkeypatch):
    losses_of(monkeypatch, 0.9, 0.5, 0.7, 0.6)
    Training(replace(plan, sections=looking(plan, 2, keep="last")), Watcher()).run()
    found = read_checkpoint(plan.folder / CHECKPOINT)
    wanted = last_average(plan)
    assert_equal({"denoiser": found.parts["denoiser"]}, {"denoiser": wanted})
    facts = found.facts.training
    assert (facts["held_out_loss"], facts["held_out_least"]) == (0.6, 0.5)
    assert facts["held_out_least_step"] == 4
