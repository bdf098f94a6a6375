"""What all other packages stand on: arrays, checks of arguments, words of messages.

Knows no robot.
"""
