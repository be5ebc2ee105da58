"""A learnt policy as a pilot: it flies the part of a trial that it was trained for.

Trials lead across a scene, and an environment teaches one skill. So our own pilot flies the rest,
and a comparison with it measures that skill alone:

task         our pilot                                 the policy
landing      flies to the area                         lands, from the hover above it on
hover        plans, looks, takes off, touches down     follows the set points between these
navigation   none: straight up before, and landing     flies from above the start to above the area
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from typing import Any

from aeroscene.scene import InteractionArea
from autonomy.types import FlatReference, Vector3
from flightsim.mavlink.client import MavlinkClient
from flightsim.plant import Plant
from flightsim.testbench import TestbenchError
from scenarios.baselines.offboard import TICK_S, area_of, fly_line, land, take_control
from scenarios.environments.interface.by_mavlink import check_offboard
from scenarios.environments.tasks import task_by_name
from scenarios.environments.tasks.landing import TOUCHDOWN_S
from scenarios.environments.tasks.navigation import Navigation
from scenarios.pilot import Pilot
from scenarios.pilot.phases import FOLLOWS, Phase
from scenarios.policies.agent import Agent
from scenarios.policies.description import PolicyError
from scenarios.policies.policy import Policy
from scenarios.run.companion import Aboard
from scenarios.trials.verdict import Verdict, Word

_ABOVE_M = 2.0
"""Height above the start and above the area between which a policy navigates: the middle of what
its environment draws."""
_LINE_MPS = 1.0
_PATIENCE = 3.0
"""Multiple of an episode's longest time after which the policy is taken not to arrive."""
_LOOP_HZ = 50
_FOLLOWED = FOLLOWS - {Phase.TAKEOFF}
"""Phases of our pilot whose set points a policy follows; lower down it has not been trained."""


class PolicyMaker:
    """Makes a pilot of a policy for each flight."""

    sees_plant = True
    """The policy observes what its environment showed to it, which may be the true state."""

    def __init__(self, policy: Policy) -> None:
        """Check that the policy can fly trials.

        Raises:
            PolicyError: If its actions are no setpoints, or come too often.
        """
        cfg = policy.description.cfg
        try:
            check_offboard(cfg.action)
        except ValueError as error:
            raise PolicyError(str(error)) from None
        if cfg.action_hz > _LOOP_HZ:
            raise PolicyError(
                f"action_hz = {cfg.action_hz}: an autopilot takes setpoints up to {_LOOP_HZ} times "
                "a second; valid: a policy that was trained at 50, 25, 10 or 5"
            )
        self._policy = policy

    def __call__(self, aboard: Aboard) -> PolicyPilot:
        """Return the pilot of a flight.

        Raises:
            TestbenchError: If our pilot finds no plan to fly its part.
        """
        return PolicyPilot(self._policy, aboard)


