from aeroscene.learning.training.journal import (
    LOG,
    append_line,
    forget_after,
    held_out_losses,
    least_held_out_at,
    read_log,
)


def test_lines_come_back_in_order(tmp_path):
    lines = [{"stage": "denoiser", "step": step, "total": 0.5} for step in (1, 2, 3)]
    for line in lines:
        append_line(tmp_path, line)
    assert list(read_log(tmp_path)) == lines


def test_folder_without_a_log_has_no_lines(tmp_path):
    assert list(read_log(tmp_path)) == []
    forget_after(tmp_path, "denoiser", 0)
    assert list(read_log(tmp_path)) == []


def test_line_cut_short_and_lines_that_are_no_records_are_left_out(tmp_path):
    (tmp_path / LOG).write_text('{"step": 1}\n7\n{"step": 2}\n{"ste')
    assert [line["step"] for line in read_log(tmp_path)] == [1, 2]


def test_only_later_lines_of_the_same_stage_are_forgotten(tmp_path):
    for stage, step in (("skeleton", 9), ("denoiser", 1), ("denoiser", 2), ("denoiser", 3)):
        append_line(tmp_path, {"stage": stage, "step": step})
    forget_after(tmp_path, "denoiser", 2)
    kept = [(line["stage"], line["step"]) for line in read_log(tmp_path)]
    assert kept == [("skeleton", 9), ("denoiser", 1), ("denoiser", 2)]


def test_when_the_held_out_loss_was_least(tmp_path):
    assert least_held_out_at(tmp_path) is None
    for stage, losses in (("writer", (3.0, 2.0, 2.5, 2.6)), ("denoiser", (1.0, 0.9, 0.8, 0.85))):
        for number, loss in enumerate(losses, 1):
            is_best = loss == min(losses[:number])
            line = {"stage": stage, "step": 100 * number, "held_out": loss, "is_best": is_best}
            append_line(tmp_path, line)
            append_line(tmp_path, {"stage": stage, "step": 100 * number + 10, "total": loss})
    assert least_held_out_at(tmp_path) == 0.75


def test_looks_at_the_held_out_loss_have_the_time_of_the_step_before_them(tmp_path):
    for stage, seconds, loss in (("prior", 2.0, 0.9), ("denoiser", 5.0, 3.0), ("denoiser", 9.0, 2)):
        append_line(tmp_path, {"stage": stage, "step": 1, "seconds": seconds, "total": loss})
        append_line(tmp_path, {"stage": stage, "step": 1, "held_out": loss, "is_best": True})
    assert held_out_losses(tmp_path) == {"prior": [(2.0, 0.9)], "denoiser": [(5.0, 3.0), (9.0, 2)]}
