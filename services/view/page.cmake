# The page: TypeScript that esbuild bundles, packed into a C++ source (page/build.mjs). npm brings exactly what
# page/package-lock.json lists; nothing of it is needed when the program runs. Without npm the program is built without
# its page, and says so.
find_program(HECATON_NPM npm)
find_program(HECATON_NODE NAMES node nodejs)
if(HECATON_NPM AND HECATON_NODE)
  set(page_possible ON)
else()
  set(page_possible OFF)
endif()
option(HECATON_VIEW_PAGE "Build the page of hecaton-view (needs nodejs and npm, and npm's registry once)" ${page_possible})
if(HECATON_VIEW_PAGE AND NOT page_possible)
  message(FATAL_ERROR "HECATON_VIEW_PAGE is ON, but node or npm was not found; install nodejs and npm, "
                      "or set HECATON_VIEW_PAGE=OFF for a hecaton-view without its page")
endif()

set(packed_page ${CMAKE_CURRENT_BINARY_DIR}/packed_page.cpp)
if(HECATON_VIEW_PAGE)
  set(page ${CMAKE_CURRENT_BINARY_DIR}/page)
  file(GLOB_RECURSE page_sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/page
       ${CMAKE_CURRENT_SOURCE_DIR}/page/src/* ${CMAKE_CURRENT_SOURCE_DIR}/page/test/*)
  list(APPEND page_sources build.mjs tsconfig.json)
  set(copies)
  foreach(file ${page_sources} package.json package-lock.json .npmrc)
    add_custom_command(OUTPUT ${page}/${file} DEPENDS page/${file}
                       COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_CURRENT_SOURCE_DIR}/page/${file} ${page}/${file})
  endforeach()
  list(TRANSFORM page_sources PREPEND ${page}/)
  # Two attempts: the registry is another machine.
  set(install ${HECATON_NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error)
  string(JOIN " " install_text ${install})
  set(hint "npm could not install what the page of hecaton-view needs, see above. Build without the page: cmake -DHECATON_VIEW_PAGE=OFF")
  add_custom_command(
    OUTPUT ${page}/installed
    COMMAND sh -c "${install_text} || ${install_text} || { echo '${hint}' >&2; exit 1; }"
    COMMAND ${CMAKE_COMMAND} -E touch ${page}/installed
    DEPENDS ${page}/package.json ${page}/package-lock.json ${page}/.npmrc
    WORKING_DIRECTORY ${page}
    COMMENT "Installing what the page of hecaton-view is built with"
    VERBATIM)
  add_custom_command(
    OUTPUT ${packed_page}
    COMMAND ${HECATON_NODE} build.mjs --pack ${packed_page}
    DEPENDS ${page}/installed ${page_sources}
    WORKING_DIRECTORY ${page}
    COMMENT "Bundling the page of hecaton-view"
    VERBATIM)
else()
  message(STATUS "hecaton-view is built without its page: nodejs or npm was not found, or HECATON_VIEW_PAGE is OFF")
  file(CONFIGURE OUTPUT ${packed_page} CONTENT [[
#include "services/view/page.hpp"
std::span<const hecaton::services::view::PackedFile> hecaton::services::view::packed_files() { return {}; }
]] @ONLY)
endif()
hecaton_library(hecaton_page SOURCES page.cpp ${packed_page})
