"""Text in LLVM's intermediate representation from traces; this needs no compiler."""
