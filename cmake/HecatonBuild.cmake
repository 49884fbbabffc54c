# How every target of the project is compiled, in one place.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
# Programs and the Python package find robots by name in share/hecaton/robots, as they do when they are installed.
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/share/hecaton)
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/deploy/robots ${CMAKE_BINARY_DIR}/share/hecaton/robots SYMBOLIC)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(HECATON_CCACHE ccache)
if(HECATON_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${HECATON_CCACHE})
endif()

# Some hundred programs with debug lines are linked: these need half the time and less of what g++ takes by itself.
find_program(HECATON_LINKER NAMES ld.lld ld.gold)
if(HECATON_LINKER MATCHES "lld$")
  add_link_options(-fuse-ld=lld)
elseif(HECATON_LINKER)
  add_link_options(-fuse-ld=gold)
endif()

# Bit-identical simulations need one arithmetic: no contraction chosen per expression, no fast-math.
add_compile_options(-ffp-contract=off)

if(HECATON_SANITIZE)
  add_compile_options(-fsanitize=${HECATON_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${HECATON_SANITIZE})
endif()

if(HECATON_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

add_library(hecaton_warnings INTERFACE)
# -Wrestrict: g++ 12 invents overlaps in "text" + std::string (its bug 105651).
target_compile_options(hecaton_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                       -Woverloaded-virtual -Wconversion -Wno-sign-conversion -Wno-restrict $<$<BOOL:${HECATON_WERROR}>:-Werror>)
# g++ 13 and 14 invent such accesses in inlined vectors of Eigen and of the standard library (GCC bug 56456). They also take a part
# of one argument for a part of a temporary in another. Still warnings there, they are errors with g++ 12.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  target_compile_options(hecaton_warnings INTERFACE -Wno-error=array-bounds -Wno-error=maybe-uninitialized -Wno-error=stringop-overflow
                         -Wno-error=dangling-reference)
endif()
# What is anonymous in a source stays so when sources are compiled together.
target_compile_options(hecaton_warnings INTERFACE $<$<AND:$<BOOL:${HECATON_UNITY}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>)

# Most of the time goes into headers (Fast DDS, CLI11, GoogleTest): parsed once for eight sources, not for each.
set(HECATON_UNITY_TARGETS UNITY_BUILD ${HECATON_UNITY} UNITY_BUILD_BATCH_SIZE 8)
# And those that most tests include are parsed once for all tests, which saves a third of what compiling them takes.
if(HECATON_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(HECATON_PRECOMPILED_HEADERS ON)
  if(HECATON_CCACHE)
    # As the manual of ccache asks for precompiled headers.
    set(HECATON_CCACHE_OF_TESTS ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${HECATON_CCACHE})
  endif()
endif()

# hecaton_library(name [WAITS] SOURCES a.cpp … [PUBLIC libs…] [PRIVATE libs…]): a static library of ours; headers are included
# from the project's root ("planner/qp/dense_qp.hpp"). WAITS: most of the time it waits for networks, files or people. Compiling it
# takes a third less time so.
function(hecaton_library name)
  cmake_parse_arguments(ARG "WAITS" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  if(ARG_SOURCES)
    add_library(${name} STATIC ${ARG_SOURCES})
    target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} PUBLIC ${ARG_PUBLIC} PRIVATE hecaton_warnings ${ARG_PRIVATE})
    set_target_properties(${name} PROPERTIES ${HECATON_UNITY_TARGETS})
    if(ARG_WAITS)
      target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    endif()
  else()
    add_library(${name} INTERFACE)
    target_include_directories(${name} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} INTERFACE ${ARG_PUBLIC})
  endif()
endfunction()

# hecaton_lane_sources(library a.cpp …): sources that compute in lanes, added to the library once for each instruction set
# (planner/simd). Lanes never cross a call that is not inlined: it does not matter how a call would pass them (psabi).
function(hecaton_lane_sources library)
  foreach(isa baseline avx2)
    add_library(${library}_${isa} OBJECT ${ARGN})
    target_include_directories(${library}_${isa} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${library}_${isa} PRIVATE hecaton_warnings)
    target_compile_definitions(${library}_${isa} PRIVATE HECATON_ISA=${isa})
    target_compile_options(${library}_${isa} PRIVATE -fno-math-errno -Wno-psabi)
    target_sources(${library} PRIVATE $<TARGET_OBJECTS:${library}_${isa}>)
  endforeach()
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    target_compile_options(${library}_avx2 PRIVATE -mavx2)
  endif()
endfunction()

