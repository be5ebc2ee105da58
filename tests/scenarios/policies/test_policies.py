"""Policies from files: they answer as where they were learnt, and a hostile file does nothing."""

import io
import json
import os
import pickle
import zipfile

import gymnasium
import numpy as np
import onnx
import pytest
import torch
from onnx import TensorProto, helper
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from scenarios.baselines.named import PilotError, pilot_of
from scenarios.environments import EnvironmentCfg, ObservationCfg
from scenarios.policies.description import PolicyError
from scenarios.policies.policy import digest, read_policy
from scenarios.policies.saving import describe_policy, save_policy

NAME = "AeroScene/Landing-v0"
CFG = EnvironmentCfg(action="velocity", action_hz=10)
N = 18


class Still(gymnasium.Env):
    """The spaces of an environment without a world, so that a model is made at once."""

    observation_space = gymnasium.spaces.Box(-100.0, 100.0, (N,), dtype=np.float32)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (4,), dtype=np.float32)

    def reset(self, *, seed=None, **_):
        super().reset(seed=seed)
        return self.observation_space.sample(), {}

    def step(self, _action):
        return self.observation_space.sample(), 0.0, False, False, {}


def model(kind=PPO, **options):
    return kind("MlpPolicy", Still(), seed=0, device="cpu", **options)


@pytest.fixture
def saved(tmp_path):
    save_policy(model(), tmp_path / "p.zip", NAME, CFG)
    return tmp_path / "p.zip"


def change(path, **facts):
    file = path.with_suffix(".json")
    file.write_text(json.dumps(json.loads(file.read_text()) | facts))


def with_weights(path, data):
    """The file with other content as its weights."""
    with zipfile.ZipFile(path) as archive:
        others = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in (others | {"policy.pth": data}).items():
            archive.writestr(name, content)


def packed(weights):
    buffer = io.BytesIO()
    torch.save(weights, buffer)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        (PPO, {}),
        (PPO, {"policy_kwargs": {"net_arch": [32], "activation_fn": torch.nn.ReLU}}),
        (SAC, {"policy_kwargs": {"net_arch": [32, 32]}, "buffer_size": 10}),
        (TD3, {"policy_kwargs": {"net_arch": [32, 32]}, "buffer_size": 10}),
    ],
)
def test_a_policy_answers_from_its_file_as_in_its_training(tmp_path, kind, options):
    learnt = model(kind, **options)
    with torch.no_grad():
        for parameter in learnt.policy.parameters():
            parameter.mul_(3.0)  # so that answers differ and some are beyond -1 to 1
    save_policy(learnt, tmp_path / "p.zip", NAME, CFG)
    read = read_policy(tmp_path / "p.zip")
    rng = np.random.default_rng(0)
    for observation in rng.normal(0.0, 3.0, (50, N)).astype(np.float32):
        wanted, _ = learnt.predict(observation, deterministic=True)
        np.testing.assert_allclose(read.action(observation), wanted, rtol=0, atol=1e-6)


def test_a_normalised_observation_is_normalised_here_too(tmp_path):
    worlds = VecNormalize(DummyVecEnv([Still]), clip_obs=2.0)
    learnt = PPO("MlpPolicy", worlds, seed=0, n_steps=64, batch_size=64, device="cpu").learn(64)
    save_policy(learnt, tmp_path / "p.zip", NAME, CFG)
    read = read_policy(tmp_path / "p.zip")
    for observation in np.random.default_rng(0).normal(0.0, 50.0, (9, N)).astype(np.float32):
        wanted, _ = learnt.predict(worlds.normalize_obs(observation), deterministic=True)
        np.testing.assert_allclose(read.action(observation), wanted, rtol=0, atol=1e-5)


def write_graph(path, n=N, outputs=4):
    """An ONNX graph whose action is the hyperbolic tangent of a product."""
    weight = np.random.default_rng(0).normal(size=(n, outputs)).astype(np.float32)
    nodes = [
        helper.make_node("MatMul", ["seen", "weight"], ["sum"]),
        helper.make_node("Tanh", ["sum"], ["action"]),
    ]
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("seen", TensorProto.FLOAT, ("batch", n))],
        [helper.make_tensor_value_info("action", TensorProto.FLOAT, ("batch", outputs))],
        [onnx.numpy_helper.from_array(weight, "weight")],
    )
    proto = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    path.write_bytes(proto.SerializeToString())
    return weight, proto


def test_a_graph_answers_as_its_numbers_say(tmp_path):
    weight, _ = write_graph(tmp_path / "p.onnx")
    describe_policy(tmp_path / "p.onnx", NAME, CFG)
    read = read_policy(tmp_path / "p.onnx")
    seen = np.random.default_rng(1).normal(size=N).astype(np.float32)
    np.testing.assert_allclose(read.action(seen), np.tanh(seen @ weight), atol=1e-6)


def test_a_graph_of_other_shapes_or_with_weights_elsewhere_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "p.onnx"
    for n, outputs, reason in (
        (N - 1, 4, "inputs are seen float"),
        (N, 3, "outputs are action float"),
    ):
        write_graph(path, n, outputs)
        with pytest.raises(PolicyError, match=reason) as caught:
            describe_policy(path, NAME, CFG)
        assert "\n" not in str(caught.value)
    _, proto = write_graph(path)
    (tmp_path / "secret").write_bytes(bytes(4 * 4 * N))
    tensor = proto.graph.initializer[0]
    tensor.ClearField("raw_data")
    tensor.data_location = TensorProto.EXTERNAL
    entry = tensor.external_data.add()
    entry.key, entry.value = "location", "secret"
    path.write_bytes(proto.SerializeToString())
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PolicyError, match="no ONNX graph that can fly"):
        read_policy(path)


