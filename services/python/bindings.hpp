#pragma once
/// The parts of the module `_hecaton`. Each adds its classes.

#include <pybind11/pybind11.h>

namespace hecaton::python {

void bind_values(pybind11::module_& module);   ///< values of <hecaton/types.hpp>
void bind_session(pybind11::module_& module);  ///< Session and NativeGoal: a running cell
void bind_offline(pybind11::module_& module);  ///< a cell file without a network

}  // namespace hecaton::python
