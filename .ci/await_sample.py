"""Exits with 0 when a sample has come over DDS, with 1 when none has in a minute."""

import sys

import rclpy
from rclpy.qos import qos_profile_sensor_data
from rclpy.wait_for_message import wait_for_message
from sensor_msgs.msg import JointState

TOPIC = "/microgripper/joint_states"

rclpy.init()
came, _ = wait_for_message(
    JointState,
    rclpy.create_node("await_sample"),
    TOPIC,
    qos_profile=qos_profile_sensor_data,
    time_to_wait=60.0,
)
rclpy.shutdown()
sys.exit(None if came else f"no sample on {TOPIC} in a minute")
