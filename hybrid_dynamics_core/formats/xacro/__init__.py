"""Xacro files: expanded by PyPI's xacro, in a process that can reach nothing.

`expand` starts it and answers what it asks for; `worker` is what runs there.
"""
