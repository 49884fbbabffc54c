#pragma once
/// Conversions between Python and small values of the client library: enumerations are words ("path_blocked"),
/// durations are seconds as float, vectors are NumPy arrays of three numbers.

#include <array>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <hecaton/client.hpp>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "services/config/text.hpp"

namespace hecaton::python {

namespace py = pybind11;

/// An enumeration of the client library.
template <class T>
concept Named = std::is_enum_v<T> && requires(T value) {
  { name_of(value) } -> std::convertible_to<std::string_view>;
};

/// A number as an argument. Another type is InvalidArgument: pybind11 would list signatures.
struct Number {
  double value = 0.0;
  operator double() const { return value; }
};

/// How an argument is quoted in a sentence: its Python text, at most 80 bytes of it.
[[nodiscard]] inline std::string quoted(py::handle argument) {
  return config::printable(std::string(py::repr(argument)));
}

/// A copy as a NumPy array of one dimension.
[[nodiscard]] inline py::array_t<double> array_of(std::span<const double> values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// Numbers of any sequence or array of one dimension. Empty if `source` is neither, or has another element than a real
/// number.
[[nodiscard]] inline std::optional<std::vector<double>> numbers_in(py::handle source) {
  if (py::isinstance<py::str>(source) || !py::isinstance<py::sequence>(source)) {
    if (!py::isinstance<py::array>(source)) return std::nullopt;
  }
  // NumPy converts texts, truth values and complex numbers as well.
  const auto plain = py::array::ensure(source);
  const char kind = plain ? plain.dtype().kind() : ' ';
  const bool real = kind == 'i' || kind == 'u' || kind == 'f';
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(source);
  if (!real || !array) {
    PyErr_Clear();
    return std::nullopt;
  }
  if (array.ndim() != 1) return std::nullopt;
  return std::vector<double>(array.data(), array.data() + array.size());
}

}  // namespace hecaton::python

namespace pybind11::detail {

template <hecaton::python::Named Enum>
struct type_caster<Enum> {
  PYBIND11_TYPE_CASTER(Enum, const_name("str"));

  bool load(handle source, bool /*convert*/) {
    if (!isinstance<str>(source)) return false;
    const auto word = source.cast<std::string>();
    constexpr std::uint32_t kMost = 256;
    for (std::uint32_t i = 0; i < kMost; ++i) {
      const auto known = name_of(static_cast<Enum>(i));
      if (known == "unknown") return false;
      if (known != word) continue;
      value = static_cast<Enum>(i);
      return true;
    }
    return false;
  }
  static handle cast(Enum source, return_value_policy /*policy*/, handle /*parent*/) {
    return str(std::string(name_of(source))).release();
  }
};

template <>
struct type_caster<hecaton::python::Number> {
  PYBIND11_TYPE_CASTER(hecaton::python::Number, const_name("float"));

  bool load(handle source, bool /*convert*/) {
    make_caster<double> number;
    if (!number.load(source, true)) {
      throw hecaton::InvalidArgument(hecaton::python::quoted(source) + " must be a number");
    }
    value = {cast_op<double>(number)};
    return true;
  }
  static handle cast(hecaton::python::Number source, return_value_policy /*policy*/, handle /*parent*/) {
    return float_(source.value).release();
  }
};

template <>
struct type_caster<hecaton::Seconds> {
  PYBIND11_TYPE_CASTER(hecaton::Seconds, const_name("float"));

  bool load(handle source, bool convert) {
    make_caster<hecaton::python::Number> number;
    if (!number.load(source, convert)) return false;
    value = hecaton::Seconds(cast_op<hecaton::python::Number>(number).value);
    return true;
  }
  static handle cast(hecaton::Seconds source, return_value_policy /*policy*/, handle /*parent*/) {
    return float_(source.count()).release();
  }
};

template <>
struct type_caster<hecaton::Vector3> {
  PYBIND11_TYPE_CASTER(hecaton::Vector3, const_name("numpy.ndarray"));

  bool load(handle source, bool /*convert*/) {
    const auto numbers = hecaton::python::numbers_in(source);
    if (!numbers || numbers->size() != 3) {
      throw hecaton::InvalidArgument(hecaton::python::quoted(source) + " must be three numbers, such as [0.1, 0, 0.5]");
    }
    value = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    return true;
  }
  static handle cast(const hecaton::Vector3& source, return_value_policy /*policy*/, handle /*parent*/) {
    const std::array<double, 3> numbers{source.x, source.y, source.z};
    return hecaton::python::array_of(numbers).release();
  }
};

}  // namespace pybind11::detail
