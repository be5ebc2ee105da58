import torch
from torch import nn

from aeroscene.learning.training.average import MovingAverage


def test_average_follows_as_its_formula_says():
    model = nn.Linear(2, 1)
    average = MovingAverage(model, 0.9)
    expected = model.weight.detach().clone()
    for step in range(1, 400):
        with torch.no_grad():
            model.weight.fill_(float(step % 7))
        average.update(step)
        decay = min(0.9, (1 + step) / (10 + step))
        expected = decay * expected + (1 - decay) * model.weight.detach()
    torch.testing.assert_close(average.weights["weight"], expected)


def test_decay_of_nothing_is_the_model_itself():
    model = nn.Sequential(nn.Linear(3, 3), nn.BatchNorm1d(3))
    average = MovingAverage(model, 0.0)
    model(torch.randn(8, 3))
    with torch.no_grad():
        model[0].weight.add_(1.0)
    average.update(1)
    for name, value in model.state_dict().items():
        torch.testing.assert_close(average.weights[name], value)


def test_counters_are_copied_not_averaged():
    model = nn.BatchNorm1d(2)
    average = MovingAverage(model, 0.99)
    for step in range(1, 4):
        model(torch.randn(4, 2))
        average.update(step)
    assert average.weights["num_batches_tracked"] == 3
