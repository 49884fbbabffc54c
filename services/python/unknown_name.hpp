#pragma once
/// The exception for a name that a cell does not have.

#include <string>
#include <utility>

#include <hecaton/client.hpp>

namespace hecaton::python {

/// A name that the cell does not have.
class UnknownName : public InvalidArgument {
 public:
  UnknownName(const std::string& sentence, std::string name) : InvalidArgument(sentence), name_(std::move(name)) {}
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
};

}  // namespace hecaton::python
