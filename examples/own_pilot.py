"""A pilot of one's own: MAVLink and cameras in, setpoints out; the truth judges it in the end.

It flies straight up, across and down if the camera sees its area flat; a `yield` lasts 20 ms.
Run: python examples/own_pilot.py, or a campaign beside it: --pilot own_pilot:StraightPilot
"""

import numpy as np

import aeroscene

TOP_M, HOVER_M, SPEED_MPS = 19.0, 3.0, 2.5


class StraightPilot:
    """A `scenarios.Companion`, with its `area`, `verdict`, `is_done` and `update`."""

    def __init__(self, aboard: aeroscene.Aboard) -> None:
        self.aboard, self.client, areas = aboard, aboard.client, aboard.scene.landing_areas
        self.area = aboard.area or max(areas, key=lambda a: (a.clearance_m, a.radius))
        self.verdict, self.is_done = aeroscene.Verdict(success=False, reason="not finished"), False
        self.flight = self.fly()

    def update(self, time_us: int) -> None:
        self.client.update(time_us)
        self.is_done = self.is_done or next(self.flight, "over") == "over"

    def fly(self):
        client, state, (x, y, z) = self.client, self.client.telemetry, self.area.centroid
        client.request_streams()
        while not (state.has_state and state.is_armable and state.local_origin_enu_m):
            yield
        yield from self.line_to(state.position_enu_m)  # offboard mode wants a stream of setpoints
        client.set_mode(aeroscene.PX4_OFFBOARD)
        client.arm()
        for goal in ((*state.position_enu_m[:2], TOP_M), (x, y, TOP_M), (x, y, z + HOVER_M)):
            yield from self.line_to(goal)
        is_flat = np.ptp(self.aboard.render("down").depth_m[90:150, 130:190]) < 0.3
        client.set_mode(aeroscene.PX4_LAND if is_flat else aeroscene.PX4_RETURN)
        while state.is_armed:
            yield
        self.verdict = aeroscene.Verdict(
            success=bool(is_flat), reason=f"came down, flat below: {is_flat}"
        )

    def line_to(self, goal_enu_m):
        start = np.array(self.client.telemetry.position_enu_m)
        step = 0.02 * SPEED_MPS / max(np.linalg.norm(goal_enu_m - start), 1.0)
        for share in [*np.arange(0.0, 1.0, step), *[1.0] * 50]:
            at = start + share * share * (3.0 - 2.0 * share) * (goal_enu_m - start)
            self.client.send_setpoint(aeroscene.FlatReference(position_enu_m=tuple(at.tolist())))
            yield


def main() -> aeroscene.TrialResult:
    cfg = aeroscene.SitlCfg(bench=aeroscene.TestbenchCfg(speed="max"))
    with aeroscene.Sitl(cfg, pilot=StraightPilot, has_network=False) as sitl:
        return sitl.run()


if __name__ == "__main__":
    print(main())
