"""Common ground of all packages: arrays, checks of arguments, texts of messages.

It does not depend on robots.
"""
