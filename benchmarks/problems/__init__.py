"""The field's benchmark problems, with this library and beside other engines."""
