"""Networks of ONNX files, which onnxruntime computes.

The graph is asked for its inputs and outputs before anything flies. It is neither simplified nor
run then: a hostile graph could ask for any amount of memory, which only the process of a trial may
lose.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scenarios.policies.description import PolicyError

NUMBERS = "numbers"
"""Name of the part of an observation that has no image."""
_FLOATS = "tensor(float)"
_FOLDER_OF_WEIGHTS = "session.model_external_initializers_file_folder_path"
_TYPES = {"classes": "tensor(uint8)", "objects": "tensor(int32)"}
"""Types of the parts that are no floats."""


def read_graph(
    path: Path, data: bytes, shapes: Mapping[str, tuple[int, ...]], n_outputs: int
) -> Callable[[Mapping[str, np.ndarray]], np.ndarray]:
    """Return the function of an observation that an ONNX file holds.

    Args:
        path: Its name, for messages.
        data: Its content.
        shapes: Shape of each part of an observation by its name. An observation of numbers alone is
            the graph's only input, whatever that is called.
        n_outputs: Size of an action.

    Raises:
        PolicyError: If there is no onnxruntime, or the graph has other inputs or outputs.
    """
    session = _session(path, data)
    inputs, outputs = session.get_inputs(), session.get_outputs()
    names = _input_names(path, inputs, shapes)
    if len(outputs) != 1 or not _fits(outputs[0], _FLOATS, (n_outputs,)):
        raise PolicyError(
            f"policy {str(path)!r}: its outputs are {_shown(outputs)}; "
            f"valid: one of float [1, {n_outputs}]"
        )

    def act(observation: Mapping[str, np.ndarray]) -> np.ndarray:
        given = {names[part]: value[None] for part, value in observation.items()}
        return np.asarray(session.run(None, given)[0])[0]

    return act


def _session(path: Path, data: bytes) -> Any:
    """Open a graph on one thread, so that a campaign's processes do not crowd each other.

    Raises:
        PolicyError: If there is no onnxruntime, or the file is no graph that it knows.
    """
    try:
        import onnxruntime
    except ModuleNotFoundError:
        raise PolicyError(
            f"policy {str(path)!r} needs onnxruntime, which is not installed; "
            "pip install 'aeroscene[rl]'"
        ) from None
    onnxruntime.disable_telemetry_events()
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    # Simplifying a graph computes parts of it already.
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
    options.log_severity_level = 4
    # Weights in further files are looked for in a folder that does not exist.
    nowhere = os.fspath(path.parent / f".{path.name}.nowhere")
    options.add_session_config_entry(_FOLDER_OF_WEIGHTS, nowhere)
    try:
        return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # noqa: BLE001 - its errors have no common kind of their own
        reason = " ".join(str(error).split())[:200]
        raise PolicyError(f"policy {str(path)!r} is no ONNX graph that can fly: {reason}") from None


def _input_names(
    path: Path, inputs: Sequence[Any], shapes: Mapping[str, tuple[int, ...]]
) -> dict[str, str]:
    """Return the name of the input for each part of an observation.

    Raises:
        PolicyError: If a part has none, or there are others, or one has another shape.
    """
    by_name = {each.name: each for each in inputs}
    if tuple(shapes) == (NUMBERS,) and len(inputs) == 1:
        by_name = {NUMBERS: inputs[0]}
    fits = by_name.keys() == shapes.keys() and all(
        _fits(by_name[part], _TYPES.get(part, _FLOATS), shape) for part, shape in shapes.items()
    )
    if not fits:
        valid = ", ".join(
            f"{part} {_kind(_TYPES.get(part, _FLOATS))} [1, {_joined(shape)}]"
            for part, shape in shapes.items()
        )
        raise PolicyError(f"policy {str(path)!r}: its inputs are {_shown(inputs)}; valid: {valid}")
    return {part: each.name for part, each in by_name.items()}


def _fits(node: Any, kind: str, shape: tuple[int, ...]) -> bool:
    """Return whether an input or output takes one row of a shape; symbolic sizes fit any."""
    sizes = (1, *shape)
    return (
        node.type == kind
        and len(node.shape) == len(sizes)
        and all(
            not isinstance(given, int) or given == size
            for given, size in zip(node.shape, sizes, strict=True)
        )
    )


def _shown(nodes: Sequence[Any]) -> str:
    return ", ".join(
        f"{node.name[:40]} {_kind(node.type)} [{_joined(node.shape)}]" for node in nodes[:8]
    )


def _kind(name: str) -> str:
    return name.removeprefix("tensor(").removesuffix(")")


def _joined(sizes: Sequence[Any]) -> str:
    return ", ".join("?" if size is None else str(size)[:20] for size in sizes)
