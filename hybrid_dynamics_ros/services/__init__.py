"""The services: functions from the robot and a request to a response, without a node.

`table.py` lists them all.
"""
