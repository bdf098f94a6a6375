"""What the XML formats share: trees with line numbers, typed attributes, known elements."""
