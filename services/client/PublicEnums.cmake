# hecaton_public_enum(FILE IDL_NAME PREFIX NAME "sentence"): appends to HECATON_PUBLIC_ENUMS the enumeration of idl/FILE.idl in
# the public library's spelling (PREFIX_TIMED_OUT → kTimedOut) with its comments, and name_of() for it ("timed_out").
function(hecaton_public_enum file idl_name prefix name sentence)
  set(path ${PROJECT_SOURCE_DIR}/idl/${file}.idl)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${path})
  file(READ ${path} text)
  if(NOT text MATCHES "enum ${idl_name} {([^}]*)}")
    message(FATAL_ERROR "idl/${file}.idl has no enumeration ${idl_name}")
  endif()
  set(body "${CMAKE_MATCH_1}")
  string(REGEX REPLACE "([A-Z],?) +//" "\\1  ///<" body "${body}")
  string(REGEX MATCHALL "${prefix}_[A-Z0-9_]+" tokens "${body}")
  list(REMOVE_DUPLICATES tokens)
  set(names "")
  foreach(token IN LISTS tokens)
    string(REGEX REPLACE "^${prefix}_" "" rest ${token})
    string(TOLOWER ${rest} word)
    string(APPEND names "\"${word}\", ")
    string(REPLACE "_" ";" parts ${word})
    set(camel k)
    foreach(part IN LISTS parts)
      string(SUBSTRING ${part} 0 1 first)
      string(SUBSTRING ${part} 1 -1 others)
      string(TOUPPER ${first} first)
      string(APPEND camel ${first}${others})
    endforeach()
    string(REGEX REPLACE "${token}([^A-Z0-9_])" "${camel}\\1" body "${body}")
  endforeach()
  list(LENGTH tokens count)
  string(APPEND HECATON_PUBLIC_ENUMS "
/// ${sentence}
enum class ${name} : std::uint32_t {${body}};
/// The name in lower case; \"unknown\" for a value of a later version.
[[nodiscard]] constexpr std::string_view name_of(${name} value) {
  constexpr std::array<std::string_view, ${count}> kNames{${names}};
  const auto index = static_cast<std::size_t>(value);
  return index < kNames.size() ? kNames[index] : \"unknown\";
}
")
  set(HECATON_PUBLIC_ENUMS "${HECATON_PUBLIC_ENUMS}" PARENT_SCOPE)
endfunction()
