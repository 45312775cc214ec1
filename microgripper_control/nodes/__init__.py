"""Thin ROS 2 shells."""
