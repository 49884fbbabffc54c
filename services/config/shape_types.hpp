#pragma once
/// The types of obstacle shapes that sizes describe: values of the key `type` in the cell file, and options of `hecaton
/// obstacle add`. How to add one: docs/how-to/add-an-obstacle-shape.md.

#include <span>
#include <string_view>
#include <vector>

#include "services/config/text.hpp"
#include "world/model/shape.hpp"

namespace hecaton::config {

/// The smallest size of a shape [m], as thin as a sheet of paper: distances to flatter shapes are ill-conditioned.
inline constexpr double kThinnest = 1e-4;

/// A size of a shape: a length, and a key of the shape's map.
struct ShapeSize {
  std::string_view key;      ///< in the cell file
  double least = kThinnest;  ///< [m]

  [[nodiscard]] Bounds bounds() const { return {least, kFarthest, "m"}; }  ///< of its values
};

/// One type of shapes, and how to make them.
struct ShapeType {
  std::string_view name;         ///< value of `type`; "box", "mesh" and "points" are taken
  std::string_view description;  ///< of the sizes, for help texts
  std::vector<ShapeSize> sizes;  ///< at least one
  /// The shape in its own frame S, from a value for each of `sizes`, in their order and within their bounds [m]. Throws
  /// std::invalid_argument with a sentence if there is no such shape.
  world::Shape (*make)(std::span<const double> sizes);
};

/// The types of Hecaton. A program with own types copies them, adds its types, and loads its cell with the copy.
/// Thread-safe.
[[nodiscard]] const std::vector<ShapeType>& shape_types();

/// Checks the sizes and makes the shape. Throws std::invalid_argument with a sentence: "radius = 0 m must be …".
[[nodiscard]] world::Shape make_shape(const ShapeType& type, std::span<const double> sizes);

}  // namespace hecaton::config
