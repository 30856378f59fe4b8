"""Runs as files of other tools: tables, and recordings of ROS 2."""
