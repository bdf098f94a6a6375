"""The C++ interface: a header whose functions take spans, arrays, Eigen vectors and matrices."""

from __future__ import annotations

from collections.abc import Sequence

from .calls import GUESS
from .signatures import Names
from .tracer import TracedFunction

_HEAD = """\
/* {p}.h for C++17 and later. Functions of the namespace {p}_model take C arrays, std::array,
   std::span (C++20), and vectors and row-major matrices of Eigen where it is included before.
   Another length does not compile. Link with {p}.c. */
#ifndef {p}_HPP
#define {p}_HPP

#include "{p}.h"

#include <array>
#include <cstddef>
#if defined(__has_include)
#if __has_include(<version>)
#include <version>
#endif
#endif
#if defined(__cpp_lib_span)
#include <span>
#endif

namespace {p}_model {{

using real = double;
constexpr std::size_t NU = {p}_NU;
constexpr std::size_t NS = {p}_NS;

/* N numbers that are read. */
template <std::size_t N>
class In {{
public:
    In(const real (&x)[N]) noexcept : data_(x) {{}}
    In(const std::array<real, N> &x) noexcept : data_(x.data()) {{}}
#if defined(__cpp_lib_span)
    In(std::span<const real, N> x) noexcept : data_(x.data()) {{}}
    In(std::span<real, N> x) noexcept : data_(x.data()) {{}}
#endif
#if defined(EIGEN_CORE_H) || defined(EIGEN_CORE_MODULE_H)
    template <class D>
    In(const Eigen::PlainObjectBase<D> &x) noexcept : data_(x.data())
    {{
        static_assert(D::SizeAtCompileTime == static_cast<int>(N), "another number of entries");
        static_assert(D::IsVectorAtCompileTime || D::IsRowMajor, "matrices are row-major");
    }}
#endif
    const real *data() const noexcept {{ return data_; }}

private:
    const real *data_;
}};

/* N numbers that are written. */
template <std::size_t N>
class Out {{
public:
    Out(real (&x)[N]) noexcept : data_(x) {{}}
    Out(std::array<real, N> &x) noexcept : data_(x.data()) {{}}
#if defined(__cpp_lib_span)
    Out(std::span<real, N> x) noexcept : data_(x.data()) {{}}
#endif
#if defined(EIGEN_CORE_H) || defined(EIGEN_CORE_MODULE_H)
    template <class D>
    Out(Eigen::PlainObjectBase<D> &x) noexcept : data_(x.data())
    {{
        static_assert(D::SizeAtCompileTime == static_cast<int>(N), "another number of entries");
        static_assert(D::IsVectorAtCompileTime || D::IsRowMajor, "matrices are row-major");
    }}
#endif
    real *data() const noexcept {{ return data_; }}

private:
    real *data_;
}};

/* The reference configuration, a first guess. */
inline std::array<real, NS> reference() noexcept
{{
    std::array<real, NS> s{{}};
    for (std::size_t k = 0; k < NS; ++k) {{
        s[k] = {p}_reference[k];
    }}
    return s;
}}

inline const char *status_text(int status) noexcept {{ return {p}_status_text(status); }}
"""


def cpp_text(names: Names, traced: Sequence[TracedFunction]) -> str:
    """The text of ROBOT.hpp."""
    parts = [_HEAD.format(p=names.prefix)]
    for one in traced:
        parts.append(_function(names, one))
        if one.split is not None:
            parts.append(_function(names, one, has_guess=False))
    parts.append(f"}} /* namespace {names.prefix}_model */\n\n#endif /* {names.prefix}_HPP */\n")
    return "\n".join(parts)


def _function(names: Names, traced: TracedFunction, *, has_guess: bool = True) -> str:
    arguments = [f"In<{names.count(name)}> {name}" for name in traced.inputs]
    if has_guess:
        arguments.append(f"Out<{len(names.coordinates)}> guess")
    arguments += [f"Out<{size}> {name}" for name, size in traced.results.items()]
    listed = ",\n    ".join(arguments)
    values = [f"{name}.data()" for name in (*traced.inputs, GUESS, *traced.results)]
    if not has_guess:
        values[len(traced.inputs)] = "nullptr"
    pointers = ", ".join(values)
    return (
        f"inline int {traced.call.name}(\n    {listed}) noexcept\n{{\n"
        f"    return {names.prefix}_{traced.call.name}(\n        {pointers});\n}}\n"
    )
