"""YAML of format 1: the writer; `description` has the reader."""