# hecaton_float_lane_sources(library a.cpp …): sources that compute in lanes of floats (planner/simd/float_lanes.hpp), added to
# the library once for each width. They may fuse products and sums: results differ in the last bits between widths.
function(hecaton_float_lane_sources library)
  set(flags_lanes4 "")
  set(flags_lanes8 "")
  set(flags_lanes16 "")
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(flags_lanes8 -mavx2 -mfma)
    # GCC 12 warns of its own header (bug 105593).
    set(flags_lanes16 -mavx2 -mfma -mavx512f -mavx512dq -mavx512bw -mavx512vl -Wno-maybe-uninitialized)
  endif()
  foreach(isa lanes4 lanes8 lanes16)
    add_library(${library}_${isa} OBJECT ${ARGN})
    target_include_directories(${library}_${isa} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${library}_${isa} PRIVATE hecaton_warnings)
    target_compile_definitions(${library}_${isa} PRIVATE HECATON_ISA=${isa})
    target_compile_options(${library}_${isa} PRIVATE -fno-math-errno -fno-trapping-math -ffp-contract=fast -Wno-psabi ${flags_${isa}})
    target_sources(${library} PRIVATE $<TARGET_OBJECTS:${library}_${isa}>)
  endforeach()
endfunction()

# hecaton_executable(name SOURCES … LIBS …)
function(hecaton_executable name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE hecaton_warnings ${ARG_LIBS})
endfunction()

# Compiles `name` with the headers of tests/support/precompiled_headers.hpp, parsed once for all tests: by hecaton_test_headers.
function(hecaton_precompile name)
  if(NOT HECATON_PRECOMPILED_HEADERS)
    return()
  endif()
  # With precompiled headers g++ 12 warns of accesses in std::string that it invents.
  target_compile_options(${name} PRIVATE -fpch-preprocess -Winvalid-pch -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread
                         -Wno-maybe-uninitialized)
  if(HECATON_CCACHE_OF_TESTS)
    set_target_properties(${name} PROPERTIES CXX_COMPILER_LAUNCHER "${HECATON_CCACHE_OF_TESTS}")
  endif()
  if(name STREQUAL hecaton_test_headers)
    target_precompile_headers(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/precompiled_headers.hpp)
  else()
    target_precompile_headers(${name} REUSE_FROM hecaton_test_headers)
  endif()
endfunction()

# hecaton_test(name [UNITY] [THREADS] [ALONE] SOURCES … LIBS … [LABEL l] [TIMEOUT s] [LEFT_OUT suite] [BESIDE case] [ALONE_CASE case]).
# One GoogleTest executable, one CTest entry a case, but for those of the suite that is left out: they run when the executable is started by hand.
# HECATON_SOURCE_DIR tells tests where the tree is (cells, URDFs). UNITY: its files' helpers have names of their own,
# which halves what compiling them takes.
# ALONE: no other test runs beside its cases, but for the case BESIDE, which only waits. ALONE_CASE: beside this case.
# THREADS: it, or what it starts, has several threads; ThreadSanitizer runs these (target threaded_tests, label threads).
add_custom_target(threaded_tests)
function(hecaton_test name)
  cmake_parse_arguments(ARG "UNITY;THREADS;ALONE" "TIMEOUT;LABEL;LEFT_OUT;BESIDE;ALONE_CASE" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE hecaton_warnings ${ARG_LIBS} GTest::gtest GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE HECATON_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                             HECATON_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  # A test runs for a moment: compiling it takes a third less time so, and the libraries under test keep their flags.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  hecaton_precompile(${name})
  if(ARG_UNITY)
    set_target_properties(${name} PROPERTIES ${HECATON_UNITY_TARGETS})
  endif()
  if(ARG_THREADS)
    set(ARG_LABEL threads)
    add_dependencies(threaded_tests ${name})
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set(filter)
  if(ARG_LEFT_OUT)
    set(filter TEST_FILTER "-${ARG_LEFT_OUT}.*")
  elseif(ARG_BESIDE)
    set(filter TEST_FILTER "-${ARG_BESIDE}")
    gtest_discover_tests(${name} TEST_FILTER ${ARG_BESIDE} TEST_LIST ${name}_beside DISCOVERY_TIMEOUT 120
                         PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABEL}")
  elseif(ARG_ALONE_CASE)
    set(filter TEST_FILTER "-${ARG_ALONE_CASE}")
    gtest_discover_tests(${name} TEST_FILTER ${ARG_ALONE_CASE} TEST_LIST ${name}_alone DISCOVERY_TIMEOUT 120
                         PROPERTIES TIMEOUT ${ARG_TIMEOUT} RUN_SERIAL TRUE LABELS "${ARG_LABEL}")
  endif()
  set(alone)
  if(ARG_ALONE)
    set(alone RUN_SERIAL TRUE)
  endif()
  gtest_discover_tests(${name} ${filter} DISCOVERY_TIMEOUT 120
                       PROPERTIES TIMEOUT ${ARG_TIMEOUT} ${alone} LABELS "${ARG_LABEL}")
endfunction()