class Owned:
    """A pickle that leaves a file behind if it is loaded."""

    def __init__(self, mark):
        self.mark = str(mark)

    def __reduce__(self):
        return os.mkdir, (self.mark,)


def test_nothing_that_a_file_holds_is_executed(saved, tmp_path):
    mark = tmp_path / "owned"
    pickle.loads(pickle.dumps(Owned(tmp_path / "works")))
    assert (tmp_path / "works").is_dir()  # the trap would catch a loader that runs pickles
    # In the entries that are never read it may lie; as weights it is refused.
    with zipfile.ZipFile(saved, "a") as archive:
        archive.writestr("pytorch_variables.pth.more", pickle.dumps(Owned(mark)))
    read_policy(saved).action(np.zeros(N, np.float32))
    for data in (pickle.dumps(Owned(mark)), packed({"action_net.weight": Owned(mark)})):
        with_weights(saved, data)
        with pytest.raises(PolicyError, match="valid") as caught:
            read_policy(saved)
        assert "\n" not in str(caught.value)
    assert not mark.exists()


def test_weights_that_unpack_without_end_are_refused(saved):
    with_weights(saved, bytes(65 << 20))
    assert saved.stat().st_size < 1 << 20
    with pytest.raises(PolicyError, match="holds more than 64 MiB"):
        read_policy(saved)
    # Tensors that are compressed a second time, which torch itself would unpack.
    plain, buffer = zipfile.ZipFile(io.BytesIO(packed({"a": torch.zeros(1 << 22)}))), io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in plain.namelist():
            archive.writestr(name, plain.read(name))
    assert len(buffer.getvalue()) < 1 << 20
    with_weights(saved, buffer.getvalue())
    with pytest.raises(PolicyError, match="compressed within"):
        read_policy(saved)


def test_tensors_of_other_shapes_kinds_and_values_are_refused(saved):
    good = torch.load(
        io.BytesIO(zipfile.ZipFile(saved).read("policy.pth")), weights_only=True, map_location="cpu"
    )
    one = torch.zeros(1)
    for change_of, reason in (
        ({"action_net.weight": torch.zeros(3, 64)}, r"of shape \(3, 64\)"),
        ({"action_net.bias": torch.zeros(4, dtype=torch.float64)}, "is float64"),
        ({"action_net.bias": torch.full((4,), torch.nan)}, "not finite"),
        ({"mlp_extractor.policy_net.0.weight": one.expand(1 << 30, N)}, "valid: float32"),
        ({"action_net.bias": torch.zeros(4, device="meta")}, "valid: float32"),
        ({"mlp_extractor.policy_net.2.bias": "text"}, "has no tensor"),
    ):
        with_weights(saved, packed({**good, **change_of}))
        with pytest.raises(PolicyError, match=reason) as caught:
            read_policy(saved)
        assert "\n" not in str(caught.value)
    with_weights(saved, packed(good))
    read_policy(saved)


def test_a_description_that_does_not_fit_is_refused_in_one_line(saved):
    whole = saved.with_suffix(".json").read_text()
    more = {"state": "true", "target": True, "depth": [64, 64]}
    layers = {"layers": ["action_net"] * 17, "activation": "tanh", "is_squashed": False}
    for facts, reason in (
        ({"environment": "AeroScene/Fly-v0"}, "environment is 'AeroScene/Fly-v0'; valid: "),
        ({"task": "hover"}, "task is 'hover'; valid: landing"),
        ({"action": "wings"}, "action = 'wings'"),
        ({"action_hz": 7}, "action_hz = 7"),
        ({"observation": {"colour": True}}, "observation.colour"),
        ({"observation": {"state": "none"}}, "layout is"),
        ({"observation": more}, "no network of numbers alone"),
        ({"layout": [["velocity", 3], ["target", 3]]}, "layout is"),
        ({"network": None}, "no network of numbers alone"),
        ({"network": layers}, "17 layers"),
        ({"scaling": {"mean": [0.0], "std": [1.0], "clip": 1.0}}, "scaling.mean has 1 numbers"),
        ({"format": 2}, "format is 2"),
        ({"code": "x"}, "unknown field"),
    ):
        change(saved, **facts)
        with pytest.raises(PolicyError, match=reason) as caught:
            read_policy(saved)
        assert "\n" not in str(caught.value)
        saved.with_suffix(".json").write_text(whole)
    saved.with_suffix(".json").write_text("[" * 100_000)
    with pytest.raises(PolicyError, match="description"):
        read_policy(saved)


def test_a_policy_is_a_pilot_by_its_file(saved, tmp_path):
    assert pilot_of(f"policy:{saved}").make.sees_plant
    first = digest(saved)
    change(saved, action_hz=250)
    assert digest(saved) != first
    for name, reason in (
        (saved, "up to 50 times a second"),
        (tmp_path / "absent.zip", "cannot be read"),
        (tmp_path, "valid: FILE.zip"),
    ):
        with pytest.raises(PilotError, match=reason) as caught:
            pilot_of(f"policy:{name}")
        assert "\n" not in str(caught.value)
    change(saved, action="motors", action_hz=10)
    with pytest.raises(PilotError, match="no autopilot takes rotor speeds"):
        pilot_of(f"policy:{saved}")


def test_a_model_that_could_not_be_flown_is_not_saved_silently(tmp_path):
    for name, task, reason in (
        ("AeroScene/Fly-v0", None, "environment is"),
        (NAME, "hover", "task of"),
    ):
        with pytest.raises(PolicyError, match=reason):
            save_policy(model(), tmp_path / "p.zip", name, CFG, task=task)
    other = EnvironmentCfg(observation=ObservationCfg(imu=True))
    with pytest.raises(PolicyError, match="shape"):
        save_policy(model(), tmp_path / "p.zip", NAME, other)
