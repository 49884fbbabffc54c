/// The module `_hecaton`, which the Python package `hecaton` wraps.

#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <hecaton/client.hpp>
#include <pybind11/pybind11.h>

#include "planner/model/source_file.hpp"
#include "services/config/yaml_tree.hpp"
#include "services/python/bindings.hpp"
#include "services/python/session.hpp"
#include "services/python/unknown_name.hpp"

namespace hecaton::python {
namespace {

namespace py = pybind11;

/// Raises the class `name` of hecaton.errors.
void raise(const char* name, const std::string& text, std::string_view kind, const std::string& subject) {
  const py::object type = py::module_::import("hecaton.errors").attr(name);
  PyErr_SetObject(type.ptr(), type(text, std::string(kind), subject).ptr());
}

void translate(std::exception_ptr exception) {
  try {
    std::rethrow_exception(std::move(exception));
  } catch (const Rejected& error) {
    raise("Rejected", error.what(), name_of(error.cause().kind), error.cause().subject);
  } catch (const Unreachable& error) {
    raise("Unreachable", error.what(), "unreachable", error.reason().looked_for);
  } catch (const NoAnswer& error) {
    raise("NoAnswer", error.what(), "no_answer", "world");
  } catch (const Closed& error) {
    raise("Closed", error.what(), "closed", "");
  } catch (const Forked& error) {
    raise("Closed", error.what(), "forked", "");
  } catch (const UnknownName& error) {
    raise("InvalidArgument", error.what(), "unknown_name", error.name());
  } catch (const InvalidArgument& error) {
    raise("InvalidArgument", error.what(), "invalid_value", "");
  } catch (const Error& error) {
    raise("Error", error.what(), "interrupted", "");
  } catch (const config::ConfigError& error) {
    raise("InvalidArgument", error.what(), "invalid_cell_file", "");
  } catch (const planner::ModelError& error) {
    raise("InvalidArgument", error.what(), "invalid_cell_file", "");
  } catch (const std::invalid_argument& error) {
    raise("InvalidArgument", error.what(), "invalid_value", "");
  }
}

}  // namespace
}  // namespace hecaton::python

PYBIND11_MODULE(_hecaton, module) {
  module.doc() = "Native part of the package hecaton.";
  module.attr("VERSION") = HECATON_VERSION;
  pybind11::register_exception_translator(&hecaton::python::translate);
  hecaton::python::bind_values(module);
  hecaton::python::bind_session(module);
  hecaton::python::bind_offline(module);
}
