"""Where on Earth scenes lie that do not say: where PX4's simulations do (Zurich).

Scripts written for those fit then.
"""

LATITUDE_DEG = 47.397742
LONGITUDE_DEG = 8.545594
ALTITUDE_M = 488.0