class PolicyPilot:
    """A `scenarios.Companion` that flies by a policy, and by our pilot where that was not trained.

    Attributes:
        verdict: Its own statement on the flight.
    """

    def __init__(self, policy: Policy, aboard: Aboard) -> None:
        assert aboard.plant is not None
        self.verdict: Word = Verdict(success=False, reason="not finished")
        self._task, self._client = policy.description.task, aboard.client
        self._patience_s = _PATIENCE * task_by_name(self._task).episode_s
        self._plant: Plant = aboard.plant
        self._agent = Agent(policy, aboard.client, aboard.plant)
        self._leg_m = aboard.airframe.leg_length_m
        self._followed = _Followed(aboard.client)
        self._ours: Pilot | None = None
        self._own_area: InteractionArea | None = None
        self._is_over = False
        if self._task == "navigation":
            self._own_area = area_of(aboard)
            self._flight = self._navigate()
        else:
            if aboard.our_pilot is None:
                raise TestbenchError("a policy needs our pilot; valid: a run that can plan")
            client: Any = self._followed if self._task == "hover" else aboard.client
            self._ours = aboard.our_pilot(client)
            self._flight = self._follow() if self._task == "hover" else self._land()

    @property
    def is_done(self) -> bool:
        """True if the flight is over."""
        return self._is_over

    @property
    def area(self) -> InteractionArea | None:
        """Area to land on."""
        return self._own_area if self._ours is None else self._ours.area

    @property
    def planned_enu_m(self) -> Any:
        """Path that our pilot planned, if it flies a part."""
        return None if self._ours is None else self._ours.planned_enu_m

    @property
    def touchdown_enu_m(self) -> Vector3 | None:
        """Point that our pilot chose; a policy that lands aims at the area's middle."""
        return self._ours.touchdown_enu_m if self._ours and self._task == "hover" else None

    def update(self, time_us: int) -> None:
        """Read telemetry, and let our pilot or the policy act.

        Args:
            time_us: Simulated time.
        """
        self._now_us = time_us
        if not self._is_over:
            self._is_over = next(self._flight, self) is self
            if self._is_over:
                self._agent.close()
        else:
            self._client.update(time_us)

    def _land(self) -> Iterator[None]:
        """Let our pilot fly to above the area, and the policy land."""
        ours = self._ours
        assert ours is not None
        while ours.phase is not Phase.SEARCH:
            ours.update(self._now_us)
            if ours.is_done:
                self.verdict = ours.verdict
                return
            yield
        x, y, z = ours.area.centroid
        is_down = yield from self._steer((x, y, z + self._leg_m), self._touchdown())
        if not is_down:
            return self._give_up("did not come down")
        self._client.disarm(is_forced=True)
        yield from self._wait_for_disarmed()
        self.verdict = Verdict(success=True, reason="the policy came down")
        return None

    def _navigate(self) -> Iterator[None]:
        """Rise, let the policy fly to above the area, and land there."""
        client, area = self._client, self._own_area
        assert area is not None
        x0, y0, z0 = start = yield from self._reading(take_control(client))
        above = (x0, y0, z0 + _ABOVE_M)
        yield from self._reading(fly_line(client, start, above, _LINE_MPS))
        x, y, z = area.centroid
        goal = (x, y, z + _ABOVE_M)
        has_arrived = yield from self._steer(
            goal, lambda: math.dist(self._agent.position_enu_m, goal) <= Navigation.near_m
        )
        if not has_arrived:
            return self._give_up("did not come to the area")
        here = client.telemetry.position_enu_m
        yield from self._reading(fly_line(client, here, goal, _LINE_MPS))
        yield from self._reading(land(client))
        self.verdict = Verdict(success=True, reason="landed below where the policy came to")
        return None

    def _follow(self) -> Iterator[None]:
        """Let our pilot fly, and the policy follow its set points in the air."""
        ours, agent, client = self._ours, self._agent, self._client
        assert ours is not None
        while not ours.is_done:
            ours.update(self._now_us)
            wanted = self._followed.take()
            if wanted is not None and ours.phase in _FOLLOWED:
                # The set point is in the frame of the autopilot's estimate: what counts is how far
                # it is from where the autopilot takes the vehicle to be.
                offset = zip(
                    agent.position_enu_m,
                    wanted.position_enu_m,
                    client.telemetry.position_enu_m,
                    strict=True,
                )
                x, y, z = (known + goal - here for known, goal, here in offset)
                agent.update((x, y, z))
            elif wanted is not None:
                client.send_setpoint(wanted)
            yield
        self.verdict = ours.verdict

    def _steer(self, target_enu_m: Vector3, is_there: Any) -> Generator[None, None, bool]:
        """Let the policy fly to a target; return false if its patience ends before."""
        for _ in range(round(self._patience_s / TICK_S)):
            self._client.update(self._now_us)
            self._agent.update_estimate()
            if is_there():
                return True
            self._agent.update(target_enu_m)
            yield
        return False

    def _touchdown(self) -> Any:
        """Return a function that says, once a tick, whether an episode of landing would end."""
        n_touching = 0

        def is_down() -> bool:
            nonlocal n_touching
            n_touching = n_touching + 1 if self._plant.contact_ticks else 0
            return n_touching * TICK_S >= TOUCHDOWN_S - 1e-9

        return is_down

    def _wait_for_disarmed(self) -> Iterator[None]:
        while True:
            self._client.update(self._now_us)
            if not self._client.telemetry.is_armed:
                return
            yield

    def _reading(self, steps: Any) -> Generator[None, None, Any]:
        """Read telemetry before each of some steps; return what these return."""
        while True:
            self._client.update(self._now_us)
            try:
                next(steps)
            except StopIteration as end:
                return end.value
            yield

    def _give_up(self, reason: str) -> None:
        """Leave the vehicle in the air: to land elsewhere would be no success either."""
        self._client.set_mode(self._client.habits.hold)
        self._client.update(self._now_us)
        self.verdict = Verdict(
            success=False, reason=f"the policy {reason} within {self._patience_s:g} s"
        )


class _Followed:
    """The client of our pilot, except that its set points go to the policy."""

    def __init__(self, client: MavlinkClient) -> None:
        self._client = client
        self._wanted: FlatReference | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._client, name)

    def send_setpoint(self, reference: FlatReference) -> None:
        """Keep the set point for `take`."""
        self._wanted = reference

    def take(self) -> FlatReference | None:
        """Return the set point of this tick; None if there is none."""
        wanted, self._wanted = self._wanted, None
        return wanted
