"""Recordings in rosbag2 and CSV."""
