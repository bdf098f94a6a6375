"""What the services answer: functions of the robot and a request, without a node.

`table.py` lists them all.
"""
