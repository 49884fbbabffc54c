#pragma once
/// Checks of a Collada file that assimp 5.2 does not make before it reads it. Assimp reads a list of indices without
/// end where something else than a number stands in it. It follows a node that is inside itself without end. It needs
/// the size of each array.

#include <string>

#include <tinyxml2.h>

namespace hecaton::planner {

/// Throws ModelError, with a sentence that begins with `mesh`, for a file that assimp would not survive.
void check_collada(const tinyxml2::XMLElement& root, const std::string& mesh);

}  // namespace hecaton::planner
