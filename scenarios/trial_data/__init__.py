"""Recorded trials as data: tables, images, ROS 2 bags, flight logs, and a dataset for torch."""
