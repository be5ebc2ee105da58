"""The 50 Hz half of the autopilot: commander, flight modes, missions and failsafes.

It reads estimates and sensors of the plant, decides, and returns one setpoint each tick of 20 ms.
The controllers that track the setpoint run at 250 Hz inside the plant. The modules know no MAVLink,
so that tests and Python pilots can use the autopilot without a link.
"""
