"""Common code of the XML formats: elements with lines, typed values, vocabularies, writing."""
