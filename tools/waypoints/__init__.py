"""Part of `fly_waypoints.py`: the client outside."""
