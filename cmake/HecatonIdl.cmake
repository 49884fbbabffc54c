# Messages: C++ from IDL, and the topics of folders outside of services/.
find_program(HECATON_FASTDDSGEN fastddsgen REQUIRED)
add_custom_target(generated_messages) # all generated headers

# hecaton_idl_library(library [ROS2] NAME…): the messages of NAME.idl in the calling folder, with ROS2 under the type names
# of ROS 2. fastddsgen writes their C++ into the
# build tree. Include "FOLDER/NAME.h" for the values, without DDS; FOLDER is the calling folder below the project's root.
# Only services/bus includes "FOLDER/NAMEPubSubTypes.h", their serialisation.
#
# fastddsgen 4 writes "NAME.hpp", to which a "NAME.h" of ours leads: one name for both releases. It would put files into
# folders named after the path, and describe each type a second time for peers that do not know it.
function(hecaton_idl_library library)
  cmake_parse_arguments(ARG "ROS2" "" "" ${ARGN})
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/idl/${folder})
  # Preprocessed files: by default in /tmp under fixed names, where two builds at the same time would mix them up.
  set(scratch ${CMAKE_CURRENT_BINARY_DIR}/preprocessed)
  file(MAKE_DIRECTORY ${generated} ${scratch})
  set(options -cs -replace)
  if(ARG_ROS2)
    list(APPEND options -typeros2)
  endif()
  if(HECATON_FAST_DDS EQUAL 3)
    list(APPEND options -flat-output-dir -no-dependencies -no-typeobjectsupport)
  endif()
  foreach(name ${ARG_UNPARSED_ARGUMENTS})
    list(APPEND files ${CMAKE_CURRENT_SOURCE_DIR}/${name}.idl)
    list(APPEND sources ${generated}/${name}PubSubTypes.cxx)
    if(HECATON_FAST_DDS EQUAL 3)
      foreach(header ${name} ${name}PubSubTypes)
        list(APPEND headers ${generated}/${header}.hpp)
        file(CONFIGURE OUTPUT ${generated}/${header}.h CONTENT "#include \"${header}.hpp\"\n")
      endforeach()
    else()
      list(APPEND headers ${generated}/${name}.h ${generated}/${name}PubSubTypes.h)
      list(APPEND sources ${generated}/${name}.cxx)
    endif()
  endforeach()
  # One run for all files: starting Java costs more than generating. -cs: names may equal keywords in another case.
  add_custom_command(
    OUTPUT ${headers} ${sources}
    COMMAND ${HECATON_FASTDDSGEN} ${options} -I ${CMAKE_CURRENT_SOURCE_DIR} -t ${scratch} -d ${generated} ${files}
    DEPENDS ${files}
    WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}
    COMMENT "Generating the messages from ${folder}/"
    VERBATIM)
  add_custom_target(${library}_generate DEPENDS ${headers} ${sources})
  add_library(${library} STATIC ${sources})
  add_dependencies(${library} ${library}_generate)
  add_dependencies(generated_messages ${library}_generate)
  target_include_directories(${library} SYSTEM PUBLIC ${CMAKE_CURRENT_BINARY_DIR}/idl)
  target_compile_options(${library} PRIVATE -w)
  target_link_libraries(${library} PUBLIC hecaton_dds)
endfunction()

# hecaton_topics(library IDL NAME… HEADER topic.hpp TYPES name::space::Type…): a library with Writer and Reader of the types
# in NAME.idl. HEADER, in the calling folder, has the Topic of each type. docs/how-to/add-a-topic.md explains it.
function(hecaton_topics library)
  cmake_parse_arguments(ARG "" "HEADER" "IDL;TYPES" ${ARGN})
  foreach(needed IDL HEADER TYPES)
    if(NOT ARG_${needed})
      message(FATAL_ERROR "hecaton_topics(${library} …) has no ${needed}")
    endif()
  endforeach()
  hecaton_idl_library(${library}_messages ${ARG_IDL})
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(lines "")
  foreach(name ${ARG_IDL})
    string(APPEND lines "#include <${folder}/${name}PubSubTypes.h>\n")
  endforeach()
  string(APPEND lines "#include \"${folder}/${ARG_HEADER}\"\n#include \"services/bus/endpoint_definition.hpp\"\n")
  foreach(type ${ARG_TYPES})
    string(APPEND lines "HECATON_DEFINE_TOPIC(${type})\n")
  endforeach()
  set(source ${CMAKE_CURRENT_BINARY_DIR}/idl/${library}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "${lines}" @ONLY)
  hecaton_library(${library} SOURCES ${source} PUBLIC ${library}_messages hecaton_bus)
endfunction()
