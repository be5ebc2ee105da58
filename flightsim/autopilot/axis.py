"""Motion along one axis within limits of speed, acceleration and jerk, tick by tick.

Both laws choose the acceleration at the end of the tick; the jerk is constant in between. Neither
has memory, so goals and limits may change at any tick. A profile that is planned once, from start
to stop, would have to be planned anew at each change and after each lag of the vehicle.

| symbol | meaning                                             |
|--------|-----------------------------------------------------|
| x      | position relative to the goal, which is at 0        |
| v, a   | velocity and acceleration                           |
| v_max, a_max, j_max | limits, positive                       |
| dt     | length of a tick                                    |
"""

from __future__ import annotations

from math import copysign, sqrt

# At most so many. The search ends earlier once the point would stop within 1e-6 before the goal.
_N_SECANT_STEPS = 6


class AxisMotion:
    """A point moving along one axis, with the jerk of the last tick.

    `x` is in m relative to the goal (or rad), `v`, `a` and `j` are its derivatives in time.
    """

    __slots__ = ("a", "j", "v", "x")

    def __init__(self, x: float = 0.0, v: float = 0.0, a: float = 0.0) -> None:
        self.x = x
        self.v = v
        self.a = a
        self.j = 0.0

    @property
    def is_at_rest(self) -> bool:
        """True if the point rests exactly at the goal."""
        return self.x == 0.0 and self.v == 0.0 and self.a == 0.0

    def step_to_goal(
        self, v_max: float, a_max: float, j_max: float, dt: float, v_exit: float = 0.0
    ) -> None:
        """Move one tick towards x = 0; the point comes to rest exactly there if `v_exit` is 0.

        Args:
            v_max: Speed limit.
            a_max: Acceleration limit.
            j_max: Jerk limit.
            dt: Length of the tick, s.
            v_exit: Speed at which the goal may be passed, not negative.
        """
        x, v, a = self.x, self.v, self.a
        step = j_max * dt
        # Snap onto the goal once one tick can cancel the rest. Otherwise rounding would let the
        # point creep around the goal for ever, and `is_at_rest` would never hold.
        if abs(v) <= 0.5 * step * dt and abs(a) <= step and abs(x) <= 1e-4 + step * dt * dt:
            self.x = self.v = self.a = 0.0
            self.j = -a / dt
            return
        self._advance(acceleration_towards_goal(x, v, a, v_max, a_max, j_max, dt, v_exit), dt)

    def step_to_velocity(self, v_goal: float, a_max: float, j_max: float, dt: float) -> None:
        """Move one tick towards a velocity, within limits of acceleration and jerk.

        Args:
            v_goal: Velocity to reach and to keep, in m/s.
            a_max: Greatest acceleration either way, in m/s^2.
            j_max: Greatest jerk either way, in m/s^3.
            dt: Length of the tick in seconds.
        """
        self._advance(acceleration_towards_velocity(self.v, self.a, v_goal, a_max, j_max, dt), dt)

    def _advance(self, a_next: float, dt: float) -> None:
        """Integrate one tick of constant jerk exactly: cubic position, quadratic velocity."""
        self.x += (self.v + (2.0 * self.a + a_next) * dt / 6.0) * dt
        self.v += 0.5 * (self.a + a_next) * dt
        self.j = (a_next - self.a) / dt
        self.a = a_next


def braking_distance(v: float, a: float, v_exit: float, a_max: float, j_max: float) -> float:
    """Distance covered while slowing down to `v_exit` as fast as the limits allow.

    Args:
        v: Velocity towards the goal.
        a: Acceleration towards the goal.
        v_exit: Desired velocity at the goal, not negative.
        a_max: Limit of deceleration.
        j_max: Limit of jerk.

    Returns:
        The signed distance; if the velocity must rise to reach `v_exit`, the distance until
        the acceleration has faded, which constrains nothing.
    """
    # From here v is the speed above the exit speed, the part that has to vanish.
    v -= v_exit
    t1 = abs(a) / j_max
    # Fading out the acceleration alone already leads below the exit speed.
    if v + 0.5 * a * t1 < 0.0:
        if v_exit > 0.0:
            return (v + v_exit) * t1 + a * t1 * t1 / 3.0
        # The motion turns back before it stops: mirror it.
        return -braking_distance(-v, -a, 0.0, a_max, j_max)
    # Ramp to -peak, hold it for t2, ramp back to 0.
    peak = sqrt(max(j_max * v + 0.5 * a * a, 0.0))
    # A deceleration above the limit may only come down at full jerk, never jump.
    limit = max(a_max, -a)
    t2 = 0.0
    if peak > limit:
        peak = limit
        t2 = (v + (0.5 * a * a - peak * peak) / j_max) / peak
    t1 = (a + peak) / j_max
    t3 = peak / j_max
    v2 = v + (a - peak) * 0.5 * t1
    distance = (v + (0.5 * a - j_max * t1 / 6.0) * t1) * t1
    distance += (v2 - 0.5 * peak * t2) * t2 + peak * peak * peak / (6.0 * j_max * j_max)
    return distance + v_exit * (t1 + t2 + t3)


