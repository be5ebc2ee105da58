"""A pilot to begin with: straight up, straight across, straight down.

Run: python my_pilot.py

Score it, beside the pilots that ship:

    aeroscene campaign --scenes 0:3 --trials 4 --pilot my_pilot:Pilot --out runs/my_pilot
    aeroscene report runs/my_pilot

docs/python.md and docs/campaigns.md tell more.
"""

import math

import aeroscene

# Scenes are named as in `aeroscene sitl SCENE`. `field` has nothing to fly into; try 42 next.
SCENE = "field"
# Height in m above the start at which the pilot flies to its area. Buildings are higher.
HEIGHT_M = 6.0
SPEED_MPS = 2.0
# `update` is called every 20 ms of simulated time, so that each `yield` below lasts as long.
TICK_S = 0.02


class Pilot:
    """A companion computer: it sees what one sees, and never the true state."""

    def __init__(self, aboard: aeroscene.Aboard) -> None:
        # `aboard` has the MAVLink client, `render("down")` for camera images, the map, the
        # airframe, and the area that a campaign assigns, or a goal in words, `aboard.text`.
        self.client = aboard.client
        roomiest = max(aboard.scene.landing_areas, key=lambda area: (area.clearance_m, area.radius))
        # The truth judges whether the vehicle comes to rest on this area.
        self.area = aboard.area or roomiest
        self.is_done = False
        self.verdict = aeroscene.Verdict(success=False, reason="not finished")
        self.flight = self.fly()

    def update(self, time_us: int) -> None:
        """Read what has arrived, then go on with the flight until its next `yield`."""
        self.client.update(time_us)
        self.is_done = self.is_done or next(self.flight, "over") == "over"

    def fly(self):
        """The whole flight, from top to bottom."""
        client, state = self.client, self.client.telemetry
        client.request_streams()
        while not (state.has_state and state.is_armable and state.local_origin_enu_m):
            yield
        x, y, z = state.position_enu_m
        # Offboard mode is refused until setpoints come, so they come first.
        yield from self.go_to((x, y, z))
        client.set_mode(aeroscene.PX4_OFFBOARD)
        client.arm()
        to_x, to_y, _ = self.area.centroid
        for goal in ((x, y, z + HEIGHT_M), (to_x, to_y, z + HEIGHT_M)):
            yield from self.go_to(goal)
        # The autopilot's own mode descends straight and disarms on the ground.
        client.set_mode(aeroscene.PX4_LAND)
        while state.is_armed:
            yield
        self.verdict = aeroscene.Verdict(
            success=True, reason="came down above the middle of the area"
        )

    def go_to(self, goal_enu_m):
        """Move the setpoint to a place in a straight line; it arrives with a second to settle."""
        start_enu_m = self.client.telemetry.position_enu_m
        n_ticks = math.ceil(math.dist(start_enu_m, goal_enu_m) / SPEED_MPS / TICK_S)
        for tick in range(n_ticks + round(1.0 / TICK_S)):
            share = min(1.0, tick / max(n_ticks, 1))
            at = [a + share * (b - a) for a, b in zip(start_enu_m, goal_enu_m, strict=True)]
            self.client.send_setpoint(aeroscene.FlatReference(position_enu_m=(at[0], at[1], at[2])))
            yield


def main() -> aeroscene.TrialResult:
    """Fly once, as fast as this machine can, and record it."""
    cfg = aeroscene.SitlCfg(scene=SCENE, bench=aeroscene.TestbenchCfg(speed="max"))
    with aeroscene.Sitl(cfg, pilot=Pilot, has_network=False) as sitl:
        return sitl.run()


if __name__ == "__main__":
    result = main()
    print(f"{result.code}: {result.reason}; {result.touchdown_error_m} m from the middle")
