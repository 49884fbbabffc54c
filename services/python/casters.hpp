#pragma once
/// Conversions between Python and small values of the client library: enumerations are words ("path_blocked"),
/// durations are seconds as float, vectors are NumPy arrays of three numbers.

#include <chrono>
#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include <hecaton/types.hpp>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace hecaton::python {

namespace py = pybind11;

/// An enumeration of the client library.
template <class T>
concept Named = std::is_enum_v<T> && requires(T value) {
  { name_of(value) } -> std::convertible_to<std::string_view>;
};

/// A copy as a NumPy array of one dimension.
[[nodiscard]] inline py::array_t<double> array_of(std::span<const double> values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// Numbers of any sequence or array of one dimension. Empty if `source` is neither, or has another element than
/// numbers.
[[nodiscard]] inline std::optional<std::vector<double>> numbers_in(py::handle source) {
  if (py::isinstance<py::str>(source) || !py::isinstance<py::sequence>(source)) {
    if (!py::isinstance<py::array>(source)) return std::nullopt;
  }
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(source);
  if (!array) {
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
struct type_caster<hecaton::Seconds> {
  PYBIND11_TYPE_CASTER(hecaton::Seconds, const_name("float"));

  bool load(handle source, bool convert) {
    make_caster<double> number;
    if (!number.load(source, convert)) return false;
    value = hecaton::Seconds(cast_op<double>(number));
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
    if (!numbers || numbers->size() != 3) return false;
    value = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    return true;
  }
  static handle cast(const hecaton::Vector3& source, return_value_policy /*policy*/, handle /*parent*/) {
    const std::array<double, 3> numbers{source.x, source.y, source.z};
    return hecaton::python::array_of(numbers).release();
  }
};

}  // namespace pybind11::detail
