# Writes a C++ source with the text of each message file, included files pasted in their places and preprocessor lines left
# out. usage: cmake -DIDL=FOLDER -DNAMES=arm,goal -DOUT=FILE.cpp -P embed_idl.cmake
cmake_minimum_required(VERSION 3.25)
function(expand name)
  if(name IN_LIST seen)
    return()
  endif()
  list(APPEND seen ${name})
  file(READ ${IDL}/${name}.idl content)
  string(REGEX MATCHALL "#include \"[a-z_]+" includes "${content}")
  foreach(include ${includes})
    string(REGEX REPLACE "#include \"" "" include "${include}")
    expand(${include})
  endforeach()
  string(REGEX REPLACE "(^|\n)#[^\n]*" "" content "${content}")
  set(text "${text}${content}\n" PARENT_SCOPE)
  set(seen "${seen}" PARENT_SCOPE)
endfunction()

string(REPLACE "," ";" names "${NAMES}")
set(rows "")
foreach(name ${names})
  set(seen "")
  set(text "")
  expand(${name})
  string(APPEND rows "    R\"idl(${text})idl\",\n")
endforeach()
file(WRITE ${OUT} "// Written by embed_idl.cmake.
#include \"services/recorder/message_schema.hpp\"

namespace hecaton::services::recorder {
std::span<const std::string_view> message_files() {
  static constexpr std::string_view kFiles[] = {
${rows}  };
  return kFiles;
}
}  // namespace hecaton::services::recorder
")