def acceleration_towards_velocity(
    v: float, a: float, v_goal: float, a_max: float, j_max: float, dt: float
) -> float:
    """Acceleration at the end of a tick that reaches a velocity fast without overshoot.

    Fading it out at full jerk ends exactly at `v_goal`, as far as the limits let it be reached
    within the tick.

    Args:
        v: Velocity.
        a: Acceleration.
        v_goal: Desired velocity.
        a_max: Acceleration limit; an acceleration beyond it comes down at full jerk.
        j_max: Jerk limit.
        dt: Length of the tick, s.
    """
    # This tick changes v by dt (a + a_next) / 2, the fade-out after it by a_next^2 / (2 j_max).
    # a_next is the root of their sum = v_goal - v.
    missing = v_goal - v - 0.5 * a * dt
    h = 0.5 * dt
    a_next = copysign(j_max * (sqrt(h * h + 2.0 * abs(missing) / j_max) - h), missing)
    step = j_max * dt
    bound = max(a_max, abs(a) - step)
    a_next = min(max(a_next, a - step), a + step)
    return min(max(a_next, -bound), bound)


def acceleration_towards_goal(
    x: float,
    v: float,
    a: float,
    v_max: float,
    a_max: float,
    j_max: float,
    dt: float,
    v_exit: float = 0.0,
) -> float:
    """Acceleration at the end of a tick that reaches x = 0 fast without overshoot.

    Args:
        x: Position; negative before the goal.
        v: Velocity.
        a: Acceleration.
        v_max: Speed limit.
        a_max: Acceleration limit.
        j_max: Jerk limit.
        dt: Length of the tick.
        v_exit: Speed at which the goal may be passed; the motion turns back after it.

    Returns:
        The acceleration; it exceeds `a_max` only while coming down from a larger one.
    """
    # Behind the goal the point must come back to it, and an exit speed would lead away.
    if x >= 0.0:
        v_exit = 0.0
    if x + braking_distance(v, a, v_exit, a_max, j_max) > 0.0:
        if v_exit > 0.0:
            # Too fast for the exit speed, which is only a wish: brake as hard as allowed.
            return acceleration_towards_velocity(v, a, v_exit, a_max, j_max, dt)
        return -_approach(-x, -v, -a, v_max, a_max, j_max, dt, 0.0)
    return _approach(x, v, a, v_max, a_max, j_max, dt, v_exit)


def _approach(
    x: float, v: float, a: float, v_max: float, a_max: float, j_max: float, dt: float, v_exit: float
) -> float:
    """Acceleration of a motion that, braking now, would stop before the goal at x = 0."""

    def overshoot(a_next: float) -> float:
        v_next = v + 0.5 * (a + a_next) * dt
        x_next = x + (v + (2.0 * a + a_next) * dt / 6.0) * dt
        return x_next + braking_distance(v_next, a_next, v_exit, a_max, j_max)

    fast = acceleration_towards_velocity(v, a, v_max, a_max, j_max, dt)
    over_fast = overshoot(fast)
    if over_fast <= 0.0:
        return fast
    slow = acceleration_towards_velocity(v, a, v_exit, a_max, j_max, dt)
    over_slow = overshoot(slow)
    if over_slow >= 0.0:
        return slow
    # Illinois method: keep the bracket, halve the value at an end that stays.
    for _ in range(_N_SECANT_STEPS):
        middle = slow - over_slow * (fast - slow) / (over_fast - over_slow)
        over = overshoot(middle)
        if over > 0.0:
            fast, over_fast, over_slow = middle, over, 0.5 * over_slow
        elif over < -1e-6:
            slow, over_slow, over_fast = middle, over, 0.5 * over_fast
        else:
            return middle
    return slow
