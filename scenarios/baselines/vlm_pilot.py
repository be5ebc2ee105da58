"""Pilot that a vision-language model steers: it looks around, asks, and flies as the model says.

The model is behind any address that speaks `chat/completions` as OpenAI's does. Simulated time
stands still while it thinks, so that slow models are not punished. The adapter adds little of its
own, because the model is to be judged: straight lines, a stop before obstacles in the depth image,
and the autopilot's landing.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from autonomy.perception import DepthImage
from autonomy.types import FlatReference, Vector3, vector3
from flightsim.mavlink.client import MavlinkClient
from flightsim.testbench import TestbenchError
from scenarios.baselines.offboard import TICK_S, fly_line, land, take_control
from scenarios.baselines.vlm_answers import (
    AGAIN,
    AnswerError,
    Choice,
    Question,
    read_choice,
    schema,
)
from scenarios.chat.completions import ChatModel, ask_model
from scenarios.pilot.depth_frames import NoDepthError, camera_mount, posed_image
from scenarios.run.companion import Aboard
from scenarios.trials.verdict import Verdict

MOST_LOOKS = 8
N_VIEWS = 6
"""Views ahead in one look around, 60 degrees apart."""
_TAKEOFF_M, _CLIMB_M, _HOVER_M = 2.5, 3.0, 2.5
_TURN_S = 1.4
"""Time for a turn from one view to the next."""
_STEP_M, _ROOM_M, _LEAST_STEP_M = 8.0, 2.0, 0.5
"""Longest step, distance to keep from surfaces in the depth image, and shortest step."""
_SPEED_MPS = 2.0
_ABOUT_PX = 2
"""Pixels on each side of a point whose median depth counts."""


class _View(NamedTuple):
    """A camera image with its depth."""

    rgb: np.ndarray
    depth: DepthImage | None
    """Depth image with its pose; None if nothing was measured."""


class VlmPilot:
    """A `scenarios.Companion` that asks a vision-language model where to go.

    Attributes:
        touchdown_enu_m: Point that the model chose to land on; None before.
    """

    area = None

    def __init__(self, chat: ChatModel, environment: Mapping[str, str], aboard: Aboard) -> None:
        """Prepare a flight.

        Args:
            chat: Model to ask.
            environment: Variables among which its key is looked for.
            aboard: Equipment: MAVLink, two cameras, and the text.

        Raises:
            TestbenchError: If the goal is not in words.
        """
        if not aboard.text:
            raise TestbenchError(
                "pilot vlm reads a text, and the goal is an area; "
                "valid: goals naming, relation or chain"
            )
        self.touchdown_enu_m: Vector3 | None = None
        self.verdict = Verdict(success=False, reason="not finished")
        self.is_done = False
        self._chat, self._environment, self._aboard = chat, environment, aboard
        self._client: MavlinkClient = aboard.client
        self._flight = self._fly()

    def update(self, time_us: int) -> None:
        """Read telemetry, and do the next step of the flight.

        Args:
            time_us: Simulated time.
        """
        self._client.update(time_us)
        self.is_done = self.is_done or next(self._flight, self) is self

    def _fly(self) -> Iterator[None]:
        """Fly from take-off to landing; each step is a tick."""
        x, y, z = start = yield from take_control(self._client)
        at: Vector3 = (x, y, z + _TAKEOFF_M)
        yield from fly_line(self._client, start, at, _SPEED_MPS)
        note, reason = "", f"found no place in {MOST_LOOKS} looks"
        for _ in range(MOST_LOOKS):
            views = yield from self._look_around(at)
            try:
                choice = self._ask(views, note)
            except AnswerError as error:
                reason = f"the model's answer is not understood: {error}"
                break
            if choice.action == "give_up":
                reason = "the model gave up"
                break
            goal, note = _goal(choice, views, at)
            if goal is None:
                continue  # The look counts, so a model cannot ask for ever.
            if choice.action == "land":
                yield from self._land_on(at, goal)
                return
            yield from fly_line(self._client, at, goal, _SPEED_MPS)
            at = goal
        yield from land(self._client)
        self.verdict = Verdict(success=False, reason=reason)

    def _look_around(self, at: Vector3) -> Generator[None, None, list[_View]]:
        """Turn once about the vertical, and take the views, the one straight down last."""
        views: list[_View] = []
        for number in range(N_VIEWS):
            # Clockwise from north.
            yaw_rad = math.pi / 2 - 2 * math.pi * number / N_VIEWS
            yield from self._hold(at, yaw_rad)
            views.append(self._view("forward"))
        # The top of the view down is ahead of the vehicle, so it faces north for it.
        yield from self._hold(at, math.pi / 2)
        views.append(self._view("down"))
        yield from self._hold(at, 0.0)
        return views

    def _hold(self, at: Vector3, yaw_rad: float) -> Iterator[None]:
        reference = FlatReference(position_enu_m=at, yaw_rad=math.remainder(yaw_rad, 2 * math.pi))
        for _ in range(round(_TURN_S / TICK_S)):
            self._client.send_setpoint(reference)
            yield

    def _view(self, camera: str) -> _View:
        frame = self._aboard.render(camera)
        mount = camera_mount(self._aboard.airframe, camera)
        try:
            return _View(frame.rgb, posed_image(frame, mount, self._client.telemetry))
        except NoDepthError:
            return _View(frame.rgb, None)

    def _ask(self, views: list[_View], note: str) -> Choice:
        """Ask where to go, and once more if the answer is not understood.

        Raises:
            AnswerError: If the second answer is not understood either.
            ChatError: If the endpoint cannot be used.
        """
        text = " ".join(filter(None, [self._aboard.text, note]))
        messages = Question(text, [view.rgb for view in views]).messages()
        content = self._answer(messages)
        try:
            return read_choice(content, len(views))
        except AnswerError as error:
            messages += [
                {"role": "assistant", "content": content},
                {"role": "user", "content": AGAIN.format(error)},
            ]
            return read_choice(self._answer(messages), len(views))

    def _answer(self, messages: list[dict]) -> str:
        return ask_model(self._chat, messages, self._environment, schema=("choice", schema()))

    def _land_on(self, at: Vector3, goal: Vector3) -> Iterator[None]:
        """Fly above a point, and let the autopilot land there."""
        self.touchdown_enu_m = goal
        # Up first and then across, so that the path does not go through what is below it.
        height_m = max(at[2], goal[2] + _HOVER_M)
        above, over = (at[0], at[1], height_m), (goal[0], goal[1], height_m)
        yield from fly_line(self._client, at, above, _SPEED_MPS)
        yield from fly_line(self._client, above, over, _SPEED_MPS)
        yield from land(self._client)
        self.verdict = Verdict(success=True, reason="landed where the model pointed")


def _goal(choice: Choice, views: list[_View], at: Vector3) -> tuple[Vector3 | None, str]:
    """Return the point that a choice leads to, or None and a note for the next question."""
    if choice.action == "climb":
        return (at[0], at[1], at[2] + _CLIMB_M), ""
    depth = views[choice.image].depth
    seen = None if depth is None else _point(choice, depth)
    if choice.action == "land":
        return seen, "" if seen is not None else "There is no surface at the last point."
    if depth is None:
        return None, "Nothing was measured in the last image."
    ray = _ray(choice, depth)
    # Steps are level, so the ray is scaled by its horizontal part.
    ray /= max(float(np.linalg.norm(ray[:2])), 1e-6)
    # Without a measured depth there is nothing within the camera's range.
    room_m = math.inf if seen is None else math.dist(seen[:2], at[:2])
    step_m = min(_STEP_M, room_m - _ROOM_M)
    if step_m < _LEAST_STEP_M:
        return None, "Something is too near in the last direction."
    return (at[0] + step_m * ray[0], at[1] + step_m * ray[1], at[2]), ""


def _pixel(choice: Choice, depth: DepthImage) -> tuple[int, int]:
    """Return row and column of a point."""
    height, width = depth.depth_m.shape
    return round(choice.y * (height - 1)), round(choice.x * (width - 1))


def _ray(choice: Choice, depth: DepthImage) -> np.ndarray:
    """Return the ray from the camera to a point, ENU, 1 m long along the optical axis."""
    row, column = _pixel(choice, depth)
    optical = np.array([(column - depth.cx) / depth.fx, (row - depth.cy) / depth.fy, 1.0])
    return depth.rotation_enu_from_optical @ optical


def _point(choice: Choice, depth: DepthImage) -> Vector3 | None:
    """Return the point of the world at a pixel, ENU; None if no depth was measured there."""
    row, column = _pixel(choice, depth)
    low_row, low_column = max(0, row - _ABOUT_PX), max(0, column - _ABOUT_PX)
    about = depth.depth_m[low_row : row + _ABOUT_PX + 1, low_column : column + _ABOUT_PX + 1]
    # The median of a few pixels, since a single one may lie on an edge.
    measured_m = about[np.isfinite(about) & (about > 0.0)]
    if not measured_m.size:
        return None
    return vector3(depth.position_enu_m + float(np.median(measured_m)) * _ray(choice, depth))
