"""Controllers, without ROS."""
