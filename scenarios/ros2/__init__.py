"""A door to ROS 2: topics, transforms and services of a flight, without an installation of ROS."""
