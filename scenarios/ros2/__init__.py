"""A door to ROS 2: topics, transforms and services of a flight, without an installation of ROS.

ROS 2 is a set of message types over a transport. Both are available as Python wheels (rosbags for
types, Cyclone DDS and Zenoh as transports), so a flight can speak to nodes of any ROS distribution
while AeroScene itself installs without ROS. `door` is the entry; `dds` and `zenoh_transport` carry
bytes, and the other modules build messages.
"""
