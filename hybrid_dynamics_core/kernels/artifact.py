"""Kernels on disk under two keys.

The first key is a digest of a program, the sizes of its inputs and the source of its formulas. Its
entry has the facts of the program and the second key. So a warm start needs no trace. The second
key is a digest of the generated text, compiler, processor and optimisation level. Its entry has the
code. A change of the package that does not change the text needs a trace, but no compilation.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

from . import cache
from .backend import Artifact, Backend, Source
from .cache import Entry
from .digest import NoDigestError, digest
from .formula_code import NoSourceError, formula_digest
from .ir.module import Form
from .trace import Trace


def identity_of(program: object, backend: Backend) -> str | None:
    """Digest of everything that the facts and the text depend on.

    Args:
        program: the program, with the sizes of its inputs.
        backend: the backend that generates and builds the code.

    Returns:
        The digest; None without a cache, or if the program has no digest.
    """
    if cache.folder() is None:
        return None
    try:
        parts = [digest(program), formula_digest(), backend.identity()]
    except (NoDigestError, NoSourceError):
        return None
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def first_key(identity: str, form: Form) -> str:
    """The first key of one form of a program."""
    return hashlib.sha256(f"{identity} {form}".encode()).hexdigest()


def second_key(source: Source, backend: Backend) -> str:
    """The second key, for the code of a text."""
    parts = json.dumps([source.text, source.level, backend.conditions()])
    return hashlib.sha256(parts.encode()).hexdigest()


def find(key: str) -> Artifact | None:
    """The artifact of a first key; None if facts or code are missing."""
    entry = cache.read(key)
    if entry is None:
        return None
    code = cache.read(entry.facts["code_key"])
    return None if code is None else Artifact(entry.facts["program"], code.code)


def make(trace: Trace, form: Form, backend: Backend, key: str | None) -> Artifact:
    """Build the code of a trace, or read it from the cache if its text was compiled before.

    Args:
        trace: the traced program.
        form: one state, or rows.
        backend: the backend that generates and builds the code.
        key: the first key to store it under; None to store nothing.

    Returns:
        Facts and code.
    """
    facts = facts_of(trace)
    source = backend.source(trace, form)
    if key is None:
        return Artifact(facts, backend.build(source))
    code_key = second_key(source, backend)
    code = _code(source, backend, code_key)
    cache.write(key, Entry({"code_key": code_key, "program": facts}))
    return Artifact(facts, code)


def _code(source: Source, backend: Backend, key: str) -> bytes:
    entry = cache.read(key)
    if entry is None:
        entry = Entry(code=backend.build(source))
        cache.write(key, entry)
    return entry.code


def facts_of(trace: Trace) -> dict[str, Any]:
    """Facts of a program that are known without running it, as plain data.

    Returns:
        `inputs`: sizes of the input vectors; `layout`: names and shapes of the outputs; `read`:
            indices of the vectors that are read; `iterates`: whether it has an iteration.
    """
    blocks = [trace.graph.blocks[number] for number in trace.live_blocks()]
    return {
        "inputs": list(trace.inputs),
        "layout": [[name, list(shape)] for name, shape in trace.layout],
        "read": sorted({vector for vector, _ in trace.used_inputs()}),
        "iterates": any(block.body is not None for block in blocks),
    }
