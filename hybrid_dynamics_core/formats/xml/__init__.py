"""What the XML formats share: elements with their lines, typed values, vocabularies, texts."""
