"""Guidance, navigation and control, without simulator or MAVLink."""
