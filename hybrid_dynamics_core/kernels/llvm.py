"""LLVM through llvmlite: compilation of a module's text, and loading of object code."""

from __future__ import annotations

import ctypes
import platform
from functools import cache
from typing import Any

OLDEST = (0, 45)  # the first with LLVM 20, whose syntax the emitters write
PYTHON_FUNCTIONS = (
    "PyLong_FromLongLong",
    "PyEval_SaveThread",
    "PyEval_RestoreThread",
    "PyObject_Vectorcall",
    "PyTuple_New",
    "PyTuple_SetItem",
    "Py_IncRef",
    "Py_DecRef",
)


@cache
def binding() -> Any:
    """The llvmlite binding, initialised for this machine; None if it is missing or too old."""
    try:
        import llvmlite  # noqa: PLC0415  optional, and not every use needs it
        import llvmlite.binding as llvm  # noqa: PLC0415
    except ImportError:
        return None
    if tuple(int(part) for part in llvmlite.__version__.split(".")[:2]) < OLDEST:
        return None
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    for name in ("sin", "cos", "rint"):
        llvm.add_symbol(name, _address(_c_library(), name))
    for name in PYTHON_FUNCTIONS:
        llvm.add_symbol(name, _address(ctypes.pythonapi, name))
    return llvm


def _c_library() -> ctypes.CDLL:
    return ctypes.CDLL("ucrtbase" if platform.system() == "Windows" else None)


def _address(library: ctypes.CDLL, name: str) -> int:
    address = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
    assert address is not None  # noqa: S101  a function that was found has one
    return address


@cache
def versions() -> tuple[str, str]:
    """Versions of llvmlite and of the LLVM in it."""
    import llvmlite  # noqa: PLC0415  optional

    return llvmlite.__version__, ".".join(map(str, binding().llvm_version_info))


@cache
def processor() -> tuple[str, str]:
    """LLVM's name and features of this machine's processor."""
    llvm = binding()
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


@cache
def vector_width() -> int:
    """Doubles in one vector register."""
    features = processor()[1].split(",")
    return 8 if "+avx512f" in features else 4 if "+avx" in features else 2


def _machine(level: int) -> Any:
    cpu, features = processor()
    target = binding().Target.from_default_triple()
    return target.create_target_machine(cpu=cpu, features=features, opt=level, jit=True)


def compile_text(text: str, level: int) -> bytes:
    """Compile a module's text to object code for this processor."""
    llvm = binding()
    machine = _machine(level)
    module = llvm.parse_assembly(text)
    module.verify()
    module.triple = machine.triple
    module.data_layout = str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=level)
    # The code has explicit vectors already.
    options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


class LoadedCode:
    """Loaded object code, which lives as long as this object."""

    def __init__(self, code: bytes) -> None:
        llvm = binding()
        empty = llvm.parse_assembly("")
        self._engine = llvm.create_mcjit_compiler(empty, _machine(1))
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.address = self.address_of("call")

    def address_of(self, name: str) -> int:
        """The address of a function; zero if there is none of this name."""
        address: int = self._engine.get_function_address(name)
        return address
