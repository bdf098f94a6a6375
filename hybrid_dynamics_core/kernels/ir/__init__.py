"""Traces as text of LLVM's intermediate representation; needs no compiler."""
