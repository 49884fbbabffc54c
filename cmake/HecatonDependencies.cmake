# Third-party libraries, as Debian 12 and Debian 13 package them. Each is wrapped in a target of ours, so that the folder which may
# use it says so by linking it, and its warnings stay its own (SYSTEM includes).
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fcl REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(assimp REQUIRED)
find_package(fastcdr REQUIRED)
# Fast DDS 3 (Debian 13), or else 2 (Debian 12). services/bus/fastdds.hpp hides what differs in C++, idl/ what is generated.
find_package(fastdds 3 QUIET)
if(fastdds_FOUND)
  set(HECATON_FAST_DDS 3)
else()
  find_package(fastrtps REQUIRED)
  set(HECATON_FAST_DDS 2)
endif()
pkg_check_modules(BULLET REQUIRED IMPORTED_TARGET bullet-float64)
pkg_check_modules(URDFDOM REQUIRED IMPORTED_TARGET urdfdom)
# urdfdom reports errors through console_bridge; its own pkg-config file names it in Debian 12 only.
pkg_check_modules(CONSOLE_BRIDGE REQUIRED IMPORTED_TARGET console_bridge)
pkg_check_modules(QHULL REQUIRED IMPORTED_TARGET qhull_r)
pkg_check_modules(TINYXML2 REQUIRED IMPORTED_TARGET tinyxml2)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd) # recordings
find_package(ZLIB REQUIRED)
find_package(OpenSSL 3 REQUIRED COMPONENTS Crypto SSL)

# The off-line stage of motion strategies is a program and a package of its own: hecaton-strategies.
pkg_check_modules(NLOPT IMPORTED_TARGET nlopt_cxx)
set(MPI_CXX_SKIP_MPICXX ON) # its C++ bindings are not used
find_package(MPI COMPONENTS CXX)
find_package(Boost CONFIG) # headers only: Boost.Math; Boost.Beast for hecaton-view
if(NOT Boost_FOUND)
  message(FATAL_ERROR "Boost's headers were not found; hecaton-view needs them: install libboost-dev")
endif()
if(NLOPT_FOUND AND MPI_CXX_FOUND AND Boost_FOUND)
  set(strategies_possible ON)
else()
  set(strategies_possible OFF)
endif()
option(HECATON_STRATEGIES "Build hecaton-strategies (needs NLopt, Open MPI and Boost's headers)" ${strategies_possible})
if(HECATON_STRATEGIES AND NOT strategies_possible)
  message(FATAL_ERROR "HECATON_STRATEGIES is ON, but NLopt (nlopt_cxx), MPI or Boost was not found; install "
                      "libnlopt-dev libnlopt-cxx-dev libopenmpi-dev libboost-dev, or set HECATON_STRATEGIES=OFF")
endif()

# Debian's fcl carries no -march, so neither may a file that passes Eigen types to it.
add_library(hecaton_eigen INTERFACE)
target_link_libraries(hecaton_eigen INTERFACE Eigen3::Eigen)

add_library(hecaton_bullet INTERFACE)
target_link_libraries(hecaton_bullet INTERFACE PkgConfig::BULLET)
target_include_directories(hecaton_bullet SYSTEM INTERFACE ${BULLET_INCLUDE_DIRS})

add_library(hecaton_urdfdom INTERFACE)
target_link_libraries(hecaton_urdfdom INTERFACE PkgConfig::URDFDOM PkgConfig::CONSOLE_BRIDGE PkgConfig::TINYXML2)

add_library(hecaton_boost INTERFACE)
target_link_libraries(hecaton_boost INTERFACE Boost::headers)

add_library(hecaton_dds INTERFACE)
target_link_libraries(hecaton_dds INTERFACE $<IF:$<EQUAL:${HECATON_FAST_DDS},3>,fastdds,fastrtps> fastcdr)

add_library(hecaton_zstd INTERFACE)
target_link_libraries(hecaton_zstd INTERFACE PkgConfig::ZSTD ZLIB::ZLIB)
