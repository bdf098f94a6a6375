"""Xacro files, expanded by PyPI's xacro in an isolated process.

`expand` starts the process and answers its requests; `worker` is its program.
"""
