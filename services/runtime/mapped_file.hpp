#pragma once
/// A file of a fixed size, mapped into memory: what is written there is there for a successor however suddenly the
/// process ends, and writing costs a copy. It is not meant to survive the machine.

#include <cstddef>
#include <string>

namespace hecaton::services {

class MappedFile {
 public:
  /// Of `size` bytes, zero where there was nothing. All of it is reserved now: on a full disk, whoever wrote to a page
  /// that has no place yet would be killed. An empty path: there is none. Throws std::runtime_error with a sentence
  /// that begins with the path when the file cannot be used; `what` was to be kept in it.
  MappedFile(const std::string& path, std::size_t size, const std::string& what);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] void* data() const { return data_; }  ///< null: there is none

 private:
  void* data_ = nullptr;
  std::size_t size_;
};

}  // namespace hecaton::services
